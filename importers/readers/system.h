// SPDX-License-Identifier: Apache-2.0
// What readers ask the operating system for beyond C++'s own library, in two forms: system/posix.cpp and
// system/windows.cpp. Texts of the tool are UTF-8 everywhere, paths too.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string>

namespace bcc4 {

// Returns the path that a text in UTF-8 names.
[[nodiscard]] inline std::filesystem::path to_path(const std::string& text) {
  return {std::u8string(text.begin(), text.end())};
}
// Returns the text of a path, in UTF-8 with slashes.
[[nodiscard]] inline std::string to_text(const std::filesystem::path& path) {
  std::u8string text = path.u8string();
  if constexpr (std::filesystem::path::preferred_separator != '/')
    std::replace(text.begin(), text.end(), u8'\\', u8'/');
  return {text.begin(), text.end()};
}

// Returns the machine's memory in bytes; 0 where the system does not tell.
[[nodiscard]] uint64_t machine_memory();
// Makes an empty folder for temporary files and returns its path; empty where none can be made.
[[nodiscard]] std::string make_temporary_folder();
// Returns whether a name fits a shell's wildcards (* ? [a-z]); a leading dot is matched by a dot alone.
[[nodiscard]] bool fits_wildcards(const std::string& wildcards, const std::string& name);

} // namespace bcc4

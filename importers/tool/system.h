// SPDX-License-Identifier: Apache-2.0
// What the tool asks the operating system for beyond C++'s own library, in two forms: system/posix.cpp and
// system/windows.cpp.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace bcc4 {

// Sets up the console and returns the arguments in UTF-8, the name of the program first.
[[nodiscard]] std::vector<std::string> command_line_words(int argc, char** argv);
[[nodiscard]] bool stderr_is_terminal();
// Returns a number that no other process has now.
[[nodiscard]] int64_t process_number();
// Returns the folder of the program that runs.
[[nodiscard]] std::filesystem::path program_folder();
// Returns whether files can be made in a folder; errno says why not.
[[nodiscard]] bool folder_is_writable(const std::filesystem::path& folder);
// Returns the most memory that this process had, in bytes.
[[nodiscard]] uint64_t peak_memory();
// Returns whether an error of a write means that a disk is full, or what the user may have of it.
[[nodiscard]] bool is_disk_full(int error);

} // namespace bcc4

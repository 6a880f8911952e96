// SPDX-License-Identifier: Apache-2.0
// Texts between UTF-8, which the library speaks, and UTF-16, which Windows does.
#pragma once

#include <string>

namespace bccsplat {

// Returns the text in UTF-16; bytes that belong to no character become U+FFFD.
[[nodiscard]] std::wstring to_wide(const std::string& text);
// Returns the path in UTF-16. One of more than 259 characters becomes absolute, in the form that has no limit
// (\\?\).
[[nodiscard]] std::wstring to_wide_path(const std::string& path);
// Returns what Windows says of an error, in UTF-8, without the line end.
[[nodiscard]] std::string windows_error_text(unsigned long error);

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Texts in UTF-8.
#pragma once

#include <string>
#include <string_view>

namespace bccsplat {

// Returns whether the text is UTF-8 without zero bytes.
[[nodiscard]] bool is_utf8(std::string_view text);
// Returns the text with U+FFFD in the place of each byte that belongs to no character.
[[nodiscard]] std::string to_utf8(std::string_view bytes);

} // namespace bccsplat

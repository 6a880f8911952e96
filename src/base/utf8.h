// SPDX-License-Identifier: Apache-2.0
// Texts in UTF-8, and others as such.
#pragma once

#include <string>
#include <string_view>

namespace bccsplat {

// Returns whether the text is UTF-8 without zero bytes.
[[nodiscard]] bool is_utf8(std::string_view text);
// Returns the text with U+FFFD in the place of each byte that belongs to no character.
[[nodiscard]] std::string to_utf8(std::string_view bytes);

// Length of the well-formed sequence that the text begins with; 0: none.
[[nodiscard]] inline size_t utf8_sequence(std::string_view text) {
  const auto at = [&](size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
  const unsigned first = at(0);
  if (first < 0x80) return first > 0;
  const size_t length = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  if (first < 0xc2 || first > 0xf4) return 0;
  for (size_t i = 1; i < length; ++i)
    if (at(i) < 0x80 || at(i) > 0xbf) return 0;
  // Neither longer than need be, nor halves of UTF-16, nor beyond the last character.
  const unsigned second = at(1);
  const bool wrong = (first == 0xe0 && second < 0xa0) || (first == 0xed && second > 0x9f) ||
                     (first == 0xf0 && second < 0x90) || (first == 0xf4 && second > 0x8f);
  return wrong ? 0 : length;
}

// A text that is no UTF-8 is taken for Latin-1, which is what older headers are mostly written in.
[[nodiscard]] inline std::string utf8_of(std::string_view text) {
  std::string_view rest = text;
  while (const size_t n = utf8_sequence(rest)) rest.remove_prefix(n);
  if (rest.empty()) return std::string(text);
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte == 0) break;
    if (byte >= 0x80) out += static_cast<char>(0xc0 | byte >> 6);
    out += static_cast<char>(byte >= 0x80 ? 0x80 | (byte & 0x3f) : byte);
  }
  return out;
}

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Builds text with numbers as people write them: base/text.h has them as short as can be read back.
#pragma once

#include <charconv>
#include <concepts>
#include <string>
#include <string_view>

namespace bccsplat::series {

inline void append_text(std::string& out, std::string_view s) { out += s; }
inline void append_text(std::string& out, char c) { out += c; }
template<std::integral I>
requires(!std::same_as<I, char> && !std::same_as<I, bool>) void append_text(std::string& out, I value) {
  char buffer[24];
  out.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr);
}
// Returns whether people write a number out that came as `text`: 100000, not 1e+05.
[[nodiscard]] bool written_out(double value, std::string_view text);
// Appends the shortest form that reads back as the same number, without an exponent where people use none.
template<std::floating_point F> void append_text(std::string& out, F value) {
  char buffer[64];
  std::string_view text(buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr);
  if (written_out(value, text))
    text = {buffer, std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed).ptr};
  out += text;
}
template<class... Parts> [[nodiscard]] std::string concat(const Parts&... parts) {
  std::string out;
  (append_text(out, parts), ...);
  return out;
}

// Returns `value` with `digits` significant digits, and all digits before the point.
[[nodiscard]] std::string short_number(double value, int digits = 4);

} // namespace bccsplat::series

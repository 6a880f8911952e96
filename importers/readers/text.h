// SPDX-License-Identifier: Apache-2.0
// Builds text, and reads numbers from it, without the locale.
#pragma once

#include <charconv>
#include <concepts>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace bcc4 {

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

// Returns the whole of `text` as a number (a leading + is allowed), or nothing.
template<class Number> [[nodiscard]] std::optional<Number> parse_number(std::string_view text) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

[[nodiscard]] inline bool is_digit(char c) { return c >= '0' && c <= '9'; }
[[nodiscard]] std::string_view trim(std::string_view text);
[[nodiscard]] std::string lower(std::string_view text);
// Returns the parts between separators; neighbouring separators count as one, empty parts are dropped.
[[nodiscard]] std::vector<std::string_view> split(std::string_view text,
                                                  std::string_view separators = " \t\r\n");
// Splits at commas and keeps empty parts.
[[nodiscard]] std::vector<std::string_view> split_commas(std::string_view text);
// Returns all parts as numbers, or nothing.
[[nodiscard]] std::optional<std::vector<double>> parse_numbers(std::span<const std::string_view> parts);

// Returns text such as "a, b and c".
[[nodiscard]] std::string join(std::span<const std::string> names, std::string_view last = " and ");
// Returns the candidate closest to `name` by edit distance (letter case free), "" when none is near.
[[nodiscard]] std::string nearest_name(std::string_view name, std::span<const std::string> candidates);
// Returns " (did you mean X?)" or "".
[[nodiscard]] std::string did_you_mean(std::string_view name, std::span<const std::string> candidates);

// Returns text such as "1.5 GiB".
[[nodiscard]] std::string byte_text(double bytes);
// Returns `value` with `digits` significant digits, and all digits before the point.
[[nodiscard]] std::string short_number(double value, int digits = 4);
// Returns the significant digits, `least` to 17, that tell values of this magnitude apart which differ by so
// much; `least` where they do not differ.
[[nodiscard]] int digits_apart(double magnitude, double difference, int least);

} // namespace bcc4

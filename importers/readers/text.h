// SPDX-License-Identifier: Apache-2.0
// Takes text apart and puts it together, and reads numbers from it, without the locale.
#pragma once

#include <charconv>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/utf8.h"
#include "series/text.h"

namespace bcc4 {

using bccsplat::utf8_of;
using namespace bccsplat::series;

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
// Returns the significant digits, `least` to 17, that tell values of this magnitude apart which differ by so
// much; `least` where they do not differ.
[[nodiscard]] int digits_apart(double magnitude, double difference, int least);

} // namespace bcc4

// SPDX-License-Identifier: Apache-2.0
// Numbers to and from text without the locale.
#pragma once

#include <charconv>
#include <concepts>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

namespace bccsplat {

inline void append_text(std::string& out, std::string_view s) { out += s; }
inline void append_text(std::string& out, char c) { out += c; }
template<std::integral I>
requires(!std::same_as<I, char> && !std::same_as<I, bool>) void append_text(std::string& out, I value) {
  char buffer[24];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
  out.append(buffer, end);
}
#if defined(__EMSCRIPTEN__)
// Writes the shortest form, of the double or, where `single`, of the float that it is: a browser has that,
// and a module is smaller without.
extern "C" void bccsplat_write_number(double value, int single, char* text);
#endif
// Appends the shortest form, by trial where the standard library has none that reads back as the same number.
template<std::floating_point F> void append_text(std::string& out, F value) {
  char buffer[64];
#if defined(__EMSCRIPTEN__)
  bccsplat_write_number(static_cast<double>(value), std::same_as<F, float> ? 1 : 0, buffer);
  out += buffer;
#elif defined(__cpp_lib_to_chars)
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
  out.append(buffer, end);
#else
  for (int digits = 1; digits <= std::numeric_limits<F>::max_digits10; ++digits) {
    std::snprintf(buffer, sizeof buffer, "%.*g", digits, static_cast<double>(value));
    if (static_cast<F>(std::strtod(buffer, nullptr)) == value) break;
  }
  out += buffer;
#endif
}

template<class... Parts> [[nodiscard]] std::string concat(const Parts&... parts) {
  std::string out;
  (append_text(out, parts), ...);
  return out;
}

// Returns the whole of `text` as a number, or nothing.
template<class Number> [[nodiscard]] std::optional<Number> parse_number(std::string_view text) {
  Number value{};
  const auto [ptr, ec] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (ec != std::errc{} || ptr != text.data() + text.size()) return std::nullopt;
  return value;
}

} // namespace bccsplat

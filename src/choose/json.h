// SPDX-License-Identifier: Apache-2.0
// Text of JSON, made of its parts.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "series/text.h"

namespace bccsplat::series {

// Numbers that are none are null; others have a point or an exponent, so that readers take them as floats.
[[nodiscard]] inline std::string json(double number) {
  if (!std::isfinite(number)) return "null";
  const std::string text = concat(number);
  return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}
[[nodiscard]] inline std::string json(uint64_t count) { return concat(count); }
[[nodiscard]] inline std::string json(bool said) { return said ? "true" : "false"; }
[[nodiscard]] inline std::string json(std::string_view text) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string out = "\"";
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (code < 0x20)
      out += concat("\\u00", digits[code >> 4], digits[code & 0xf]);
    else
      out += c == '"' || c == '\\' ? concat('\\', c) : concat(c);
  }
  return out + '"';
}
[[nodiscard]] inline std::string json(const char* text) { return json(std::string_view(text)); }

// The parts are JSON themselves.
[[nodiscard]] inline std::string json_list(const std::vector<std::string>& parts) {
  std::string out = "[";
  for (const std::string& part : parts) out += concat(out.size() > 1 ? "," : "", part);
  return out + ']';
}
template<class List> [[nodiscard]] std::string json_values(const List& values) {
  std::vector<std::string> parts;
  for (const auto& value : values) parts.push_back(json(value));
  return json_list(parts);
}
using JsonMembers = std::vector<std::pair<std::string_view, std::string>>;
[[nodiscard]] inline std::string json_object(const JsonMembers& members) {
  std::string out = "{";
  for (const auto& [key, value] : members) out += concat(out.size() > 1 ? "," : "", json(key), ':', value);
  return out + '}';
}

} // namespace bccsplat::series

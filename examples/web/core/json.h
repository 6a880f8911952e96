// SPDX-License-Identifier: Apache-2.0
// Objects of JSON, written name by name.
#pragma once

#include <cmath>
#include <span>
#include <string>
#include <string_view>

// Writes the shortest form: the browser does.
extern "C" void web_write_number(double value, char* text);

namespace web {

// Returns a number as JSON has it; what is not finite is null.
inline std::string json(double x) {
  char text[64];
  if (!std::isfinite(x)) return "null";
  web_write_number(x, text);
  return text;
}

inline std::string json(std::string_view s) {
  std::string out = "\"";
  for (const char c : s) {
    if (c == '"' || c == '\\') out += '\\';
    if (static_cast<unsigned char>(c) >= ' ') out += c;
  }
  return out + "\"";
}
inline std::string json(const char* s) { return json(std::string_view(s ? s : "")); }

template<class Number> std::string json(std::span<const Number> numbers) {
  std::string out = "[";
  for (const Number& n : numbers) out += (out.size() > 1 ? "," : "") + json(static_cast<double>(n));
  return out + "]";
}

class Object {
 public:
  template<class Value> Object& add(const char* name, const Value& value) { return put(name, json(value)); }
  // value: JSON already.
  Object& put(const char* name, const std::string& value) {
    text_ += (text_.size() > 1 ? "," : "") + json(name) + ":" + value;
    return *this;
  }
  [[nodiscard]] std::string text() const { return text_ + "}"; }

 private:
  std::string text_ = "{";
};

} // namespace web

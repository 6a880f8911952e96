// SPDX-License-Identifier: Apache-2.0
#include "series/text.h"

#include <cmath>

namespace bccsplat::series {

bool written_out(double value, std::string_view text) {
  return text.find("e+") != std::string_view::npos && std::abs(value) < 1e15;
}

std::string short_number(double value, int digits) {
  char buffer[64];
  std::string text(
      buffer, std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::general, digits).ptr);
  if (!written_out(value, text)) return text;
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed, 0).ptr};
}

} // namespace bccsplat::series

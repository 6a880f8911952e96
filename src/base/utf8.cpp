// SPDX-License-Identifier: Apache-2.0
#include "base/utf8.h"

namespace bccsplat {

bool is_utf8(std::string_view text) {
  while (!text.empty()) {
    const size_t n = utf8_sequence(text);
    if (n == 0) return false;
    text.remove_prefix(n);
  }
  return true;
}

std::string to_utf8(std::string_view bytes) {
  std::string out;
  while (!bytes.empty()) {
    const size_t n = utf8_sequence(bytes);
    if (n == 0)
      out += "\xef\xbf\xbd";
    else
      out += bytes.substr(0, n);
    bytes.remove_prefix(n == 0 ? 1 : n);
  }
  return out;
}

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
#include "readers/vti/base64.h"

#include <algorithm>

#include "readers/error.h"

namespace bcc4 {

Bytes take_base64(std::string_view& text, uint64_t bytes, const std::string& path) {
  Bytes out;
  if (bytes > text.size())
    fail_input(path, ": ", bytes, " bytes cannot come from ", text.size(), " characters");
  out.reserve(bytes + 2);
  uint32_t group = 0;
  int digits = 0;
  size_t i = 0;
  for (; i < text.size() && (out.size() < bytes || digits != 0); ++i) {
    const char c = text[i];
    uint32_t v = 0;
    if (c >= 'A' && c <= 'Z')
      v = c - 'A';
    else if (c >= 'a' && c <= 'z')
      v = c - 'a' + 26;
    else if (c >= '0' && c <= '9')
      v = c - '0' + 52;
    else if (c == '+')
      v = 62;
    else if (c == '/')
      v = 63;
    else if (c == '=')
      v = 64;
    else if (c == ' ' || c == '\n' || c == '\r' || c == '\t')
      continue;
    else
      fail_input(path, ": a character that is not base64");
    if (v == 64) { // the group holds digits - 1 bytes
      if (digits < 2) fail_input(path, ": misplaced base64 padding");
      group <<= 6 * (4 - digits);
      for (int b = 0; b < digits - 1; ++b) out.push_back(static_cast<std::byte>(group >> (16 - 8 * b)));
      while (i < text.size() && text[i] == '=') ++i;
      digits = 0;
      break;
    }
    group = group << 6 | v;
    if (++digits == 4) {
      for (int b = 0; b < 3; ++b) out.push_back(static_cast<std::byte>(group >> (16 - 8 * b)));
      digits = 0;
      group = 0;
    }
  }
  text.remove_prefix(std::min(i, text.size()));
  if (out.size() < bytes) fail_input(path, ": base64 data end after ", out.size(), " of ", bytes, " bytes");
  out.resize(bytes);
  return out;
}

} // namespace bcc4

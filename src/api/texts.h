// SPDX-License-Identifier: Apache-2.0
// Texts that a host hands in: UTF-8, as the header says. They come back as they were given, so that mending
// one would lose it.
#pragma once

#include <string_view>

#include "base/error.h"
#include "base/utf8.h"

namespace bccsplat::api {

// text: may be NULL.
inline void require_utf8(const char* text, std::string_view name) {
  if (text && !is_utf8(text)) fail(Code::invalid_argument, name, " is not UTF-8: ", to_utf8(text));
}

} // namespace bccsplat::api

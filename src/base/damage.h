// SPDX-License-Identifier: Apache-2.0
// Tells damage from what only happens to a call: bytes that are wrong stay so, those that a disk or stream
// fails to read may be whole, and want of memory or a cancel says nothing of any bytes.
#pragma once

#include "base/error.h"

namespace bccsplat {

// Returns whether bytes were asked for in vain.
[[nodiscard]] inline bool is_unreadable(Code code) {
  return code == Code::io_error || code == Code::permission_denied || code == Code::file_not_found;
}

// Returns whether bytes were read and are not what a file holds.
[[nodiscard]] inline bool is_damage(Code code) {
  return !is_unreadable(code) && code != Code::would_block && code != Code::cancelled &&
         code != Code::out_of_memory && code != Code::memory_budget && code != Code::internal;
}

} // namespace bccsplat

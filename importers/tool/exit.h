// SPDX-License-Identifier: Apache-2.0
// What the tool exits with.
#pragma once

#include "readers/error.h"

namespace bcc4 {

enum class Exit : int {
  ok = 0,
  check_failed = 1,
  usage = 2,
  bad_input = 3,
  no_resources = 4, // disk or memory
  interrupted = 130
};

[[nodiscard]] constexpr Exit exit_of(Code code) {
  switch (code) {
  case Code::ok:
    return Exit::ok;
  case Code::cancelled:
    return Exit::interrupted;
  case Code::out_of_memory:
  case Code::memory_budget:
  case Code::no_space:
    return Exit::no_resources;
  case Code::file_exists:
    return Exit::usage;
  case Code::bound_not_met:
    return Exit::check_failed;
  default:
    return code < Code::not_bcc4 ? Exit::usage : Exit::bad_input;
  }
}

// What was to be checked does not hold.
template<class... Parts> [[noreturn]] void fail_check(const Parts&... parts) {
  throw Error(Code::bound_not_met, concat(parts...));
}

} // namespace bcc4

// SPDX-License-Identifier: Apache-2.0
// Errors of the readers and the tool are those of the core: what failed, where, what to try, and a code.
#pragma once

#include "base/error.h"
#include "readers/text.h"

namespace bcc4 {

using bccsplat::Code;
using bccsplat::Error;

// The file or its content is at fault.
template<class... Parts> [[noreturn]] void fail_input(const Parts&... parts) {
  throw Error(Code::corrupt, concat(parts...));
}
// The command line is at fault.
template<class... Parts> [[noreturn]] void fail_usage(const Parts&... parts) {
  throw Error(Code::invalid_argument, concat(parts...));
}
// Memory or disk do not do.
template<class... Parts> [[noreturn]] void fail_resources(const Parts&... parts) {
  throw Error(Code::out_of_memory, concat(parts...));
}

} // namespace bcc4

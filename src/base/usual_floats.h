// SPDX-License-Identifier: Apache-2.0
// The floating-point environment that the library computes in, whatever the host's is.
#pragma once

#include "base/os/floats.h"

namespace bccsplat {

// Round to nearest, gradual underflow, no traps, for this thread while it lives. Afterwards the thread has
// the mode, the traps and the flags that it had before: nothing that was raised meanwhile is left.
class UsualFloats {
 public:
  UsualFloats() noexcept : host_(set_usual_floats()) {}
  ~UsualFloats() { set_floats(host_); }
  UsualFloats(const UsualFloats&) = delete;
  UsualFloats& operator=(const UsualFloats&) = delete;

 private:
  Floats host_;
};

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Floating-point numbers of the thread that calls: rounding, denormals, traps, and flags that were raised.
#pragma once

#include <cfenv>

namespace bccsplat {

struct Floats {
  std::fenv_t standard{};
  unsigned vectors = 0; // Windows alone, whose C library leaves the register of vectors (MXCSR) as it is
};

// Sets rounding to nearest, gradual underflow, no traps and no flags. Returns what was there before.
[[nodiscard]] Floats set_usual_floats() noexcept;
void set_floats(const Floats& floats) noexcept;

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// The floating-point mode of x86-64, where all numbers but those of long double are computed in vectors.
#include "base/os/floats.h"

#include <xmmintrin.h>

namespace bccsplat {
namespace {

constexpr unsigned usual_vectors = 0x1F80; // all traps masked, no flag, to nearest, denormals kept

} // namespace

Floats set_usual_floats() noexcept {
  Floats before;
  std::fegetenv(&before.standard);
  before.vectors = _mm_getcsr();
  std::fesetenv(FE_DFL_ENV);
  _mm_setcsr(usual_vectors);
  return before;
}

void set_floats(const Floats& floats) noexcept {
  std::fesetenv(&floats.standard);
  _mm_setcsr(floats.vectors);
}

} // namespace bccsplat

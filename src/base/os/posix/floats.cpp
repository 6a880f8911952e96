// SPDX-License-Identifier: Apache-2.0
#include "base/os/floats.h"

namespace bccsplat {

Floats set_usual_floats() noexcept {
  Floats before;
  std::fegetenv(&before.standard);
  std::fesetenv(FE_DFL_ENV);
  return before;
}

void set_floats(const Floats& floats) noexcept { std::fesetenv(&floats.standard); }

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
#include "store/settings.h"

#include <cmath>

#include "base/error.h"

namespace bccsplat {

void require_rising(std::span<const double> times) {
  for (size_t i = 0; i < times.size(); ++i)
    if (!std::isfinite(times[i]) || (i > 0 && !(times[i] > times[i - 1])))
      fail(Code::invalid_argument, "part.times: time ", times[i], " of frame ", i, " does not rise");
}

} // namespace bccsplat

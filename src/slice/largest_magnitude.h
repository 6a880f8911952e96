// SPDX-License-Identifier: Apache-2.0
// What is dropped beside the largest value of a layer is measured by it.
#pragma once

#include <algorithm>
#include <cmath>

#include "points/brick.h"

namespace bccsplat {

[[nodiscard]] inline float largest_magnitude(const BrickLayer& layer) {
  float most = 0;
  for (size_t s = 0; s < layer.brick_slots(); ++s)
    if (const Brick* b = layer.brick(s))
      for (const float v : b->value) most = std::max(most, std::fabs(v));
  return most;
}

} // namespace bccsplat

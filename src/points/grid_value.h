// SPDX-License-Identifier: Apache-2.0
// A value at a point of a 3D grid.
#pragma once

#include "base/vec.h"

namespace bccsplat {

struct GridValue {
  Int3 at{};
  float value = 0;
};

} // namespace bccsplat

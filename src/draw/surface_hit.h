// SPDX-License-Identifier: Apache-2.0
// Where a ray met an isosurface.
#pragma once

#include <cstdint>

namespace bccsplat {

struct SurfaceHit {
  uint32_t pixel = 0; // of a tile: row times its pitch and column
  uint32_t surface = 0;
  float k = 0; // sheet number
};

} // namespace bccsplat

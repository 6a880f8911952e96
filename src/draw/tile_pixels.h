// SPDX-License-Identifier: Apache-2.0
// The finished pixels of a tile.
#pragma once

#include <span>

#include "draw/deep_tile.h"
#include "draw/surface_hit.h"

namespace bccsplat {

// Planes of `pitch` floats per row. depth is in sheet steps, infinity where nothing is; value and time are
// NaN there.
struct TilePixels {
  int x = 0, y = 0, width = 0, height = 0, pitch = 0;
  const float *red = nullptr, *green = nullptr, *blue = nullptr, *alpha = nullptr;
  const float *depth = nullptr, *value = nullptr, *time = nullptr;
  const DeepTile* deep = nullptr;   // null: not asked for
  std::span<const SurfaceHit> hits; // of each pixel in order along its ray; none where not asked for
};

} // namespace bccsplat

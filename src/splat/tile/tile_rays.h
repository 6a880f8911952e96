// SPDX-License-Identifier: Apache-2.0
// The rays of a tile's pixels: where they run inside the domain, how long a sheet step is along them, and
// where the viewer is.
#pragma once

#include <array>
#include <cstdint>

#include "field/slice.h"
#include "splat/plan/plan.h"
#include "splat/sheet/sheet.h"
#include "view/view.h"

namespace bccsplat {

struct TileRays {
  double low = 0, high = -1; // sheet numbers between which some ray is inside
  int open = 0;              // pixels whose ray meets the domain
};

// Fills enter, leave (an empty interval beside the tile and where the ray misses), path and view_x, _y, _z:
// six planes of pitch * tile.height floats at `planes`, which `out` then points to.
TileRays make_rays(const Slice& slice, const SheetView& view, const PlannedTile& tile, int pitch,
                   float* planes, PixelPlanes& out);
inline constexpr size_t ray_planes = 6;

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// A surface that was drawn before its tile, where rays end.
#pragma once

#include <limits>

#include "base/grid.h"
#include "draw/tile_pixels.h"

namespace bccsplat {

inline constexpr float opaque_depth = 64; // an optical depth: floats know no more

struct TileFront {
  const TilePixels* pixels = nullptr; // null: there is none
  bool through = false;               // rays go on behind it: by equation (8) as printed nothing is opaque

  [[nodiscard]] bool ends_rays() const { return pixels && !through; }
  [[nodiscard]] size_t pixel(int x, int y) const { return plane_index(x, y, pixels->pitch); }
  // The sheet number of the surface; infinity: the pixel has none.
  [[nodiscard]] float at(int x, int y) const {
    const size_t p = pixel(x, y);
    return pixels->alpha[p] > 0 ? pixels->depth[p] : std::numeric_limits<float>::infinity();
  }
};

} // namespace bccsplat

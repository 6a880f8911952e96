// SPDX-License-Identifier: Apache-2.0
// Which axis of the lattice rays run along the most. Parallel rays share it; those of a wide perspective may
// run along three, a few tiles of the picture along each.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "view/view.h"

namespace bccsplat {

inline constexpr int ray_tile_edge = 64; // pixels

// The axis of some rays, and how they run.
struct RayAxis {
  size_t along = 0;
  int direction = 1; // in which they run along it
  double least = 0;  // lattice units along it of a sheet, at least
  // Slopes of the rays along another axis against this one, and by how much they differ in a piece.
  struct Across {
    size_t axis = 0;
    double low = 0, high = 0, of_piece = 0;
  };
  std::array<Across, 2> across;

  [[nodiscard]] double steepest() const;
  void include(const RayAxis& other); // along the same, in the same direction
};

struct RayAxes {
  std::vector<RayAxis> axes;
  std::vector<uint8_t> of_tile; // which of them; tiles row by row
};
// Returns none where the rays of a tile spread so widely that they pass too many blocks of any slab.
[[nodiscard]] std::optional<RayAxes> find_ray_axes(const SheetView& view);

} // namespace bccsplat

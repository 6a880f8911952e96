// SPDX-License-Identifier: Apache-2.0
// Sums of the layers of linear tiles (coding/linear_tile.h), by one inverse where they can be added as
// coefficients.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "formats/bcc4/coding/linear_tile.h"
#include "points/brick.h"

namespace bccsplat {

// What the layers of a slab count for at a place; tile: null where no site of it is stored.
struct WeighedTile {
  const LinearTile* tile = nullptr;
  std::vector<float> weights;
};
// What samples are: kept ones are scale * (their sum in codes less that of air) + air, others `absent`.
struct TileValues {
  float scale = 1, air = 0, absent = 0;
};

// Returns those of the wanted bricks of a place, x fastest, that have sites which are kept in any layer,
// without holes; null where there are none. Empty where no tile is stored there. room: used again.
[[nodiscard]] std::vector<std::shared_ptr<Brick>> sum_tiles(std::span<const WeighedTile> tiles,
                                                            const TileValues& values,
                                                            const std::vector<bool>& wanted,
                                                            std::vector<float>& room);

} // namespace bccsplat

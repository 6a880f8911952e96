// SPDX-License-Identifier: Apache-2.0
// Rounds the coefficients of a chunk to whole units, and hands errors on, sixteen rows side by side.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "formats/bcc4/coding/predict_walk.h"
#include "points/brick.h"

namespace bccsplat {

struct UnitRounding {
  double unit = 1;
  double most = 1 << 30; // units, either way
  // The weights of errors per layer (taps_of_layer); empty: errors stay where they are.
  std::vector<Weights> weights;
};

// The units of all sites of a layer, (z*16 + y)*16 + x; 0 where a value is 0 or outside the domain.
using LayerUnits = std::array<int32_t, brick_sites>;

// bricks: one per layer of the shape, null where all is air; their layers of `units` are left as they are.
// Sites whose value is 0 are not rounded, and have no error.
void round_units(const ChunkShape& shape, std::span<const Brick* const> bricks, const UnitRounding& how,
                 std::span<LayerUnits> units);

// The same site by site, which reads like the formula.
void round_units_reference(const ChunkShape& shape, std::span<const Brick* const> bricks,
                           const UnitRounding& how, std::span<LayerUnits> units);

} // namespace bccsplat

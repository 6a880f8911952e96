// SPDX-License-Identifier: Apache-2.0
// How a tile becomes coefficients and steps: how often it is halved, which steps, and each coefficient's.
#pragma once

#include <span>
#include <vector>

#include "formats/bcc4/encode/bit_costs.h"
#include "formats/bcc4/wavelet/wavelet_tile.h"

namespace bccsplat {

// What a tile is coded with.
struct TileRule {
  StepRule steps;
  int halvings_along_z = 0;
  BitCosts costs;
};

// Numbers to coefficients. `step` tells which coefficients will be next to nothing.
[[nodiscard]] TileBands analyse_tile(const TileBox& box, std::vector<float> values, float step,
                                     int halvings_along_z);
// Halves boxes that share a head less often until no coefficient takes more steps than can be coded: each
// halving makes the coarse rest larger. Where not even whole layers fit, their step becomes larger. Returns
// whether boxes are halved less.
bool fit_into_steps(std::span<TileBands> bands, StepRule& rule);
// Finds steps whose mean square error is about that, from the values of some tiles that stand for all;
// analyse_tile() makes the bands of these with as many halvings along z.
[[nodiscard]] TileRule find_tile_rule(std::span<const TileBox> boxes, std::vector<std::vector<float>> values,
                                      double mean_square);

// Chooses the steps: errors weighed against bits. No coefficient takes more than fit_into_steps() leaves it.
void choose_steps(TileBands& bands, const TileRule& rule, WalkRoom& room);

} // namespace bccsplat

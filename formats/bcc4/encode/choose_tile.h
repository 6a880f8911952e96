// SPDX-License-Identifier: Apache-2.0
// How a tile becomes coefficients and steps: how often it is halved, which steps, and each coefficient's.
#pragma once

#include <array>
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

// How far coefficients are from their steps.
struct StepErrors {
  // What became a magnitude of 1, and of more: of its distances from the magnitude, in steps.
  struct Group {
    double count = 0, sum = 0, squares = 0;
  };
  double left_out = 0; // squares of what became 0
  std::array<Group, 2> groups;
  void add(float coefficient, float in_steps, int magnitude) {
    if (magnitude == 0) {
      left_out += double{coefficient} * coefficient;
      return;
    }
    const double off = in_steps - static_cast<float>(magnitude);
    Group& g = groups[magnitude > 1 ? 1 : 0];
    ++g.count, g.sum += off, g.squares += off * off;
  }
  void add(const StepErrors& other) {
    left_out += other.left_out;
    for (size_t i = 0; i < groups.size(); ++i) {
      groups[i].count += other.groups[i].count, groups[i].sum += other.groups[i].sum;
      groups[i].squares += other.groups[i].squares;
    }
  }
  // Returns the sum of all squares where magnitudes stand for the values that a rule gives them.
  [[nodiscard]] double squares(const StepRule& rule) const;
};

// Chooses the steps: errors weighed against bits. No coefficient takes more than fit_into_steps() leaves it.
StepErrors choose_steps(TileBands& bands, const TileRule& rule, WalkRoom& room);

} // namespace bccsplat

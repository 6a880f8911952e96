// SPDX-License-Identifier: Apache-2.0
// What the walks through a tile's steps share.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "formats/bcc4/wavelet/band_walk.h"
#include "formats/bcc4/wavelet/wavelet_tile.h"

namespace bccsplat {

inline constexpr int most_context = 1023;      // magnitudes that neighbours tell apart
inline constexpr float most_steps = 1 << 21;   // of a coefficient that is coded; 13 more would fit
inline constexpr float largest_step = 1 << 24; // steps of it stay numbers
inline constexpr float centre_unit = 256;      // of StepRule::centres

// Where the coefficients of a row are.
inline size_t place_of(const Halvings& s, const WalkRow& r) {
  const size_t z = static_cast<size_t>(r.k) * s.size[2] + r.box.begin[2] + r.z,
               y = z * s.size[1] + r.box.begin[1] + r.y;
  return y * s.size[0] + r.box.begin[0];
}
inline uint16_t context_of(int32_t steps) {
  return static_cast<uint16_t>(std::min(std::abs(steps), most_context));
}
// Contexts that a level has of its own; the coarse rest has 0.
inline int group_of(const BandBox& box) { return box.direction == 0 ? 0 : box.level; }

inline float value_of(int32_t steps, const StepRule& rule) {
  if (steps == 0) return 0;
  const int magnitude = steps < 0 ? -steps : steps;
  const float off = static_cast<float>(rule.centres[magnitude > 1 ? 1 : 0] - centre_middle) / centre_unit,
              value = (static_cast<float>(magnitude) + off) * rule.step;
  return steps < 0 ? -value : value;
}

// A box of that size, each axis halved so often, or as often as it can be.
inline Halvings halved(const std::array<int, 3>& size, const std::array<int, 3>& times) {
  Halvings shape{size, {}};
  for (size_t a = 0; a < 3; ++a) shape.times[a] = std::min(times[a], most_halvings(size[a]));
  return shape;
}

} // namespace bccsplat

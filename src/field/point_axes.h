// SPDX-License-Identifier: Apache-2.0
// The way from the points of a caller to those of the inner loop: whether they lie in the volume, where they
// belong in a batch, and their places in lattice units.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "base/vec.h"
#include "field/point_order.h"
#include "lattice/lattice.h"

namespace bccsplat {

// The volume's domain, and the way from index units to lattice units and kernel time.
struct PointAxes {
  Vec4 end{};            // of the domain, per axis; infinite where there is no time
  Vec4 slack{};          // points this far beyond an end count as inside: rounding of conversions
  Vec4 scale{}, shift{}; // index units -> lattice units, kernel time: times scale, plus shift
  double per_layer = 0;  // layers per frame; 0 where there is no time
  std::array<int32_t, 3> cells{};
  Vec3 per_cell{};         // cells per index unit
  uint32_t cell_count = 1; // 1: points are not told apart by cells

  PointAxes(const Lattice4& lattice, size_t points);

  // Finds window and cell of each point, or of the point of the domain nearest to it; NaN counts as the end
  // of the domain. clip: in time as well.
  void place(std::span<const Vec4> points, bool clip, std::span<PointPlace> places) const;

  // scaled[i] = points[at[i]] * scale + shift, outside[i] = 0; where `clip` is set points outside the domain,
  // or not numbers, become 0 and 1. A static volume takes any t. Returns how many are outside.
  size_t scale_points(const Vec4* points, std::span<const uint64_t> at, bool clip, Vec4* scaled,
                      uint8_t* outside) const;
};

} // namespace bccsplat

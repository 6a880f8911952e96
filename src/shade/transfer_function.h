// SPDX-License-Identifier: Apache-2.0
// Transfer functions: piecewise linear colour and opacity over the value.
#pragma once

#include <span>
#include <vector>

#include "base/vec.h"
#include "shade/class_table.h"

namespace bccsplat {

struct ColorPoint {
  double value = 0;
  Vec3 color{}; // linear RGB, straight
};
struct OpacityPoint {
  double value = 0;
  double opacity = 0; // fraction absorbed per unit distance, in [0, 1]
};

// Constant beyond the first and last point; two points of one value make a step.
struct TransferFunction {
  std::vector<ColorPoint> colors;
  std::vector<OpacityPoint> opacities;
  double unit_distance = 0; // world length; 0: one mean voxel

  // Throws invalid_argument: no points, values that fall or are not finite, opacities outside [0, 1].
  void check() const;
  [[nodiscard]] Vec3 color(double value) const;
  [[nodiscard]] double opacity(double value) const;
};

// -ln(1 - opacity) / unit_distance; full opacity is a large finite number.
[[nodiscard]] double extinction(double opacity, double unit_distance);

// Makes a table of `entries` samples of the function over the values of the slice, [low, high], and one more
// where needed so that one of them is at `anchor`, the value of the field's base: what is transparent there
// must not veil the whole domain. unit_distance > 0.
[[nodiscard]] ClassTable make_class_table(const TransferFunction& function, double low, double high,
                                          double anchor, double unit_distance, int entries);

// Returns viridis at x in [0, 1], linear RGB.
[[nodiscard]] Vec3 viridis(double x);

} // namespace bccsplat

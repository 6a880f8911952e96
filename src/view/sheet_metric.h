// SPDX-License-Identifier: Apache-2.0
// Distances on the sheets of a view, in pixels and in lattice units.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "view/view.h"

namespace bccsplat {

// The quadratic form of pixel distances on a sheet at scale 1, lattice units squared.
struct SheetMetric {
  double xx, xy, yy;
  explicit SheetMetric(const SheetView& v) : xx(dot(v.ex, v.ex)), xy(dot(v.ex, v.ey)), yy(dot(v.ey, v.ey)) {}
  [[nodiscard]] double determinant() const { return xx * yy - xy * xy; }
  // Pixels of the picture's axes in a lattice unit, by their own directions: what a wave of the lattice turns
  // by along a row or column of pixels at most. A ball's extent along them is longer where they are skew.
  [[nodiscard]] std::array<double, 2> pixels_per_unit() const {
    return {1 / std::sqrt(xx), 1 / std::sqrt(yy)};
  }
  // Lattice units that a step of one pixel takes at least, and at most, whatever its direction.
  [[nodiscard]] std::array<double, 2> extremes() const {
    const double mean = 0.5 * (xx + yy), half = std::hypot(0.5 * (xx - yy), xy);
    return {std::sqrt(std::max(0.0, mean - half)), std::sqrt(mean + half)};
  }
};

// Shift of a foot per sheet, orthographic: zero unless the affine shears the ray off the sheets' normal.
[[nodiscard]] inline std::array<double, 2> drift(const SheetView& v) {
  if (v.perspective) return {0, 0};
  return {dot(v.gx, v.ez), dot(v.gy, v.ez)};
}

// What rounding leaves of zero: of the entries of a metric beside the largest, and of drifts, pixels per
// sheet.
inline constexpr double metric_rounding = 1e-12, drift_rounding = 1e-9;

// Returns whether a sheet's metric is a multiple of the identity and rays run along its normal.
[[nodiscard]] inline bool isotropic(const SheetView& v) {
  const SheetMetric metric(v);
  const auto [drift_x, drift_y] = drift(v);
  const double largest = std::max(metric.xx, metric.yy);
  return !v.perspective && std::fabs(metric.xy) < metric_rounding * largest &&
         std::fabs(metric.xx - metric.yy) < metric_rounding * largest &&
         std::fabs(drift_x) < drift_rounding && std::fabs(drift_y) < drift_rounding;
}

// Returns the pixels per lattice unit at the centre of the domain, in the direction in which pixels are
// largest.
[[nodiscard]] inline double pixels_per_unit(const SheetView& view) {
  return 1 / (view.scale(0) * SheetMetric(view).extremes()[1]);
}

// Depth of a gap's first sheet, in sheet steps from the eye: never behind the first sheet.
[[nodiscard]] inline double base_depth(const SheetView& v, int64_t gap) {
  return static_cast<double>(std::max(gap, v.first_sheet())) + v.depth;
}

} // namespace bccsplat

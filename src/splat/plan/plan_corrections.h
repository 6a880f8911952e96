// SPDX-License-Identifier: Apache-2.0
// Where the corrections of a slice fall in a picture.
#pragma once

#include "splat/plan/plan.h"

namespace bccsplat {

// The places of the corrections' grid points in a picture: sheet, x and y are linear in the point.
struct CorrectionView {
  explicit CorrectionView(const SplatScene& scene);

  [[nodiscard]] double sheet(const Vec3& g) const { return sheet_0 + dot(sheet_per, g); }
  // The pixel column and row that a point has on sheet k, along the sheets' normal.
  [[nodiscard]] std::array<double, 2> pixel(const Vec3& g, double k) const {
    const double x = x_0 + dot(x_per, g), y = y_0 + dot(y_per, g);
    if (perspective) return {x / (k + depth) - x_drift, y / (k + depth) - y_drift};
    return {x - k * x_drift, y - k * y_drift};
  }
  // The lengths of a pixel on sheet k, relative to those at scale 1.
  [[nodiscard]] double scale(double k) const { return perspective ? k + depth : 1; }

  bool perspective;
  double depth;
  double sheet_0, x_0, y_0, x_drift, y_drift;
  Vec3 sheet_per, x_per, y_per;
  // How far a correction reaches around its point: sheets, and pixels at scale 1.
  double half_sheet, half_x, half_y;
};

// Sets plan.corrections, and those of each tile.
void plan_corrections(const SplatScene& scene, SplatPlan& plan);

} // namespace bccsplat

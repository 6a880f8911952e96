// SPDX-License-Identifier: Apache-2.0
#include "splat/plan/plan_corrections.h"

#include <algorithm>
#include <cmath>

#include "splat/plan/plan_bounds.h"

namespace bccsplat {
namespace {

double magnitudes(const Vec3& v) { return std::fabs(v[0]) + std::fabs(v[1]) + std::fabs(v[2]); }

constexpr double farthest_sheet = 1e15; // doubles tell all sheets up to here apart

// Corrections end one point beyond those of their brick, on either side.
auto corners_of(const SparseGrid::Brick& brick) {
  Vec3 low, high;
  for (size_t a = 0; a < 3; ++a) {
    low[a] = brick.begin[a] - 1.0;
    high[a] = brick.begin[a] + static_cast<double>(SparseGrid::edge);
  }
  return box_corners(low, high);
}

// Sets the sheets and pixels that a brick may touch; returns false when there are none in front of the eye.
bool bound_brick(const SplatScene& scene, const CorrectionView& at, const SparseGrid::Brick& brick,
                 PlannedCorrections& out) {
  const auto corners = corners_of(brick);
  Bounds sheets;
  for (const Vec3& c : corners) sheets.include(at.sheet(c));
  const auto sheet = [](double k) {
    return static_cast<int64_t>(std::clamp(k, -farthest_sheet, farthest_sheet));
  };
  out.first_sheet = std::max(sheet(std::ceil(sheets.low)), scene.view->first_sheet());
  out.last_sheet = sheet(std::floor(sheets.high));
  if (out.first_sheet > out.last_sheet) return false;
  Bounds across, down;
  for (const Vec3& c : corners)
    for (const int64_t k : {out.first_sheet, out.last_sheet}) {
      const auto [x, y] = at.pixel(c, static_cast<double>(k));
      across.include(x), down.include(y);
    }
  out.rect = {pixel_number(std::floor(across.low)), pixel_number(std::floor(down.low)),
              pixel_number(std::ceil(across.high)) + 1, pixel_number(std::ceil(down.high)) + 1};
  return true;
}

} // namespace

CorrectionView::CorrectionView(const SplatScene& scene) {
  const SheetView& v = *scene.view;
  const Affine3 to_lattice = scene.slice->lattice_to_slice.inverse();
  const Vec3 base = to_lattice.point(scene.slice->corrections->origin) - v.eye;
  perspective = v.perspective, depth = v.depth;
  const auto per = [&](const Vec3& functional) { return to_lattice.transposed(functional); };
  sheet_per = (1 / v.step) * per(v.normal), x_per = per(v.gx), y_per = per(v.gy);
  sheet_0 = dot(v.normal, base) / v.step - (perspective ? depth : 0);
  x_0 = dot(v.gx, base), y_0 = dot(v.gy, base);
  x_drift = dot(v.gx, v.ez), y_drift = dot(v.gy, v.ez);
  half_sheet = magnitudes(sheet_per), half_x = magnitudes(x_per), half_y = magnitudes(y_per);
}

void plan_corrections(const SplatScene& scene, SplatPlan& plan) {
  if (!scene.slice->corrections) return;
  const CorrectionView at(scene);
  const auto& bricks = scene.slice->corrections->add.bricks();
  for (uint32_t n = 0; n < bricks.size(); ++n) {
    PlannedCorrections c;
    c.brick = n;
    if (bound_brick(scene, at, bricks[n], c)) plan.corrections.push_back(c);
  }
  for (PlannedTile& t : plan.tiles)
    for (uint32_t n = 0; n < plan.corrections.size(); ++n) {
      const auto& r = plan.corrections[n].rect;
      const int b = plan.sheets.border;
      if (r[0] < t.x + t.width + b && r[2] > t.x - b && r[1] < t.y + t.height + b && r[3] > t.y - b)
        t.corrections.push_back(n);
    }
}

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
#include "splat/plan/plan_corrections.h"

#include <algorithm>
#include <cmath>

namespace bccsplat {
namespace {

double magnitudes(const Vec3& v) { return std::fabs(v[0]) + std::fabs(v[1]) + std::fabs(v[2]); }

// Corrections end one point beyond those of their brick, on either side.
std::array<Vec3, 8> corners_of(const SparseGrid::Brick& brick) {
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
  double near = 1e300, far = -1e300;
  for (const Vec3& c : corners) near = std::min(near, at.sheet(c)), far = std::max(far, at.sheet(c));
  const auto sheet = [](double k) { return static_cast<int64_t>(std::clamp(k, -1e15, 1e15)); };
  out.first_sheet = std::max(sheet(std::ceil(near)), scene.view->first_sheet());
  out.last_sheet = sheet(std::floor(far));
  if (out.first_sheet > out.last_sheet) return false;
  double x0 = 1e300, x1 = -1e300, y0 = 1e300, y1 = -1e300;
  for (const Vec3& c : corners)
    for (const int64_t k : {out.first_sheet, out.last_sheet}) {
      const auto [x, y] = at.pixel(c, static_cast<double>(k));
      x0 = std::min(x0, x), x1 = std::max(x1, x), y0 = std::min(y0, y), y1 = std::max(y1, y);
    }
  const auto pixel = [](double p) { return static_cast<int>(std::clamp(p, -1e8, 1e8)); };
  out.rect = {pixel(std::floor(x0)), pixel(std::floor(y0)), pixel(std::ceil(x1)) + 1,
              pixel(std::ceil(y1)) + 1};
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

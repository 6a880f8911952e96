// SPDX-License-Identifier: Apache-2.0
// Bounds what samples can show by the ranges of the coefficients around them, so that bricks and cells which
// nothing visible looks at are left out. A sample lies between the least and the most that its coefficients
// times the sum of kernel weights can amount to; the notes are in tests/bench/notes/render-speed.md.
#include "splat/plan/plan_cells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace bccsplat {
namespace {

// Bounds of how the sum of kernel weights ripples about its mean. The bound of the radial kernels leaves out
// 8 % more visits of an isosurface than 0.1 for all (tests/bench/notes/render-speed.md).
constexpr double radial_ripple = 0.02, other_ripple = 0.1;

// Returns whether all samples between points of this range only are beyond the isosurface furthest from the
// base. A range that ends at 0 says nothing.
bool beyond(double furthest, const WeightBounds& weights, const CellRange& range) {
  const double least = weights.least;
  return furthest > 0 ? least * range.low > furthest : furthest < 0 && least * range.high < furthest;
}

// Returns the most lattice units that any ray takes from sheet to sheet.
double longest_ray(const SheetView& v) {
  double longest = 0;
  for (const double i : {0.0, static_cast<double>(v.width - 1)})
    for (const double j : {0.0, static_cast<double>(v.height - 1)})
      longest = std::max(longest, length(v.ray(i, j)));
  return longest;
}

} // namespace

WeightBounds::WeightBounds(const Slice& slice) {
  const bool radial = kernel_polynomial(slice.kernel.space).form == KernelPolynomial::Form::square_8;
  const double ripple = slice.lattice.bcc && radial ? radial_ripple : other_ripple;
  least = 1 - ripple;
  most = (1 + ripple) * std::numbers::sqrt2 / slice.lattice.cell_volume();
}

bool shows(const SplatScene& scene, const SplatOptions& options, const WeightBounds& weights, float low,
           float high) {
  const double base = scene.slice->base;
  const double a = base + weights.most * std::min(low, 0.0f), b = base + weights.most * std::max(high, 0.0f);
  if (options.mode == RenderMode::composite && options.preintegrate) {
    // A cubic through four samples may leave their range by an eighth of it halfway.
    const double over = (b - a) / 8;
    return scene.table->crossed(a - over, b + over);
  }
  if (options.mode == RenderMode::composite) return scene.table->visible(a, b);
  if (options.mode == RenderMode::isosurface)
    return std::any_of(options.surfaces.begin(), options.surfaces.end(),
                       [&](const IsoSurface& s) { return s.value >= a && s.value <= b; });
  return true;
}

double look_distance(const SplatScene& scene, const SplatOptions& options, const SplatPlan& plan) {
  const SheetView& v = *scene.view;
  // A crossing looks at the two sheets on either side of it.
  const int sheets = options.mode == RenderMode::isosurface ? 2 : plan.sheets.lead;
  if (sheets == 0 && plan.raise.taps == 0 && plan.raise.depth_taps == 0) return 0;
  const double scale = v.perspective ? static_cast<double>(plan.sheets.last) + v.depth : 1;
  const double x = scale * length(v.ex), y = scale * length(v.ey),
               ray = (sheets + 0.5 * plan.raise.depth_taps * plan.raise.z.ratio) * longest_ray(v);
  if (plan.raise.taps == 0) return std::max({ray, sheets * x, sheets * y});
  // Samples that a pixel is raised from lie in a rectangle around it.
  const RaiseFan& fan = plan.raise.fan;
  const double wide =
                   0.5 * plan.raise.taps * (fan.taps > 0 ? length(v.ex) / fan.x.per : plan.raise.x.ratio * x),
               high =
                   0.5 * plan.raise.taps * (fan.taps > 0 ? length(v.ey) / fan.y.per : plan.raise.y.ratio * y);
  if (v.perspective && plan.gaps.isotropic) {
    // Rays lean, so that what they look at lies to the side, too.
    const double lean = std::sqrt(std::max(0.0, longest_ray(v) * longest_ray(v) - v.step * v.step)),
                 deep = (sheets + 0.5 * plan.raise.depth_taps * plan.raise.z.ratio) * v.step,
                 aside =
                     std::max(sheets * lean, plan.sheets.border * std::max(x, y)) + std::hypot(wide, high);
    return std::hypot(deep, aside);
  }
  if (!plan.gaps.isotropic) return ray + wide + high + plan.sheets.border * std::max(x, y);
  return std::sqrt(
      std::max({ray * ray + wide * wide + high * high,
                (wide + plan.sheets.border * x) * (wide + plan.sheets.border * x) + high * high}));
}

uint64_t near_cells(const SplatScene& scene, const SplatBrick& brick, double look) {
  const double reach = scene.slice->kernel.space.radius + look + longest_ray(*scene.view),
               d = scene.points->plane_distance;
  const DrawnBox box = drawn_box(*scene.slice);
  std::array<std::array<bool, 4>, 3> near{};
  for (size_t a = 0; a < 3; ++a)
    for (size_t n = 0; n < 4; ++n) {
      const double low = d * (brick.plane[a] + 4 * static_cast<int>(n)), high = low + 3 * d;
      near[a][n] = high >= std::min(box.begin[a], 0.0) - reach && low <= box.end[a] + reach;
    }
  uint64_t cells = 0;
  for (size_t n = 0; n < cells_per_brick; ++n)
    cells |= uint64_t{near[0][n & 3] && near[1][n >> 2 & 3] && near[2][n >> 4]} << n;
  return cells;
}

int useful_cells(const SplatScene& scene, const SplatOptions& options, const SplatPlan& plan) {
  if (options.disable_skips & (skip_transfer_function | skip_cells)) return -1;
  if (options.mode != RenderMode::composite && options.mode != RenderMode::isosurface) return -1;
  const double look = look_distance(scene, options, plan);
  // What a segment shows depends on samples around it, too.
  const double needed = 2 * scene.slice->kernel.space.radius + (options.preintegrate ? 2 : 1) * look;
  for (size_t n = 1; n < SplatPoints::cell_reach.size(); ++n)
    if (needed <= 4 * scene.points->plane_distance * SplatPoints::cell_reach[n]) return static_cast<int>(n);
  return -1;
}

std::optional<double> furthest_surface(const SplatScene& scene, const SplatOptions& options) {
  double low = 0, high = 0;
  for (const IsoSurface& s : options.surfaces) {
    const double target = s.value - scene.slice->base;
    low = std::min(low, target), high = std::max(high, target);
    if (options.surfaces.size() > 1 && target == 0) return std::nullopt;
  }
  if (options.surfaces.empty() || (low < 0 && high > 0)) return std::nullopt;
  return low < 0 ? low : high;
}

uint64_t needed_cells(const SplatScene& scene, const SplatOptions& options, const WeightBounds& weights,
                      const CellRange* range, const std::optional<double>& inside) {
  uint64_t cells = 0;
  for (int n = 0; n < cells_per_brick; ++n) {
    const bool shown = shows(scene, options, weights, range[n].low, range[n].high) &&
                       !(inside && beyond(*inside, weights, range[n]));
    cells |= uint64_t{shown} << n;
  }
  return cells;
}

uint64_t inside_cells(double furthest, const WeightBounds& weights, const CellRange* range) {
  uint64_t cells = 0;
  for (int n = 0; n < cells_per_brick; ++n) cells |= uint64_t{beyond(furthest, weights, range[n])} << n;
  return cells;
}

} // namespace bccsplat

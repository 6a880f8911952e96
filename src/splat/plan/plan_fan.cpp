// SPDX-License-Identifier: Apache-2.0
#include "splat/plan/plan_fan.h"

#include <algorithm>
#include <cmath>

#include "view/sheet_metric.h"

namespace bccsplat {
namespace {

// Pixels per sample that raise_sheet() takes, at least.
constexpr double least_ratio = 0.6;
// Samples of the largest ring a tile may come to: a tile holds all that it shows, from the first sheet to the
// last, so that strong perspective wants much more of them than it has pixels. Up to the first number always,
// beyond it an eighth of the picture's pixels, up to the second: this trades memory for the time a fan saves.
// No measurement of the limits is noted.
constexpr double always_samples = 1 << 20, most_samples = 1 << 22, samples_per_pixel = 0.125;
// A side of that ring beside what drifts: about the largest tile and what it looks at.
constexpr double tile_samples = 160;

} // namespace

bool plan_fan(const RaiseFilter& filter, SplatPlan& plan, SheetView& v) {
  if (!v.perspective) return false;
  const auto [per_unit_x, per_unit_y] = SheetMetric(v).pixels_per_unit();
  const double first = v.scale(
                   static_cast<double>(std::max(plan.sheets.first - plan.sheets.lead, v.first_sheet()))),
               last = v.scale(static_cast<double>(plan.sheets.last + 2 * plan.sheets.lead + 1));
  // Scales at which pixels are as large as samples.
  const double x = per_unit_x / filter.density, y = per_unit_y / filter.density;
  const double ratio = std::min(x, y);
  if (!(first > 0 && ratio >= least_ratio * last && ratio >= filter.from_fan * std::sqrt(first * last)))
    return false;
  const double foot_x = -dot(v.gx, v.ez), foot_y = -dot(v.gy, v.ez);
  const auto drift = [&](double foot, double count, double per) {
    return std::max(std::fabs(foot), std::fabs(count - 1 - foot)) * (last - first) * per + tile_samples;
  };
  const double samples = drift(foot_x, v.width, 1 / x) * drift(foot_y, v.height, 1 / y);
  if (!(samples <= std::clamp(samples_per_pixel * v.width * v.height, always_samples, most_samples)))
    return false;
  RaiseFan& fan = plan.raise.fan;
  fan.x = {1 / x, foot_x}, fan.y = {1 / y, foot_y};
  fan.taps = filter.taps, fan.depth = v.depth, fan.border = plan.sheets.border;
  fan.nearest = v.scale(static_cast<double>(v.first_sheet()));
  make_fan_weights(fan, filter.density);
  plan.raise.x.ratio = x / last, plan.raise.y.ratio = y / last;
  v.perspective = false;
  v.ez = v.step * v.normal;
  v.eye = v.eye + v.depth * v.ez;
  v.ex = x * v.ex, v.ey = y * v.ey;
  v.gx = (1 / x) * v.gx, v.gy = (1 / y) * v.gy;
  return true;
}

Scales gap_scales(const SplatPlan& plan, int64_t first, int64_t last) {
  const int reach = plan.raise.depth_taps > 0 ? plan.raise.depth_taps / 2 + 1 : 0;
  const auto scale = [&](int64_t sheet) {
    const double k = static_cast<double>(sheet) * plan.raise.z.ratio;
    return plan.raise.fan.scale(std::clamp(k, static_cast<double>(plan.sheets.first - 2 * plan.sheets.lead),
                                           static_cast<double>(plan.sheets.last + 2 * plan.sheets.lead)));
  };
  return {scale(first - plan.ring.before - reach), scale(last + plan.ring.after + reach)};
}

void fan_rect(const SplatPlan& plan, PlannedBrick& b) {
  const Scales scales = gap_scales(plan, b.first_gap, b.last_gap);
  const auto [x0, x1] = fan_pixels(plan.raise.fan, plan.raise.fan.x, scales, {b.rect[0], b.rect[2]});
  const auto [y0, y1] = fan_pixels(plan.raise.fan, plan.raise.fan.y, scales, {b.rect[1], b.rect[3]});
  b.rect = {x0, y0, x1, y1};
}

} // namespace bccsplat

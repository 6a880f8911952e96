// SPDX-License-Identifier: Apache-2.0
// Judges every brick of a slice's points for a picture: whether it may show, which gaps and pixels its points
// may touch, and which of its cells are needed. The bricks that are left become plan.bricks, sorted by their
// first gap.
#include "splat/plan/plan_bricks.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "splat/plan/plan_bounds.h"
#include "splat/plan/plan_cells.h"
#include "splat/plan/plan_fan.h"
#include "splat/plan/plan_points.h"
#include "view/sheet_metric.h"

namespace bccsplat {
namespace {

// Sheets: floats tell the depths of a brick's points no finer, so that one may fall into the next gap.
constexpr double depth_rounding = 1e-4;

BrickAxes brick_axes(const SplatScene& scene, const SplatPlan& plan, const SplatBrick& brick) {
  const SheetView& v = *scene.view;
  const double d = scene.points->plane_distance;
  const Vec3 origin = d * Vec3{static_cast<double>(brick.plane[0]), static_cast<double>(brick.plane[1]),
                               static_cast<double>(brick.plane[2])};
  BrickAxes f;
  const double sheet = v.sheet(origin);
  f.k = static_cast<int64_t>(std::floor(sheet));
  const double X = dot(v.gx, origin - v.eye), Y = dot(v.gy, origin - v.eye);
  // The base gap's lateral factor; feet follow from it by X (lateral[s] - m).
  double m = 1, i, j;
  Vec3 di = d * v.gx, dj = d * v.gy;
  const auto [drift_x, drift_y] = drift(v);
  if (v.perspective) {
    m = 1 / base_depth(v, f.k);
    i = X * m - dot(v.gx, v.ez), j = Y * m - dot(v.gy, v.ez);
    f.m = static_cast<float>(m);
    di = m * di, dj = m * dj;
    for (size_t a = 0; a < 3; ++a) {
      f.dX[a] = static_cast<float>(d * v.gx[a]);
      f.dY[a] = static_cast<float>(d * v.gy[a]);
    }
    f.dX[3] = static_cast<float>(X), f.dY[3] = static_cast<float>(Y);
  } else {
    i = X - static_cast<double>(f.k) * drift_x, j = Y - static_cast<double>(f.k) * drift_y;
    f.m = static_cast<float>(f.k - plan.gaps.first);
    f.dX[3] = static_cast<float>(-drift_x), f.dY[3] = static_cast<float>(-drift_y);
  }
  const double base_i = std::clamp(std::floor(i), -1e9, 1e9), base_j = std::clamp(std::floor(j), -1e9, 1e9);
  f.i = static_cast<int32_t>(base_i), f.j = static_cast<int32_t>(base_j);
  for (size_t a = 0; a < 3; ++a) {
    f.di[a] = static_cast<float>(di[a]), f.dj[a] = static_cast<float>(dj[a]);
    f.dk[a] = static_cast<float>(d * v.normal[a] / v.step);
  }
  f.di[3] = static_cast<float>(i - base_i), f.dj[3] = static_cast<float>(j - base_j);
  f.dk[3] = static_cast<float>(sheet - static_cast<double>(f.k));
  return f;
}

// Sets the gaps and pixels that the points of a brick may touch; returns false when there are none in front
// of the eye.
bool bound_brick(const SplatScene& scene, const SplatPlan& plan, const SplatBrick& brick, PlannedBrick& out) {
  const SheetView& v = *scene.view;
  const double d = scene.points->plane_distance;
  Vec3 low, high;
  for (size_t a = 0; a < 3; ++a)
    low[a] = d * (brick.plane[a] + brick.low[a]), high[a] = d * (brick.plane[a] + brick.high[a]);
  Bounds sheets, across, down; // the latter of X and Y
  const auto [drift_x, drift_y] = drift(v);
  for (const Vec3& c : box_corners(low, high)) {
    const double k = v.sheet(c);
    sheets.include(k);
    const double shift = v.perspective ? 0 : k;
    across.include(dot(v.gx, c - v.eye) - shift * drift_x);
    down.include(dot(v.gy, c - v.eye) - shift * drift_y);
  }
  out.first_gap = static_cast<int64_t>(std::floor(sheets.low - depth_rounding));
  out.last_gap = static_cast<int64_t>(std::floor(sheets.high + depth_rounding));
  const int64_t from = std::max(out.first_gap, plan.gaps.first), to = std::min(out.last_gap, plan.gaps.last);
  if (from > to) return false;
  double half_x = 0, half_y = 0;
  for (int64_t s = from; s <= to; ++s) {
    half_x = std::max<double>(half_x, plan.gaps.half_x[plan.gaps.index(s)]);
    half_y = std::max<double>(half_y, plan.gaps.half_y[plan.gaps.index(s)]);
  }
  if (v.perspective) {
    // Feet are X m, with m between the values at the first and the last gap.
    const double m0 = 1 / base_depth(v, from), m1 = 1 / base_depth(v, to);
    const double foot_x = dot(v.gx, v.ez), foot_y = dot(v.gy, v.ez);
    across = {std::min(across.low * m0, across.low * m1) - foot_x,
              std::max(across.high * m0, across.high * m1) - foot_x};
    down = {std::min(down.low * m0, down.low * m1) - foot_y,
            std::max(down.high * m0, down.high * m1) - foot_y};
  } else {
    half_x += std::fabs(drift_x), half_y += std::fabs(drift_y); // the foot on the sheet before the point
  }
  out.rect = {
      pixel_number(std::floor(across.low - half_x) - 1), pixel_number(std::floor(down.low - half_y) - 1),
      pixel_number(std::ceil(across.high + half_x) + 2), pixel_number(std::ceil(down.high + half_y) + 2)};
  return true;
}

enum class Place : uint8_t { seen, invisible, outside, gone };
struct Candidate {
  PlannedBrick brick;
  Place place = Place::seen;
};

// Decides which bricks and which of their cells a picture needs.
class BrickChoice {
 public:
  BrickChoice(const SplatScene& scene, const SplatScene& ring, const SplatOptions& options, SplatPlan& plan)
      : scene_(scene), ring_(ring), options_(options), plan_(plan), weights_(*scene.slice),
        cells_(useful_cells(scene, options, plan)), look_(look_distance(scene, options, plan)) {
    const double radius = scene.slice->kernel.space.radius, planes = scene.points->plane_distance;
    wide_ = 2 * (radius + look_) > scene.points->edge * planes;
    least_ = cells_ >= 0 ? least_code(scene, options, weights_, looked_at(), plan) : 0;
    if (cells_ >= 0 && options.mode == RenderMode::isosurface && radius <= 4 * planes)
      inside_ = furthest_surface(scene, options);
    if (!inside_) return;
    plan.inside.points = scene.points;
    uint64_t slots = 1;
    for (const int n : scene.points->dims) slots *= n;
    plan.inside.cells.resize(slots);
  }

  // Returns how far away the samples are that all a visible sample is made of looks at, lattice units; as
  // useful_cells() has it.
  [[nodiscard]] double looked_at() const { return (options_.preintegrate ? 2 : 1) * look_; }
  [[nodiscard]] int least() const { return least_; }

  // Judges brick `n` of the points and notes what is known of the surface's inside there.
  [[nodiscard]] Candidate judge_brick(size_t n) const {
    const SplatBrick& brick = scene_.points->bricks[n];
    Candidate out;
    PlannedBrick& b = out.brick;
    b.brick = static_cast<uint32_t>(n);
    b.cells = ~uint64_t{0};
    if (!(options_.disable_skips & skip_transfer_function) && !(options_.preintegrate && wide_) &&
        !shows(scene_, options_, weights_, brick.reach[0], brick.reach[1])) {
      out.place = Place::invisible;
      return out;
    }
    if (inside_)
      plan_.inside.cells[scene_.points->slot(brick)] = inside_cells(*inside_, weights_, ranges(0, n));
    if (!(options_.disable_skips & skip_frustum) && clipped(brick)) {
      out.place = Place::gone;
      return out;
    }
    const bool reached = bound_brick(ring_, plan_, brick, b);
    if (plan_.raise.fan.taps > 0 && reached) fan_rect(plan_, b);
    if (!reached || beside_picture(b.rect)) {
      const bool cull = !(options_.disable_skips & skip_frustum);
      out.place = cull || !reached ? Place::gone : Place::outside;
      if (out.place == Place::gone) return out;
    }
    if (!(options_.disable_skips & (skip_transfer_function | skip_cells)))
      b.cells = near_cells(scene_, brick, look_);
    // Only ranges over a wide enough reach tell what lies beyond a surface.
    if (cells_ >= 0 && (least_ == 0 || inside_))
      b.cells &= needed_cells(scene_, options_, weights_, ranges(cells_, n), inside_);
    b.first_gap = std::max(b.first_gap, plan_.gaps.first);
    b.axes = brick_axes(ring_, plan_, brick);
    return out;
  }

 private:
  [[nodiscard]] const CellRange* ranges(size_t reach, size_t brick) const {
    return scene_.points->cells[reach].data() + brick * cells_per_brick;
  }
  // Returns whether no sample that is seen is made of the brick's points or looks at them.
  [[nodiscard]] bool clipped(const SplatBrick& brick) const {
    const double d = scene_.points->plane_distance, reach = scene_.slice->kernel.space.radius + looked_at();
    Vec3 low, high;
    for (size_t a = 0; a < 3; ++a)
      low[a] = d * (brick.plane[a] + brick.low[a]), high[a] = d * (brick.plane[a] + brick.high[a]);
    return std::any_of(scene_.view->clip.begin(), scene_.view->clip.end(), [&](const HalfSpace& h) {
      double nearest = h.offset;
      for (size_t a = 0; a < 3; ++a) nearest += std::max(h.normal[a] * low[a], h.normal[a] * high[a]);
      return nearest < -reach * length(h.normal);
    });
  }
  [[nodiscard]] bool beside_picture(const std::array<int, 4>& rect) const {
    const SheetView& view = *ring_.view;
    return rect[0] >= view.width + plan_.raise.around || rect[1] >= view.height + plan_.raise.around ||
           rect[2] <= -plan_.raise.around || rect[3] <= -plan_.raise.around;
  }

  const SplatScene &scene_, &ring_;
  const SplatOptions& options_;
  SplatPlan& plan_;
  WeightBounds weights_;
  int cells_;   // of SplatPoints::cells those that tell which are needed; -1: none
  double look_; // how far gradients and crossings look
  int least_ = 0;
  bool wide_ = false; // segments look beyond the bricks around one
  // The surface furthest from the base, where a sample's own cell and those beside it hold all points that it
  // is made of.
  std::optional<double> inside_;
};

// Takes the bricks that are seen over into the plan and counts the others.
void collect_bricks(const std::vector<Candidate>& candidates, const SplatPoints& points, SplatPlan& plan,
                    DrawStats& stats) {
  stats.bricks_total += candidates.size();
  for (const auto& [b, place] : candidates) {
    if (place == Place::invisible) ++stats.bricks_invisible;
    if (place == Place::outside || place == Place::gone) ++stats.bricks_outside;
    if (place == Place::invisible || place == Place::gone) continue;
    const uint32_t count = points.bricks[b.brick].count;
    stats.points_after_cull += count;
    if (b.cells == 0) {
      ++stats.bricks_invisible;
      stats.points_invisible += count;
      continue;
    }
    plan.bricks.push_back(b);
    plan.bricks.back().count = count;
  }
}

void sort_bricks(SplatPlan& plan) {
  for (const PlannedBrick& b : plan.bricks)
    plan.longest = std::max(plan.longest, b.last_gap - b.first_gap + 1);
  std::stable_sort(plan.bricks.begin(), plan.bricks.end(),
                   [](const PlannedBrick& a, const PlannedBrick& b) { return a.first_gap < b.first_gap; });
}

} // namespace

void plan_bricks(const SplatScene& scene, const SplatScene& ring, const SplatOptions& options,
                 const Context& context, MemoryBudget* copies, SplatPlan& plan, DrawStats& stats) {
  const BrickChoice choice(scene, ring, options, plan);
  std::vector<Candidate> candidates(scene.points->bricks.size());
  each_brick(context, candidates.size(), [&](size_t n) { candidates[n] = choice.judge_brick(n); });
  collect_bricks(candidates, *scene.points, plan, stats);
  if (choice.least() > 0 && copies && reserve_copies(*scene.points, *copies, plan.picked))
    pick_points(scene, choice.looked_at(), choice.least(), context, plan, stats);
  sort_bricks(plan);
}

} // namespace bccsplat

#include "splat/plan/plan.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "splat/plan/plan_cells.h"
#include "splat/plan/plan_fan.h"
#include "splat/plan/plan_points.h"
#include "splat/shade/absorption.h"
#include "splat/sheet/sheet_args.h"

namespace bccsplat {
namespace {

// The quadratic form of pixel distances on a sheet at scale 1, lattice units squared.
struct Metric {
  double xx, xy, yy;
  explicit Metric(const SheetView& v) : xx(dot(v.ex, v.ex)), xy(dot(v.ex, v.ey)), yy(dot(v.ey, v.ey)) {}
  [[nodiscard]] double determinant() const { return xx * yy - xy * xy; }
};

// Shift of a foot per sheet, orthographic: zero unless the affine shears the ray off the sheets' normal.
std::array<double, 2> drift(const SheetView& v) {
  if (v.perspective) return {0, 0};
  return {dot(v.gx, v.ez), dot(v.gy, v.ez)};
}

// Whether a sheet's metric is a multiple of the identity and rays run along its normal.
bool isotropic(const SheetView& v) {
  const Metric metric(v);
  const auto [drift_x, drift_y] = drift(v);
  const double largest = std::max(metric.xx, metric.yy);
  return !v.perspective && std::fabs(metric.xy) < 1e-12 * largest &&
         std::fabs(metric.xx - metric.yy) < 1e-12 * largest && std::fabs(drift_x) < 1e-9 &&
         std::fabs(drift_y) < 1e-9;
}

// Depth of a gap's reference sheet, in sheet steps from the eye: never behind the first sheet.
double reference_depth(const SheetView& v, int64_t gap) {
  return static_cast<double>(std::max(gap, v.first_sheet())) + v.depth;
}

void plan_gaps(const SplatScene& scene, SplatPlan& plan) {
  const SheetView& v = *scene.view;
  const double radius = scene.slice->kernel.space.radius;
  const Metric metric(v);
  const auto [drift_x, drift_y] = drift(v);
  plan.isotropic = isotropic(v);
  plan.depth2 = v.step * v.step / (radius * radius);

  const double reach = std::ceil(radius / v.step - 1e-9);
  if (!(2 * reach <= max_ring_sheets))
    fail(Code::invalid_argument, "render: sheet_step ", v.step, " is below ", 2 * radius / max_ring_sheets);
  plan.after = static_cast<int>(reach);
  plan.before = plan.after - 1;
  plan.sheets = (2 * plan.after + 3) / 4 * 4;
  plan.groups = plan.sheets / 4;

  plan.first_gap = plan.ring_first - plan.after;
  plan.last_gap = plan.ring_last + plan.before;
  const auto gaps = static_cast<size_t>(plan.last_gap - plan.first_gap + 1);
  plan.lane_period = v.perspective ? 0 : plan.sheets;
  const size_t sets = plan.lane_period ? static_cast<size_t>(plan.lane_period) : gaps;
  const auto ring = static_cast<size_t>(plan.sheets);
  plan.lane_data.resize(sets * 6 * ring);
  plan.lateral.resize(gaps), plan.half_x.resize(gaps), plan.half_y.resize(gaps);
  plan.columns.resize(gaps), plan.rows.resize(gaps);

  // Extent of a unit ball of this metric along x and y, pixels.
  const double extent_x = std::sqrt(metric.yy / metric.determinant()),
               extent_y = std::sqrt(metric.xx / metric.determinant());
  // Farthest pixels from the foot of the eye: bounds of |X| and |Y| of points that are seen.
  const double foot_x = -dot(v.gx, v.ez), foot_y = -dot(v.gy, v.ez);
  const double halo = 2 + plan.around;
  const double far_x = std::max(std::fabs(foot_x), std::fabs(v.width - 1 - foot_x)) + halo;
  const double far_y = std::max(std::fabs(foot_y), std::fabs(v.height - 1 - foot_y)) + halo;
  for (size_t n = 0; n < std::max(gaps, sets); ++n) {
    // Orthographic lanes are stored by gap modulo the period.
    const int64_t s =
        plan.lane_period && n >= gaps ? static_cast<int64_t>(n) : plan.first_gap + static_cast<int64_t>(n);
    const double depth = reference_depth(v, s);
    double half_x = 0, half_y = 0;
    for (int64_t k = s - plan.before; k < s - plan.before + plan.sheets; ++k) {
      const double scale = v.perspective ? static_cast<double>(k) + v.depth : 1;
      const bool exists = k >= v.first_sheet();
      const double delta = !v.perspective ? static_cast<double>(k - s) : exists ? 1 / scale - 1 / depth : 0;
      const double h = v.step * std::max({0.0, static_cast<double>(s - k), static_cast<double>(k - s - 1)});
      if (exists && h < radius) {
        const double rho = std::sqrt(radius * radius - h * h) / scale;
        const double x = rho * extent_x, y = rho * extent_y;
        half_x = std::max(half_x,
                          x + std::fabs(delta) * (v.perspective ? (far_x + x) * scale : std::fabs(drift_x)));
        half_y = std::max(half_y,
                          y + std::fabs(delta) * (v.perspective ? (far_y + y) * scale : std::fabs(drift_y)));
      }
      const auto slot = static_cast<size_t>(((k % plan.sheets) + plan.sheets) % plan.sheets);
      const size_t set =
          plan.lane_period ? static_cast<size_t>(((s % plan.sheets) + plan.sheets) % plan.sheets) : n;
      float* lanes = plan.lane_data.data() + set * 6 * ring + slot;
      const double form = scale * scale / (radius * radius);
      // A sheet behind the eye is out of reach of everything.
      lanes[0] = exists ? static_cast<float>(k - s) : 1e6f;
      lanes[ring] = static_cast<float>(delta);
      lanes[2 * ring] = exists ? static_cast<float>(metric.xx * form) : 0;
      lanes[3 * ring] = exists ? static_cast<float>(2 * metric.xy * form) : 0;
      lanes[4 * ring] = exists ? static_cast<float>(metric.yy * form) : 0;
      lanes[5 * ring] = exists ? static_cast<float>(metric.determinant() / metric.yy * form) : 0;
    }
    if (n >= gaps) continue;
    plan.lateral[n] = static_cast<float>(v.perspective ? 1 / depth : static_cast<double>(n));
    plan.half_x[n] = static_cast<float>(half_x), plan.half_y[n] = static_cast<float>(half_y);
    plan.columns[n] = static_cast<int32_t>(std::clamp(std::ceil(2 * half_x), 1.0, 1e8));
    plan.rows[n] = static_cast<int32_t>(std::clamp(std::ceil(2 * half_y), 1.0, 1e8));
  }
}

// The view of the sheets' own samples, where they are worth it, and the tables that raise them.
SheetView plan_samples(const SplatScene& scene, const SplatOptions& options, SplatPlan& plan) {
  SheetView v = *scene.view;
  const RaiseFilter& filter = options.raise;
  const bool radial = kernel_polynomial(scene.slice->kernel.space).form == KernelPolynomial::Form::square_8;
  const bool sums = options.mode == RenderMode::composite && options.shading &&
                    options.gradient == GradientMethod::analytic;
  plan.around = plan.border;
  plan.ring_first = plan.first_sheet - plan.lead, plan.ring_last = plan.last_sheet + plan.lead;
  if (filter.taps == 0 || !radial || scene.slice->kernel.normalised || sums) return v;
  if (plan_fan(filter, plan, v)) plan.taps = filter.taps;
  const double ratio_z = filter.depth > 0 ? 1 / (filter.depth * v.step) : 0;
  const int64_t sheets = plan.last_sheet - plan.first_sheet + 1 + 4 * plan.lead;
  if (ratio_z >= 1.9 && !v.perspective && sheets < 1 << 20) {
    plan.depth_taps = filter.taps;
    plan.raise_z =
        make_raise_axis(ratio_z, filter.depth, plan.depth_taps,
                        static_cast<int>(plan.first_sheet) - 2 * plan.lead, static_cast<int>(sheets));
    plan.ring_first = plan.raise_z.at(static_cast<int>(plan.ring_first));
    plan.ring_last = plan.raise_z.at(static_cast<int>(plan.ring_last)) + plan.depth_taps - 1;
    v.ez = ratio_z * v.ez;
    v.step *= ratio_z, v.step_world *= ratio_z;
  }
  if (plan.taps > 0) {
    plan.around = plan.taps / 2 + plan.border + 1;
    return v;
  }
  // Pixels per T where the picture shows the smallest of them: at the last sheet.
  const Metric metric(v);
  const double scale = v.scale(static_cast<double>(plan.last_sheet + plan.lead));
  const double pixels_x = std::sqrt(metric.yy / metric.determinant()) / scale,
               pixels_y = std::sqrt(metric.xx / metric.determinant()) / scale;
  const double ratio_x = pixels_x / filter.density, ratio_y = pixels_y / filter.density;
  if (!(std::min(ratio_x, ratio_y) >= std::max(1.0, isotropic(v) ? filter.from : filter.from_general)))
    return v;
  plan.taps = filter.taps;
  plan.raise_x = make_raise_axis(ratio_x, filter.density, plan.taps, -plan.border, v.width + 2 * plan.border);
  plan.raise_y =
      make_raise_axis(ratio_y, filter.density, plan.taps, -plan.border, v.height + 2 * plan.border);
  plan.around = plan.taps / 2 + static_cast<int>(std::ceil(plan.border / std::min(ratio_x, ratio_y))) + 1;
  v.ex = ratio_x * v.ex, v.ey = ratio_y * v.ey;
  v.gx = (1 / ratio_x) * v.gx, v.gy = (1 / ratio_y) * v.gy;
  v.width = static_cast<int>(std::ceil(v.width / ratio_x)) + 1;
  v.height = static_cast<int>(std::ceil(v.height / ratio_y)) + 1;
  return v;
}

// Which rows the sheets of a group reach: in any column where the window is not large, else in each four
// columns. The foot stands between half - 1 and half pixels from the window's start.
void plan_rows(const SplatScene& scene, SplatPlan& plan) {
  constexpr int most = 4096;
  if (!plan.isotropic || plan.rows[0] > most) return;
  const double radius = scene.slice->kernel.space.radius;
  const double pixels = radius / std::sqrt(Metric(*scene.view).xx); // of the kernel's radius
  const auto half_x = static_cast<double>(plan.half_x[0]), half_y = static_cast<double>(plan.half_y[0]);
  const bool by_column = plan.large_window();
  plan.row_columns = by_column ? (plan.columns[0] + 3) / 4 : 1;
  plan.row_ranges.resize(static_cast<size_t>(plan.lane_period * plan.groups * plan.row_columns * 2));
  for (int set = 0; set < plan.lane_period; ++set) {
    const float* offset =
        plan.lane_data.data() + static_cast<size_t>(set) * 6 * static_cast<size_t>(plan.sheets);
    for (int g = 0; g < plan.groups; ++g) {
      double near = 1e30; // sheets between the gap and the nearest sheet of the group
      for (int l = 0; l < 4; ++l) {
        const auto k = static_cast<double>(offset[4 * g + l]);
        near = std::min(near, std::max({0.0, -k, k - 1}));
      }
      for (int n = 0; n < plan.row_columns; ++n) {
        const double across = by_column ? std::max({0.0, half_x - 1 - (4 * n + 3), 4 * n - half_x}) : 0;
        const double square = pixels * pixels * (1 - plan.depth2 * near * near) - across * across;
        int16_t* range =
            &plan.row_ranges[static_cast<size_t>(((set * plan.groups + g) * plan.row_columns + n) * 2)];
        if (square <= 0) continue; // none
        const double reach = std::sqrt(square) + 1e-3;
        range[0] = static_cast<int16_t>(std::max(0.0, std::ceil(half_y - 1 - reach)));
        range[1] = static_cast<int16_t>(std::min<double>(plan.rows[0], std::floor(half_y + reach) + 1));
      }
    }
  }
}

// Small windows get room around the tile's ring: clipping them would cost more than it saves.
void plan_spare(SplatPlan& plan) {
  constexpr int small = 8;
  plan.spare = plan.isotropic && plan.columns[0] <= small && plan.rows[0] <= small;
  if (!plan.spare) return;
  plan.spare_columns = 12; // at most 7 columns to the left, 7 and the rest of a vector to the right
  plan.spare_rows = plan.rows[0];
}

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
    m = 1 / reference_depth(v, f.k);
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
    f.m = static_cast<float>(f.k - plan.first_gap);
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

// Gaps and pixels that the points of a brick may touch. False when there are none in front of the eye.
bool bound_brick(const SplatScene& scene, const SplatPlan& plan, const SplatBrick& brick, PlannedBrick& out) {
  const SheetView& v = *scene.view;
  const double d = scene.points->plane_distance;
  Vec3 low, high;
  for (size_t a = 0; a < 3; ++a)
    low[a] = d * (brick.plane[a] + brick.low[a]), high[a] = d * (brick.plane[a] + brick.high[a]);
  double near = 1e300, far = -1e300;
  double x0 = 1e300, x1 = -1e300, y0 = 1e300, y1 = -1e300; // of X and Y
  const auto [drift_x, drift_y] = drift(v);
  for (const Vec3& c : box_corners(low, high)) {
    const double k = v.sheet(c);
    near = std::min(near, k), far = std::max(far, k);
    const double shift = v.perspective ? 0 : k;
    const double x = dot(v.gx, c - v.eye) - shift * drift_x, y = dot(v.gy, c - v.eye) - shift * drift_y;
    x0 = std::min(x0, x), x1 = std::max(x1, x), y0 = std::min(y0, y), y1 = std::max(y1, y);
  }
  out.first_gap = static_cast<int64_t>(std::floor(near - 1e-4));
  out.last_gap = static_cast<int64_t>(std::floor(far + 1e-4));
  const int64_t from = std::max(out.first_gap, plan.first_gap), to = std::min(out.last_gap, plan.last_gap);
  if (from > to) return false;
  double half_x = 0, half_y = 0;
  for (int64_t s = from; s <= to; ++s) {
    half_x = std::max<double>(half_x, plan.half_x[static_cast<size_t>(s - plan.first_gap)]);
    half_y = std::max<double>(half_y, plan.half_y[static_cast<size_t>(s - plan.first_gap)]);
  }
  if (v.perspective) {
    // Feet are X m with m between those of the first and last gap.
    const double m0 = 1 / reference_depth(v, from), m1 = 1 / reference_depth(v, to);
    const double foot_x = dot(v.gx, v.ez), foot_y = dot(v.gy, v.ez);
    const double fx0 = std::min(x0 * m0, x0 * m1) - foot_x, fx1 = std::max(x1 * m0, x1 * m1) - foot_x;
    const double fy0 = std::min(y0 * m0, y0 * m1) - foot_y, fy1 = std::max(y1 * m0, y1 * m1) - foot_y;
    x0 = fx0, x1 = fx1, y0 = fy0, y1 = fy1;
  } else {
    half_x += std::fabs(drift_x), half_y += std::fabs(drift_y); // the foot on the sheet before the point
  }
  const auto pixel = [](double p) { return static_cast<int>(std::clamp(p, -1e8, 1e8)); };
  out.rect = {pixel(std::floor(x0 - half_x) - 1), pixel(std::floor(y0 - half_y) - 1),
              pixel(std::ceil(x1 + half_x) + 2), pixel(std::ceil(y1 + half_y) + 2)};
  return true;
}

int choose_tile_size(const SplatPlan& plan, const SplatOptions& options, const SheetView& view, int threads) {
  if (options.tile_size > 0) return std::min(options.tile_size, 4096);
  const bool gradients = options.mode == RenderMode::composite && options.shading &&
                         options.gradient == GradientMethod::analytic;
  // The ring of a tile should stay well inside the L2 cache; with its border it fills whole vectors.
  int size = 144;
  const int floats = plan.sheets * (gradients ? 4 : 1); // per pixel
  while (size > 16 && size * size * floats > (floats <= 8 ? 196608 : 131072)) size -= 16;
  // Enough tiles to share out.
  while (size > 16 && (view.width / size + 1) * (view.height / size + 1) < 8 * threads && threads > 1)
    size -= 16;
  size -= 2 * plan.border;
  // No narrow tiles at the end: their surroundings would be drawn once more for little.
  const int side = std::max(view.width, view.height), count = (side + size - 1) / size;
  return (side + count - 1) / count;
}

} // namespace

PlannedTile plan_tile(const SplatPlan& plan, int x, int y, int width, int height) {
  PlannedTile t{x,
                y,
                width,
                height,
                x - plan.border,
                y - plan.border,
                width + 2 * plan.border,
                height + 2 * plan.border,
                {}};
  if (plan.taps == 0) return t;
  if (plan.fan.taps > 0) {
    const Scales all = gap_scales(plan, plan.first_gap, plan.last_gap);
    const auto [x0, x1] = fan_samples(plan.fan, plan.fan.x, all, {x, x + width});
    const auto [y0, y1] = fan_samples(plan.fan, plan.fan.y, all, {y, y + height});
    t.ring_x = x0, t.ring_y = y0, t.ring_width = x1 - x0, t.ring_height = y1 - y0;
    return t;
  }
  const int right = x + width - 1 + plan.border, below = y + height - 1 + plan.border;
  t.ring_x = plan.raise_x.at(t.ring_x), t.ring_y = plan.raise_y.at(t.ring_y);
  t.ring_width = plan.raise_x.at(right) + plan.taps - t.ring_x;
  t.ring_height = plan.raise_y.at(below) + plan.taps - t.ring_y;
  return t;
}

SplatPlan make_plan(const SplatScene& scene, const SplatOptions& options, Tasks& tasks, SplatStats& stats,
                    MemoryBudget* copies, bool with_points) {
  SplatPlan plan;
  const SheetView& view = *scene.view;
  const bool shaded = options.mode == RenderMode::composite && options.shading;
  if (shaded && options.gradient == GradientMethod::central) plan.border = plan.lead = 1;
  if (shaded && options.gradient == GradientMethod::fourth_order) plan.border = plan.lead = 2;
  if (options.mode == RenderMode::isosurface) plan.lead = 2;
  if (options.preintegrate) {
    plan.halfway = halfway_sheets(view);
    plan.lead = std::max(plan.lead, plan.halfway);
  }
  const auto [first, last] = sheet_range(*scene.slice, view);
  plan.first_sheet = first, plan.last_sheet = last;
  plan.air_visible =
      options.mode == RenderMode::maximum ||
      (options.mode == RenderMode::composite && scene.table->visible(scene.slice->air, scene.slice->air));
  if (options.mode == RenderMode::composite && !view.perspective) {
    const auto path = static_cast<float>(length(view.lattice_to_world.vector(view.ez)));
    plan.whole_sheet = scene.table->entry;
    for (auto& entry : plan.whole_sheet) entry[3] = absorbed(entry[3] * path);
  }

  SheetView sampled = view;
  SplatScene ring = scene; // as the sheets' samples see it
  ring.view = &sampled;
  const int size = [&] {
    if (plan.first_sheet <= plan.last_sheet) {
      sampled = plan_samples(scene, options, plan);
      plan_gaps(ring, plan);
      plan_rows(ring, plan);
      plan_spare(plan);
    }
    return choose_tile_size(plan, options, view, tasks.threads());
  }();
  const int nx = (view.width + size - 1) / size, ny = (view.height + size - 1) / size;
  for (int y = 0; y < ny; ++y)
    for (int x = 0; x < nx; ++x)
      plan.tiles.push_back(plan_tile(plan, x * size, y * size, std::min(size, view.width - x * size),
                                     std::min(size, view.height - y * size)));
  stats.tiles = plan.tiles.size();
  stats.sheets = first <= last ? static_cast<uint64_t>(last - first + 1) : 0;
  if (first > last || !with_points) return plan;

  const auto& bricks = scene.points->bricks;
  enum class Place : uint8_t { kept, invisible, outside, gone };
  struct Candidate {
    PlannedBrick brick;
    Place place = Place::kept;
  };
  std::vector<Candidate> candidates(bricks.size());
  const bool cull = !(options.disable_skips & skip_frustum);
  const int cells = useful_cells(scene, options, plan);
  const double look = look_distance(scene, options, plan);
  const WeightBounds weights(*scene.slice);
  // What segments look at may lie beyond the bricks around one.
  const bool wide =
      2 * (scene.slice->kernel.space.radius + look) > scene.points->edge * scene.points->plane_distance;
  const double looked_at = (options.preintegrate ? 2 : 1) * look; // as useful_cells()
  const int least = cells >= 0 ? least_code(scene, options, weights, looked_at, plan) : 0;
  const auto ranges = [&](size_t reach, size_t brick) {
    return scene.points->cells[reach].data() + brick * cells_per_brick;
  };
  // A sample's own cell and those beside it hold all points it is made of.
  const bool inside = cells >= 0 && options.mode == RenderMode::isosurface &&
                      scene.slice->kernel.space.radius <= 4 * scene.points->plane_distance;
  if (inside) {
    plan.inside.points = scene.points;
    uint64_t slots = 1;
    for (const int n : scene.points->dims) slots *= static_cast<uint64_t>(n);
    plan.inside.cells.resize(slots);
  }
  constexpr size_t share = 64;
  tasks.parallel_for((bricks.size() + share - 1) / share, [&](uint64_t part) {
    for (size_t n = part * share; n < std::min(bricks.size(), (part + 1) * share); ++n) {
      const SplatBrick& brick = bricks[n];
      PlannedBrick& b = candidates[n].brick;
      b.brick = static_cast<uint32_t>(n);
      b.cells = ~uint64_t{0};
      if (!(options.disable_skips & skip_transfer_function) && !(options.preintegrate && wide) &&
          !shows(scene, options, weights, brick.reach[0], brick.reach[1])) {
        candidates[n].place = Place::invisible;
        continue;
      }
      if (inside)
        plan.inside.cells[scene.points->slot(brick)] =
            inside_cells(scene, options.iso_value, weights, ranges(0, n));
      const bool reached = bound_brick(ring, plan, brick, b);
      if (plan.fan.taps > 0 && reached) fan_rect(plan, b);
      if (!reached || b.rect[0] >= sampled.width + plan.around || b.rect[1] >= sampled.height + plan.around ||
          b.rect[2] <= -plan.around || b.rect[3] <= -plan.around) {
        candidates[n].place = cull || !reached ? Place::gone : Place::outside;
        if (cull || !reached) continue;
      }
      if (!(options.disable_skips & (skip_transfer_function | skip_cells)))
        b.cells = near_cells(scene, brick, look);
      // What lies beyond a surface only the larger cells tell.
      if (cells >= 0 && (least == 0 || inside))
        b.cells &= needed_cells(scene, options, weights, ranges(static_cast<size_t>(cells), n), inside);
      b.first_gap = std::max(b.first_gap, plan.first_gap);
      b.axes = brick_axes(ring, plan, brick);
    }
  });
  for (const auto& [b, place] : candidates) {
    if (place == Place::invisible) ++stats.bricks_invisible;
    if (place == Place::outside || place == Place::gone) ++stats.bricks_outside;
    if (place == Place::invisible || place == Place::gone) continue;
    const uint32_t count = bricks[b.brick].count;
    stats.points_after_cull += count;
    if (b.cells == 0) {
      stats.points_invisible += count;
      continue;
    }
    plan.bricks.push_back(b);
    plan.bricks.back().count = count;
  }
  if (least > 0 && copies && reserve_copies(*scene.points, *copies, plan.picked))
    pick_points(scene, looked_at, least, tasks, plan, stats);
  for (const PlannedBrick& b : plan.bricks)
    plan.longest = std::max(plan.longest, b.last_gap - b.first_gap + 1);
  std::stable_sort(plan.bricks.begin(), plan.bricks.end(),
                   [](const PlannedBrick& a, const PlannedBrick& b) { return a.first_gap < b.first_gap; });
  for (uint32_t n = 0; n < plan.bricks.size(); ++n) {
    const auto& r = plan.bricks[n].rect;
    const bool fan = plan.fan.taps > 0; // rectangles of pixels, not of samples
    const int around = fan ? 0 : plan.around;
    const auto tile = [&](int sample, double ratio, int count) {
      const double pixel = std::clamp(sample * (fan ? 1 : ratio), -1.0, 1e9);
      return std::clamp(static_cast<int>(std::floor(pixel / size)), 0, count - 1);
    };
    const auto meet = [&](int begin, int end, int from, int count) {
      return begin < from + count && end > from;
    };
    const double rx = plan.raise_x.ratio, ry = plan.raise_y.ratio;
    for (int y = tile(r[1] - around, ry, ny); y <= tile(r[3] - 1 + around, ry, ny); ++y)
      for (int x = tile(r[0] - around, rx, nx); x <= tile(r[2] - 1 + around, rx, nx); ++x) {
        PlannedTile& t = plan.tiles[static_cast<size_t>(y * nx + x)];
        if (fan ? meet(r[0], r[2], t.x, t.width) && meet(r[1], r[3], t.y, t.height)
                : meet(r[0], r[2], t.ring_x, t.ring_width) && meet(r[1], r[3], t.ring_y, t.ring_height))
          t.bricks.push_back(n);
      }
  }
  return plan;
}

} // namespace bccsplat

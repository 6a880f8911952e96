// SPDX-License-Identifier: Apache-2.0
// Plans a picture before its tiles start, in the order of make_plan() at the end: the sheets, whether they
// are sampled more coarsely than the picture and raised to it, the lanes and windows of every gap, the tiles,
// and the bricks that each of them needs. The notes on the limits are tests/bench/notes/splat.md,
// raised-sheets.md and render-speed.md.
#include "splat/plan/plan.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "splat/plan/plan_bricks.h"
#include "splat/plan/plan_corrections.h"
#include "splat/plan/plan_fan.h"
#include "splat/plan/plan_tiles.h"
#include "splat/plan/sheet_metric.h"
#include "splat/shade/absorption.h"
#include "splat/sheet/sheet_args.h"

namespace bccsplat {
namespace {

// Sheets closer than half of what the filter asks for are raised along their normal; the ratio is a little
// less than 2, so that 2 itself counts after rounding. Tables are made for fewer than this many sheets.
constexpr double least_depth_ratio = 1.9;
constexpr int64_t most_raised_sheets = 1 << 20;
// Windows of more rows have no table of them: its entries are 16 bits wide.
constexpr int most_table_rows = 4096;
// Windows of up to this many pixels a side are not clipped: room around the ring, which is larger for it,
// takes what they would lose. No measurement of the limit is noted.
constexpr int most_unclipped = 8;

// Pixels of a tile, in steps of whole vectors. Larger tiles draw fewer points twice, as long as the ring
// stays well inside the L2 cache: tiles of up to 140 pixels took 1 to 5 % less time than those of 92, of 256
// pixels 4 % more (tests/bench/notes/render-speed.md).
constexpr int largest_tile = 144, smallest_tile = 16, tile_step = 16;
// Floats of a tile's ring; thin rings, of few sheets per pixel, may be larger. This trades points that are
// drawn in two tiles for rings that stay in the cache. No measurement of the limits is noted.
constexpr int thin_ring = 8, most_thin_floats = 196608, most_floats = 131072;
// More draw more points twice; tiles that hold too much for one thread are cut by divide_tiles().
constexpr int tiles_per_thread = 2;
// Where a thread has less memory, bytes, tiles are small and there are more.
constexpr uint64_t roomy = 16 << 20;
constexpr int small_tiles_per_thread = 8;
constexpr int most_tile_size = 4096; // that a caller may ask for

void plan_gaps(const SplatScene& scene, SplatPlan& plan) {
  const SheetView& v = *scene.view;
  const double radius = scene.slice->kernel.space.radius;
  const SheetMetric metric(v);
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
  // The farthest pixels from the foot of the eye bound |X| and |Y| of the points that are seen.
  const double foot_x = -dot(v.gx, v.ez), foot_y = -dot(v.gy, v.ez);
  const double halo = 2 + plan.around;
  const double far_x = std::max(std::fabs(foot_x), std::fabs(v.width - 1 - foot_x)) + halo;
  const double far_y = std::max(std::fabs(foot_y), std::fabs(v.height - 1 - foot_y)) + halo;
  for (size_t n = 0; n < std::max(gaps, sets); ++n) {
    // Orthographic lanes are stored by gap modulo the period.
    const int64_t s =
        plan.lane_period && n >= gaps ? static_cast<int64_t>(n) : plan.first_gap + static_cast<int64_t>(n);
    const double depth = base_depth(v, s);
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

// Returns the view of the sheets' own samples, where having them pays, and makes the tables that raise them;
// elsewhere the samples are the pixels.
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
  if (ratio_z >= least_depth_ratio && !v.perspective && sheets < most_raised_sheets) {
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
  const SheetMetric metric(v);
  const double scale = v.scale(static_cast<double>(plan.last_sheet + plan.lead));
  const auto [pixels_x, pixels_y] = metric.pixels_per_unit();
  const double ratio_x = pixels_x / scale / filter.density, ratio_y = pixels_y / scale / filter.density;
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

// Lists the rows that the sheets of a group reach: in any column where the window is not large, else per four
// columns. The foot lies between half - 1 and half pixels from the window's start.
void plan_rows(const SplatScene& scene, SplatPlan& plan) {
  if (!plan.isotropic || plan.rows[0] > most_table_rows) return;
  const double radius = scene.slice->kernel.space.radius;
  const double pixels = radius / std::sqrt(SheetMetric(*scene.view).xx); // of the kernel's radius
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
  plan.spare = plan.isotropic && plan.columns[0] <= most_unclipped && plan.rows[0] <= most_unclipped;
  if (!plan.spare) return;
  plan.spare_columns = 12; // at most 7 columns to the left, 7 and the rest of a vector to the right
  plan.spare_rows = plan.rows[0];
}

int choose_tile_size(const SplatPlan& plan, const SplatOptions& options, const SheetView& view,
                     const Context& context) {
  if (options.tile_size > 0) return std::min(options.tile_size, most_tile_size);
  const bool gradients = options.mode == RenderMode::composite && options.shading &&
                         options.gradient == GradientMethod::analytic;
  // With its border a tile fills whole vectors.
  int size = largest_tile;
  const int floats = plan.sheets * (gradients ? 4 : 1); // per pixel
  const int most = floats <= thin_ring ? most_thin_floats : most_floats;
  while (size > smallest_tile && size * size * floats > most) size -= tile_step;
  const int threads = context.tasks.threads();
  // By the limit, not by what is left: the same view has the same tiles (kept_sheets.h).
  const int least = context.memory.limit() / static_cast<uint64_t>(threads) < roomy ? small_tiles_per_thread
                                                                                    : tiles_per_thread;
  const auto tiles = [&] { return (view.width / size + 1) * (view.height / size + 1); };
  while (threads > 1 && size > smallest_tile && tiles() < least * threads) size -= tile_step;
  size -= 2 * plan.border;
  // Tiles are made alike, for narrow ones at the end would have their surroundings drawn once more for
  // little.
  const int side = std::max(view.width, view.height), count = (side + size - 1) / size;
  return (side + count - 1) / count;
}

} // namespace

PlannedTile plan_tile(const SplatPlan& plan, int x, int y, int width, int height) {
  PlannedTile t;
  t.x = x, t.y = y, t.width = width, t.height = height;
  t.ring_x = x - plan.border, t.ring_y = y - plan.border;
  t.ring_width = width + 2 * plan.border, t.ring_height = height + 2 * plan.border;
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

namespace {

// The sheets of the picture, and how far gradients, crossings and segments look from them.
void plan_sheets(const SplatScene& scene, const SplatOptions& options, SplatPlan& plan) {
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
}

// Differences of composites see too little of the ripple to need them.
std::shared_ptr<const LatticeSums> sums_of(const SplatScene& scene, const SplatOptions& options) {
  if (!options.without_ripple || !options.shading) return nullptr;
  if (options.mode != RenderMode::composite) return lattice_sums(*scene.slice);
  if (options.gradient != GradientMethod::analytic) return nullptr;
  return lattice_sums(*scene.slice, drawn_kernel(scene.slice->kernel.space, options.kernel_form));
}

// What is classified alike in all tiles.
void plan_classes(const SplatScene& scene, const SplatOptions& options, SplatPlan& plan) {
  const SheetView& view = *scene.view;
  const float base = scene.slice->base;
  plan.base_visible = options.mode == RenderMode::maximum ||
                      (options.mode == RenderMode::xray && base != scene.slice->air) ||
                      (options.mode == RenderMode::composite && scene.table->visible(base, base));
  if (options.mode != RenderMode::composite || view.perspective) return;
  const auto path = static_cast<float>(length(view.lattice_to_world.vector(view.ez)));
  plan.whole_sheet = scene.table->entry;
  for (auto& entry : plan.whole_sheet) entry[3] = absorbed(entry[3] * path);
}

// The picture cut into tiles of one size, row by row.
struct TileGrid {
  int size, columns, rows;
  TileGrid(const SheetView& view, int tile_size)
      : size(tile_size), columns((view.width + size - 1) / size), rows((view.height + size - 1) / size) {}
};

void cut_tiles(const SheetView& view, const TileGrid& grid, SplatPlan& plan) {
  for (int y = 0; y < grid.rows; ++y)
    for (int x = 0; x < grid.columns; ++x)
      plan.tiles.push_back(plan_tile(plan, x * grid.size, y * grid.size,
                                     std::min(grid.size, view.width - x * grid.size),
                                     std::min(grid.size, view.height - y * grid.size)));
}

// Gives every tile the bricks whose points may reach its ring.
void deal_bricks(const TileGrid& grid, SplatPlan& plan) {
  const bool fan = plan.fan.taps > 0; // rectangles of pixels, not of samples
  const int around = fan ? 0 : plan.around;
  const auto tile = [&](int sample, double ratio, int count) {
    const double pixel = std::clamp(sample * (fan ? 1 : ratio), -1.0, 1e9);
    return std::clamp(static_cast<int>(std::floor(pixel / grid.size)), 0, count - 1);
  };
  const double rx = plan.raise_x.ratio, ry = plan.raise_y.ratio;
  for (uint32_t n = 0; n < plan.bricks.size(); ++n) {
    const auto& r = plan.bricks[n].rect;
    const int x0 = tile(r[0] - around, rx, grid.columns), x1 = tile(r[2] - 1 + around, rx, grid.columns);
    const int y0 = tile(r[1] - around, ry, grid.rows), y1 = tile(r[3] - 1 + around, ry, grid.rows);
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x) {
        PlannedTile& t = plan.tiles[static_cast<size_t>(y * grid.columns + x)];
        if (meets_tile(plan, plan.bricks[n], t)) t.bricks.push_back(n);
      }
  }
}

} // namespace

SplatPlan make_plan(const SplatScene& scene, const SplatOptions& options, const Context& context,
                    SplatStats& stats, MemoryBudget* copies, bool with_points) {
  SplatPlan plan;
  const SheetView& view = *scene.view;
  plan_sheets(scene, options, plan);
  plan_classes(scene, options, plan);
  const bool empty = plan.first_sheet > plan.last_sheet;
  plan.sums = sums_of(scene, options);

  SheetView sampled = view;
  SplatScene ring = scene; // as the sheets' samples see it
  ring.view = &sampled;
  if (!empty) {
    sampled = plan_samples(scene, options, plan);
    plan_gaps(ring, plan);
    plan_rows(ring, plan);
    plan_spare(plan);
  }
  const TileGrid grid(view, choose_tile_size(plan, options, view, context));
  cut_tiles(view, grid, plan);
  stats.tiles = plan.tiles.size();
  stats.sheets = empty ? 0 : static_cast<uint64_t>(plan.last_sheet - plan.first_sheet + 1);
  if (!empty) plan_corrections(scene, plan);
  if (empty || !with_points) return plan;

  plan_bricks(scene, ring, options, context, copies, plan, stats);
  context.progress.check();
  deal_bricks(grid, plan);
  return plan;
}

} // namespace bccsplat

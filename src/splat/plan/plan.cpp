// SPDX-License-Identifier: Apache-2.0
// Plans a picture before its tiles start, in the order of make_plan() at the end: the sheets, whether they
// are sampled more coarsely than the picture and raised to it, the lanes and windows of every gap, the tiles,
// and the bricks that each of them needs. The notes on the limits are tests/bench/notes/splat.md,
// raised-sheets.md and render-speed.md.
#include "splat/plan/plan.h"

#include <algorithm>
#include <cmath>

#include "shade/absorption.h"
#include "splat/plan/plan_bricks.h"
#include "splat/plan/plan_corrections.h"
#include "splat/plan/plan_fan.h"
#include "splat/plan/plan_tiles.h"
#include "splat/sheet/sheet_args.h"
#include "view/sheet_metric.h"

namespace bccsplat {
namespace {

// Sheets closer than half of what the filter asks for are raised along their normal; the ratio is a little
// less than 2, so that 2 itself counts after rounding. Tables are made for fewer than this many sheets.
constexpr double least_depth_ratio = 1.9;
constexpr int64_t most_raised_sheets = 1 << 20;
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

// Returns the pixel, at most one sample before the first, that a sample stands at so that one stands at a
// place of the world, its origin or the foot of the eye: samples are the same in all parts of a picture.
// per_pixel: gx or gy.
double first_sample(const SheetView& v, const Vec3& per_pixel, double ratio) {
  const double place = v.perspective ? -dot(per_pixel, v.ez)
                                     : dot(per_pixel, v.lattice_to_world.inverse().point({0, 0, 0}) - v.eye);
  return place - std::ceil(place / ratio) * ratio;
}

// Returns the view of the sheets' own samples, where having them pays, and makes the tables that raise them;
// elsewhere the samples are the pixels.
SheetView plan_samples(const SplatScene& scene, const SplatOptions& options, SplatPlan& plan) {
  SheetView v = *scene.view;
  const RaiseFilter& filter = options.raise;
  const bool radial = kernel_polynomial(scene.slice->kernel.space).form == KernelPolynomial::Form::square_8;
  const bool sums = options.mode == RenderMode::composite && options.shading &&
                    options.gradient == GradientMethod::analytic;
  plan.raise.around = plan.sheets.border;
  plan.ring.first_sheet = plan.sheets.first - plan.sheets.lead,
  plan.ring.last_sheet = plan.sheets.last + plan.sheets.lead;
  if (filter.taps == 0 || !radial || scene.slice->kernel.normalised || sums) return v;
  if (plan_fan(filter, plan, v)) plan.raise.taps = filter.taps;
  const double ratio_z = filter.depth > 0 ? 1 / (filter.depth * v.step) : 0;
  const int64_t sheets = plan.sheets.last - plan.sheets.first + 1 + 4 * plan.sheets.lead;
  if (ratio_z >= least_depth_ratio && !v.perspective && sheets < most_raised_sheets) {
    plan.raise.depth_taps = filter.taps;
    plan.raise.z =
        make_raise_axis(ratio_z, filter.depth, plan.raise.depth_taps,
                        static_cast<int>(plan.sheets.first) - 2 * plan.sheets.lead, static_cast<int>(sheets));
    plan.ring.first_sheet = plan.raise.z.at(static_cast<int>(plan.ring.first_sheet));
    plan.ring.last_sheet =
        plan.raise.z.at(static_cast<int>(plan.ring.last_sheet)) + plan.raise.depth_taps - 1;
    v.ez = ratio_z * v.ez;
    v.step *= ratio_z, v.step_world *= ratio_z;
  }
  if (plan.raise.taps > 0) {
    plan.raise.around = plan.raise.taps / 2 + plan.sheets.border + 1;
    return v;
  }
  // Pixels per T where the picture shows the smallest of them: at the last sheet.
  const SheetMetric metric(v);
  const double scale = v.scale(static_cast<double>(plan.sheets.last + plan.sheets.lead));
  const auto [pixels_x, pixels_y] = metric.pixels_per_unit();
  const double ratio_x = pixels_x / scale / filter.density, ratio_y = pixels_y / scale / filter.density;
  if (!(std::min(ratio_x, ratio_y) >= std::max(1.0, isotropic(v) ? filter.from : filter.from_general)))
    return v;
  plan.raise.taps = filter.taps;
  const double x = first_sample(v, v.gx, ratio_x), y = first_sample(v, v.gy, ratio_y);
  plan.raise.x = make_raise_axis(ratio_x, filter.density, plan.raise.taps, -plan.sheets.border,
                                 v.width + 2 * plan.sheets.border, x);
  plan.raise.y = make_raise_axis(ratio_y, filter.density, plan.raise.taps, -plan.sheets.border,
                                 v.height + 2 * plan.sheets.border, y);
  plan.raise.around =
      plan.raise.taps / 2 + static_cast<int>(std::ceil(plan.sheets.border / std::min(ratio_x, ratio_y))) + 1;
  Vec3& first = v.perspective ? v.ez : v.eye;
  first = first + (x * v.ex + y * v.ey);
  v.ex = ratio_x * v.ex, v.ey = ratio_y * v.ey;
  v.gx = (1 / ratio_x) * v.gx, v.gy = (1 / ratio_y) * v.gy;
  v.width = static_cast<int>(std::ceil(v.width / ratio_x)) + 2;
  v.height = static_cast<int>(std::ceil(v.height / ratio_y)) + 2;
  return v;
}

int choose_tile_size(const SplatPlan& plan, const SplatOptions& options, const SheetView& view,
                     const Context& context) {
  if (options.tile_size > 0) return std::min(options.tile_size, most_tile_size);
  const bool gradients = options.mode == RenderMode::composite && options.shading &&
                         options.gradient == GradientMethod::analytic;
  // With its border a tile fills whole vectors.
  int size = largest_tile;
  const int floats = plan.ring.sheets * (gradients ? 4 : 1); // per pixel
  const int most = floats <= thin_ring ? most_thin_floats : most_floats;
  while (size > smallest_tile && size * size * floats > most) size -= tile_step;
  const int threads = context.tasks.threads();
  // By the limit, not by what is left: the same view has the same tiles (kept_sheets.h).
  const int least = context.memory.limit() / static_cast<uint64_t>(threads) < roomy ? small_tiles_per_thread
                                                                                    : tiles_per_thread;
  const auto tiles = [&] { return (view.width / size + 1) * (view.height / size + 1); };
  while (threads > 1 && size > smallest_tile && tiles() < least * threads) size -= tile_step;
  size -= 2 * plan.sheets.border;
  // Tiles are made alike, for narrow ones at the end would have their surroundings drawn once more for
  // little.
  const int side = std::max(view.width, view.height), count = (side + size - 1) / size;
  return (side + count - 1) / count;
}

} // namespace

PlannedTile plan_tile(const SplatPlan& plan, int x, int y, int width, int height) {
  PlannedTile t;
  t.x = x, t.y = y, t.width = width, t.height = height;
  t.ring_x = x - plan.sheets.border, t.ring_y = y - plan.sheets.border;
  t.ring_width = width + 2 * plan.sheets.border, t.ring_height = height + 2 * plan.sheets.border;
  if (plan.raise.taps == 0) return t;
  if (plan.raise.fan.taps > 0) {
    const Scales all = gap_scales(plan, plan.gaps.first, plan.gaps.last);
    const auto [x0, x1] = fan_samples(plan.raise.fan, plan.raise.fan.x, all, {x, x + width});
    const auto [y0, y1] = fan_samples(plan.raise.fan, plan.raise.fan.y, all, {y, y + height});
    t.ring_x = x0, t.ring_y = y0, t.ring_width = x1 - x0, t.ring_height = y1 - y0;
    return t;
  }
  const int right = x + width - 1 + plan.sheets.border, below = y + height - 1 + plan.sheets.border;
  t.ring_x = plan.raise.x.at(t.ring_x), t.ring_y = plan.raise.y.at(t.ring_y);
  t.ring_width = plan.raise.x.at(right) + plan.raise.taps - t.ring_x;
  t.ring_height = plan.raise.y.at(below) + plan.raise.taps - t.ring_y;
  return t;
}

namespace {

// The sheets of the picture, and how far gradients, crossings and segments look from them.
void plan_sheets(const SplatScene& scene, const SplatOptions& options, SplatPlan& plan) {
  const SheetView& view = *scene.view;
  const bool shaded = options.mode == RenderMode::composite && options.shading;
  if (shaded && options.gradient == GradientMethod::central) plan.sheets.border = plan.sheets.lead = 1;
  if (shaded && options.gradient == GradientMethod::fourth_order) plan.sheets.border = plan.sheets.lead = 2;
  if (options.mode == RenderMode::isosurface) plan.sheets.lead = 2;
  if (options.preintegrate) {
    plan.sheets.halfway = halfway_sheets(view);
    plan.sheets.lead = std::max(plan.sheets.lead, plan.sheets.halfway);
  }
  const auto [first, last] = sheet_range(*scene.slice, view);
  plan.sheets.first = first, plan.sheets.last = last;
}

// Differences of composites see too little of the ripple to need them.
std::shared_ptr<const LatticeSums> sums_of(const SplatScene& scene, const SplatOptions& options) {
  if (!options.without_ripple || !options.shading) return nullptr;
  if (options.mode != RenderMode::composite) return lattice_sums(*scene.slice, scene.sums);
  if (options.gradient != GradientMethod::analytic) return nullptr;
  return lattice_sums(*scene.slice, drawn_kernel(scene.slice->kernel.space, options.kernel_form), scene.sums);
}

// Plans what is classified alike in all tiles.
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
  const bool fan = plan.raise.fan.taps > 0; // rectangles of pixels, not of samples
  const int around = fan ? 0 : plan.raise.around;
  const auto tile = [&](int sample, const RaiseAxis& axis, int count) {
    const double pixel = std::clamp(fan ? sample : axis.offset + sample * axis.ratio, -1.0, 1e9);
    return std::clamp(static_cast<int>(std::floor(pixel / grid.size)), 0, count - 1);
  };
  const RaiseAxis &rx = plan.raise.x, &ry = plan.raise.y;
  for (uint32_t n = 0; n < plan.bricks.size(); ++n) {
    const auto& r = plan.bricks[n].rect;
    const int x0 = tile(r[0] - around, rx, grid.columns), x1 = tile(r[2] - 1 + around, rx, grid.columns);
    const int y0 = tile(r[1] - around, ry, grid.rows), y1 = tile(r[3] - 1 + around, ry, grid.rows);
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x) {
        PlannedTile& t = plan.tiles[y * grid.columns + x];
        if (meets_tile(plan, plan.bricks[n], t)) t.bricks.push_back(n);
      }
  }
}

} // namespace

SplatPlan make_plan(const SplatScene& scene, const SplatOptions& options, const Context& context,
                    DrawStats& stats, MemoryBudget* copies, bool with_points) {
  SplatPlan plan;
  const SheetView& view = *scene.view;
  plan_sheets(scene, options, plan);
  plan_classes(scene, options, plan);
  const bool empty = plan.sheets.none();
  plan.sums = sums_of(scene, options);

  SheetView sampled = view;
  SplatScene ring = scene; // as the sheets' samples see it
  ring.view = &sampled;
  if (!empty) {
    sampled = plan_samples(scene, options, plan);
    plan_gaps(ring, plan.raise.around, plan.ring, plan.gaps);
  }
  const TileGrid grid(view, choose_tile_size(plan, options, view, context));
  cut_tiles(view, grid, plan);
  stats.tiles = plan.tiles.size();
  stats.sheets = empty ? 0 : static_cast<uint64_t>(plan.sheets.last - plan.sheets.first + 1);
  if (!empty) plan_corrections(scene, plan);
  if (empty || !with_points) return plan;

  plan_bricks(scene, ring, options, context, copies, plan, stats);
  context.progress.check();
  deal_bricks(grid, plan);
  return plan;
}

} // namespace bccsplat

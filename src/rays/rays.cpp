// SPDX-License-Identifier: Apache-2.0
// Tiles of a picture by rays: all threads draw them square by square of pixels, light what their rays hit,
// and hand on the planes that tiles of sheets have.
#include "rays/rays.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "base/pool.h"
#include "draw/stage_clock.h"
#include "rays/cell_bound.h"
#include "rays/surface_cells.h"
#include "shade/view_light.h"

namespace bccsplat {
namespace {

constexpr int tile_edge = ray_tile_edge;
static_assert(tile_edge % RaySearch::square == 0);
// Sheet numbers that rays count by stay well below 2^24.
constexpr int64_t most_sheets = 1 << 23;

constexpr float nan_value = std::numeric_limits<float>::quiet_NaN();

// Returns whether the lattice has a field, and cells, all over what is drawn.
bool covers_domain(const Slice& slice) {
  const DrawnBox box = drawn_box(slice);
  for (size_t a = 0; a < 3; ++a) {
    const double end = slice.lattice.plane_distance() * slice.lattice.last[a];
    if (box.begin[a] < -domain_tolerance(end) || box.end[a] > end + domain_tolerance(end)) return false;
  }
  return !slice.empty();
}

// The pixels of a tile.
class TilePlanes {
 public:
  explicit TilePlanes(const ShotOptions& options) : value_(options.with_value), time_(options.with_time) {
    tile.pitch = tile_edge;
    tile.red = plane(0), tile.green = plane(1), tile.blue = plane(2), tile.alpha = plane(3);
    tile.depth = plane(4);
    if (value_) tile.value = plane(5);
    if (time_) tile.time = plane(6);
  }
  void begin(int x, int y, int width, int height) {
    tile.x = x, tile.y = y, tile.width = width, tile.height = height;
    std::fill_n(plane(0), 4 * pixels, 0.0f);
    std::fill_n(plane(4), pixels, std::numeric_limits<float>::infinity());
    if (value_) std::fill_n(plane(5), pixels, nan_value);
    if (time_) std::fill_n(plane(6), pixels, nan_value);
  }
  void set(size_t p, const std::array<float, 3>& color, float depth, float value, float time) {
    for (size_t c = 0; c < 3; ++c) plane(c)[p] = color[c];
    plane(3)[p] = 1, plane(4)[p] = depth;
    if (value_) plane(5)[p] = value;
    if (time_) plane(6)[p] = time;
  }

  TilePixels tile;

 private:
  static constexpr size_t pixels = size_t{tile_edge} * tile_edge;
  [[nodiscard]] float* plane(size_t n) { return floats_.data() + n * pixels; }
  bool value_, time_;
  std::array<float, 7 * pixels> floats_;
};

// What one thread draws in.
struct TileMemory {
  Reservation memory;
  RaySearch search;
  TilePlanes planes;
  TileMemory(const RayField& rays, const ShotOptions& options, const Context& context)
      : memory(context.memory, sizeof *this + RaySearch::buffers(rays.most_sheets), "a tile of rays"),
        search(rays), planes(options) {}
};

class Picture {
 public:
  Picture(const Shot& shot, const RayField& rays)
      : options_(shot.options), rays_(rays), view_(*shot.view),
        light_(lights_of(shot), to_viewer(view_, 0, 0)), time_(*shot.slice),
        value_(static_cast<float>(options_.surfaces.front().value)),
        color_(surface_color(options_.surfaces.front(), *shot.table)) {}

  void draw_tile(const RayWay& way, RaySearch& search, TilePlanes& planes, Progress& progress) const {
    const TilePixels& t = planes.tile;
    constexpr int square = RaySearch::square;
    for (int y = 0; y < t.height; y += square)
      for (int x = 0; x < t.width; x += square) {
        const int width = std::min(square, t.width - x), height = std::min(square, t.height - y);
        for (const RayHit& hit : search.find(way, t.x + x, t.y + y, width, height, progress))
          set_pixel(hit, planes);
      }
  }

 private:
  void set_pixel(const RayHit& hit, TilePlanes& planes) const {
    const TilePixels& t = planes.tile;
    Shading lit{{1, 1, 1}, {}};
    if (options_.shading)
      lit = view_.perspective ? light_.shade(hit.point.gradient, rays_.target, to_viewer(view_, hit.i, hit.j))
                              : light_.shade(hit.point.gradient, rays_.target);
    planes.set(static_cast<size_t>(hit.j - t.y) * t.pitch + (hit.i - t.x), lit_color(color_, lit),
               static_cast<float>(hit.point.k), value_, static_cast<float>(time_.at(hit.point.position)));
  }

  const ShotOptions& options_;
  const RayField& rays_;
  const SheetView& view_;
  ViewLight light_;
  TimeField time_;
  float value_;
  std::array<float, 4> color_;
};

std::shared_ptr<SurfaceCells> find_cells(const Shot& shot, KeptSurfaceCells* kept, double target,
                                         const Context& context) {
  const Slice& slice = *shot.slice;
  const uint32_t without = shot.options.disable_skips;
  if (without & skip_transfer_function) return std::make_shared<SurfaceCells>(mark_all_cells(slice, context));
  const uint64_t rays = static_cast<uint64_t>(shot.view->width) * shot.view->height;
  if (kept && !(without & skip_unchanged)) return kept->find(slice, target, context, rays);
  return std::make_shared<SurfaceCells>(cells_for_rays(slice, target, rays, context));
}

} // namespace

bool rays_cover(const Slice& slice, const SheetView& view, const ShotOptions& options) {
  if (options.mode != RenderMode::isosurface) return false;
  if (options.with_deep || options.surfaces.size() != 1 || options.surfaces.front().opacity < 1) return false;
  if (!slice.is_time_slice() || !slice.lattice.bcc || slice.lattice.any_periodic()) return false;
  if (slice.kernel.normalised || !cell_bound(slice.kernel)) return false;
  if (slice.has_holes || slice.mask || slice.corrections || !slice.clip.empty()) return false;
  if (!covers_domain(slice) || !find_ray_axes(view)) return false;
  const auto [first, last] = sheet_range(slice, view);
  return first > -most_sheets && last < most_sheets;
}

DrawStats draw_rays(const Shot& shot, const Context& context,
                    const std::function<void(const TilePixels&)>& emit, KeptSurfaceCells* kept,
                    RayCounts* counts) {
  const auto begin = std::chrono::steady_clock::now();
  const Slice& slice = *shot.slice;
  const SheetView& view = *shot.view;
  const ShotOptions& options = shot.options;
  DrawStats stats;
  stats.points_total = static_cast<uint64_t>(slice.points());
  const auto [first, last] = sheet_range(slice, view);
  stats.sheets = std::max(last - first + 1, int64_t{0});
  const double target = options.surfaces.front().value - slice.base;
  const auto cells = find_cells(shot, kept, target, context);
  const RayAxes axes = find_ray_axes(view).value();
  std::optional<CellMarker> marker;
  if (!cells->state.empty()) marker.emplace(slice, target, *cells, context);
  std::vector<RayWay> ways;
  size_t most_sheets = 0;
  for (const RayAxis& axis : axes.axes)
    most_sheets = std::max(
        most_sheets,
        ways.emplace_back(*cells, slice, view, axis, context, marker ? &*marker : nullptr).most_sheets());
  const SurfaceField field(slice, options.without_ripple && options.shading ? lattice_sums(slice, shot.sums)
                                                                            : nullptr);
  const RayField rays{&field, &view, target, most_sheets};
  const Picture picture(shot, rays);
  stats.ms_shade = ms_since(begin);

  const auto tiles = [](int pixels) { return static_cast<uint64_t>((pixels + tile_edge - 1) / tile_edge); };
  const uint64_t columns = tiles(view.width);
  stats.tiles = columns * tiles(view.height);
  std::mutex mutex; // of stats and done
  Pool<TileMemory> memories;
  uint64_t done = 0;
  context.tasks.parallel_for(stats.tiles, [&](uint64_t n) {
    context.progress.check();
    const auto start = std::chrono::steady_clock::now();
    auto memory = memories.take([&] { return std::make_unique<TileMemory>(rays, options, context); });
    const int x = static_cast<int>(n % columns) * tile_edge, y = static_cast<int>(n / columns) * tile_edge;
    memory->planes.begin(x, y, std::min(tile_edge, view.width - x), std::min(tile_edge, view.height - y));
    picture.draw_tile(ways[axes.of_tile[n]], memory->search, memory->planes, context.progress);
    emit(memory->planes.tile);
    memories.give_back(std::move(memory));
    double fraction;
    {
      const std::scoped_lock lock(mutex);
      stats.ms_shade += ms_since(start);
      fraction = static_cast<double>(++done) / static_cast<double>(stats.tiles);
    }
    context.progress.report(fraction);
  });
  for (const auto& memory : memories.idle())
    if (counts) *counts += memory->search.counts();
  return stats;
}

} // namespace bccsplat

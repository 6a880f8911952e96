// SPDX-License-Identifier: Apache-2.0
// Draws one tile of a picture: marches through its sheets, classifies each as it is completed, or looks for
// surfaces between two of them, and divides the sums at the end. What one sheet does to its pixels is in
// splat/sheet; where the sheets come from is in sheet_source.h.
#include "splat/tile/tile.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

#include "base/grid.h"
#include "shade/absorption.h"
#include "shade/surface.h"
#include "splat/sheet/sheet.h"
#include "splat/sheet/sheet_args.h"
#include "splat/tile/sheet_source.h"
#include "splat/tile/tile_holes.h"
#include "splat/tile/tile_rays.h"
#include "splat/tile/tile_surfaces.h"

namespace bccsplat {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float nan_value = std::numeric_limits<float>::quiet_NaN();

class Tile {
 public:
  Tile(const TileJob& job, const PlannedTile& tile, TileMemory& memory, DrawStats& stats)
      : scene_(*job.scene), options_(*job.options), plan_(*job.plan), job_(job), tile_(tile), m_(memory),
        stats_(stats), view_(*scene_.view),
        sheet_loops_(options_.reference_loops ? reference_sheet_loops() : simd_sheet_loops()),
        time_(*scene_.slice), field_(*scene_.slice, job.plan->sums),
        analytic_(options_.mode == RenderMode::composite && options_.shading &&
                  options_.gradient == GradientMethod::analytic),
        source_({&scene_, &plan_, job.kernel, options_.reference_loops, analytic_, kept_tile(), job.use},
                tile, memory, stats) {
    const bool shaded = options_.mode == RenderMode::composite && options_.shading;
    differences_ = shaded && !analytic_ ? plan_.sheets.border : 0;
    around_ = std::max(differences_, plan_.sheets.halfway);
    m_.prepare_pixels(tile.width, tile.height);
    open_pixels_.prepare(tile, plan_);
    prepare_pixels();
    if (options_.mode == RenderMode::isosurface)
      surfaces_.emplace(job, tile, memory, field_, source_, pixel_);
  }

  TilePixels draw() {
    if (first_ <= last_ && !plan_.sheets.none()) march_sheets();
    source_.end_sheets();
    return finish_pixels();
  }

 private:
  [[nodiscard]] KeptTile* kept_tile() const {
    if (job_.use == KeptSheets::Use::draw) return nullptr;
    return &job_.kept->tile(&tile_ - plan_.tiles.data());
  }

  void prepare_pixels() {
    float** const planes[] = {&pixel_.red,   &pixel_.green, &pixel_.blue, &pixel_.alpha,
                              &pixel_.depth, &pixel_.value, &pixel_.time};
    size_t n = 0;
    for (float** p : planes) *p = m_.pixel_plane(n++, tile_.height);
    if (!options_.with_value) pixel_.value = nullptr;
    if (!options_.with_time) pixel_.time = nullptr;
    const TileRays rays =
        make_rays(*scene_.slice, view_, tile_, m_.pixel_pitch, m_.pixel_plane(n, tile_.height), pixel_);
    open_ = rays.open;
    const size_t pixels = plane_size(m_.pixel_pitch, tile_.height);
    std::fill_n(pixel_.depth, pixels, infinity);
    if (options_.mode == RenderMode::maximum) std::fill_n(pixel_.red, pixels, -infinity);
    if (options_.with_deep)
      m_.deep.begin_tile(tile_.width, tile_.height, m_.pixel_pitch, options_.deep_tolerance,
                         options_.opacity_stop >= 1);
    if (open_ == 0) return;
    const double low = rays.low, high = rays.high;
    // Surfaces lie between two sheets, of which one may be outside the domain; segments reach half a sheet
    // beyond it.
    const bool surface = options_.mode == RenderMode::isosurface;
    first_ = static_cast<int64_t>(surface ? std::floor(low) : std::ceil(low - 0.5));
    last_ = static_cast<int64_t>(surface ? std::ceil(high) : std::floor(high + 0.5));
    first_ = std::max({first_, view_.first_sheet(), plan_.sheets.first - (surface ? 1 : plan_.sheets.lead)});
    last_ = std::min(last_, plan_.sheets.last + (surface ? 1 : plan_.sheets.lead));
  }

  void march_sheets() {
    const bool with_base = sees_base();
    // A sheet looks at so many before and behind it. Surfaces ask for slopes at the two sheets around them,
    // which takes one more on either side.
    const int around = options_.mode == RenderMode::isosurface ? 1 : around_;
    source_.begin_sheets(std::max(first_ - around, view_.first_sheet()), last_ + around);
    auto clock = StageClock::now();
    const int at_once = sheets_at_once();
    for (int64_t k = first_; k <= last_ && open_ > 0; k += at_once) {
      job_.context->progress.check();
      const int64_t end = std::min(k + at_once, last_ + 1);
      source_.complete_sheets(end - 1 + around, open_pixels(), clock);
      if (options_.mode == RenderMode::isosurface) {
        const int closed = surfaces_->draw(std::max(k, first_ + 1), end, stats_);
        closed_ += closed, open_ -= closed;
      } else {
        sheets_.clear();
        for (int64_t sheet = k; sheet < end; ++sheet)
          if (!with_base && !filled(sheet))
            ++stats_.sheets_skipped;
          else
            classify_sheet(sheet);
        composite_sheets();
      }
      add_lap(clock, stats_.ms_shade);
    }
    if (job_.use == KeptSheets::Use::keep) source_.complete_sheets(last_ + around, nullptr, clock);
  }

  // Returns whether any point reaches what the segment of a sheet is classified by.
  [[nodiscard]] bool filled(int64_t k) const {
    bool any = false;
    for (int64_t sheet = std::max(k - plan_.sheets.halfway, view_.first_sheet());
         sheet <= k + plan_.sheets.halfway; ++sheet)
      any = any || source_.filled(sheet);
    return any;
  }
  [[nodiscard]] PixelRect touched(int64_t k) const {
    PixelRect rect{};
    for (int64_t sheet = std::max(k - plan_.sheets.halfway, view_.first_sheet());
         sheet <= k + plan_.sheets.halfway; ++sheet)
      rect.include(source_.touched(sheet));
    return rect;
  }

  // Returns whether samples that no point reaches are looked at.
  [[nodiscard]] bool sees_base() const {
    return plan_.base_visible || (options_.disable_skips & skip_empty_sheets);
  }

  // Returns how many sheets are looked at together; each needs the planes of its neighbours.
  [[nodiscard]] int sheets_at_once() const {
    if (options_.mode == RenderMode::isosurface) return CrossingArgs::most;
    if (options_.mode != RenderMode::composite || options_.with_deep) return 1;
    return std::min(most_sheets_at_once, static_cast<int>(finished_sheets) - 2 * around_);
  }

  // Returns the pixels still open, brought up to date when enough have closed since; null when nothing is to
  // be left out.
  const OpenPixels* open_pixels() {
    if ((options_.disable_skips & skip_occlusion) || closed_ == 0) return nullptr;
    if (summed_closed_ == 0 || (closed_ - summed_closed_) * closed_part >= open_) {
      summed_closed_ = closed_;
      open_pixels_.count(m_.pixel_pitch, [stop = stop(), alpha = pixel_.alpha, enter = pixel_.enter,
                                          leave = pixel_.leave](size_t p) {
        return static_cast<bool>(static_cast<int>(alpha[p] < stop) & static_cast<int>(enter[p] <= leave[p]));
      });
    }
    return &open_pixels_;
  }

  [[nodiscard]] float stop() const { return static_cast<float>(options_.opacity_stop); }

  void classify_sheet(int64_t k) {
    const bool all_seen = options_.mode != RenderMode::composite || sees_base();
    SheetArgs a{.tile = {.x = tile_.x,
                         .y = tile_.y,
                         .width = tile_.width,
                         .height = tile_.height,
                         .pitch = m_.pixel_pitch,
                         .plane_pitch = source_.plane_pitch(),
                         .seen = all_seen ? all_pixels : touched(k)},
                .field = {.base = scene_.slice->base, .above_air = scene_.slice->base - scene_.slice->air},
                .analytic = {.ripple = {.sums = plan_.sums.get()}},
                .classes = {.table = scene_.table,
                            .whole = plan_.whole_sheet.empty() ? nullptr : plan_.whole_sheet.data(),
                            .stop = options_.opacity_stop < 1 ? stop() : 2.0f,
                            .depth_at = options_.depth_opacity},
                .shading = {.on = options_.shading, .lights = scene_.lights},
                .pixel = pixel_};
    set_sheet(a, *scene_.slice, view_, k, analytic_, differences_,
              [&](int64_t sheet, size_t quantity) { return source_.plane(sheet, quantity); });
    if (options_.preintegrate)
      set_halfway(a, view_, k, plan_.sheets.halfway, [&](int64_t sheet) { return source_.plane(sheet, 0); });
    if (scene_.slice->has_holes) {
      uint8_t* const hole = m_.hole_plane(sheets_.size(), tile_.height);
      const Missing missing = find_holes(*scene_.slice, view_, a, hole);
      if (missing == Missing::all) return;
      if (missing == Missing::some) a.hole = hole;
    }
    if (pixel_.time) a.time = sheet_time(time_, view_, k);
    if (options_.mode == RenderMode::xray) {
      sheet_loops_.integrate(a);
    } else if (options_.mode == RenderMode::maximum) {
      sheet_loops_.maximum(a);
    } else {
      sheets_.push_back(a);
    }
  }

  void composite_sheets() {
    if (sheets_.empty()) return;
    const int closed = sheet_loops_.composite(sheets_);
    closed_ += closed, open_ -= closed;
    if (!options_.with_deep) return;
    PixelRect seen;
    for (const SheetArgs& s : sheets_) seen.include(s.tile.seen);
    const SheetArgs& front = sheets_.front();
    m_.deep.add_segment(pixel_, front.segment.begin(), sheets_.back().segment.end(), seen);
  }

  // above_base: the value there, relative to the base.
  void paint_pixel(size_t p, const std::array<float, 4>& color, float alpha, const Vec3& gradient,
                   double above_base, double i, double j) {
    Shading lit{{1, 1, 1}, {}};
    if (options_.shading) lit = shade(*scene_.lights, gradient, to_viewer(view_, i, j), above_base);
    const std::array<float, 3> seen = lit_color(color, lit);
    pixel_.red[p] = alpha * seen[0], pixel_.green[p] = alpha * seen[1], pixel_.blue[p] = alpha * seen[2];
    pixel_.alpha[p] = alpha;
  }

  TilePixels finish_pixels() {
    auto clock = StageClock::now();
    if (options_.with_deep) m_.deep.put_fronts_back(pixel_);
    // Composites and surfaces have nothing to finish without these planes.
    const bool done = !pixel_.value && !pixel_.time &&
                      (options_.mode == RenderMode::composite || options_.mode == RenderMode::isosurface);
    for (int y = 0; y < (done ? 0 : tile_.height); ++y) {
      const std::vector<Vec3> gradients = options_.mode == RenderMode::maximum && options_.shading
                                              ? maximum_gradients(y)
                                              : std::vector<Vec3>();
      for (int x = 0; x < tile_.width; ++x) {
        const size_t p = pixel(x, y);
        if (options_.mode == RenderMode::xray)
          finish_xray(p);
        else if (options_.mode == RenderMode::maximum)
          finish_maximum(p, x, y, gradients.empty() ? Vec3{} : gradients[x]);
        else
          finish_composite(p);
      }
    }
    if (options_.with_deep) m_.deep.finish_tile(job_.context->progress);
    add_lap(clock, stats_.ms_shade);
    TilePixels done_tile =
        finished_tile(tile_, m_.pixel_pitch, pixel_, options_.with_deep ? &m_.deep : nullptr);
    if (options_.with_hits) done_tile.hits = m_.hits;
    return done_tile;
  }

  void finish_composite(size_t p) {
    const float alpha = pixel_.alpha[p];
    if (pixel_.value) pixel_.value[p] = alpha > 0 ? pixel_.value[p] / alpha : nan_value;
    if (pixel_.time) pixel_.time[p] = alpha > 0 ? pixel_.time[p] / alpha : nan_value;
  }

  void finish_xray(size_t p) {
    const bool inside = pixel_.enter[p] < pixel_.leave[p];
    const float sum = pixel_.red[p];
    pixel_.green[p] = pixel_.blue[p] = sum;
    if (pixel_.value) pixel_.value[p] = inside ? sum : nan_value;
    if (pixel_.time) pixel_.time[p] = pixel_.alpha[p] > 0 ? pixel_.time[p] / pixel_.alpha[p] : nan_value;
    pixel_.alpha[p] = inside ? 1.0f : 0.0f;
  }

  [[nodiscard]] size_t pixel(int x, int y) const { return plane_index(x, y, m_.pixel_pitch); }

  // Returns the gradients in world space where the largest values of a row's pixels are, computed together.
  [[nodiscard]] std::vector<Vec3> maximum_gradients(int y) const {
    const size_t width = tile_.width;
    std::vector<size_t> at;
    std::vector<Vec3> positions;
    for (size_t x = 0; x < width; ++x) {
      const size_t p = pixel(static_cast<int>(x), y);
      if (!(pixel_.red[p] > -infinity)) continue;
      at.push_back(x);
      positions.push_back(view_.sample(tile_.x + static_cast<int>(x), tile_.y + y, pixel_.depth[p]));
    }
    std::vector<float> values(positions.size());
    std::vector<Vec3> found(positions.size()), gradients(width);
    field_at(field_, positions, values, found);
    const Affine3 to_lattice = view_.lattice_to_world.inverse();
    for (size_t n = 0; n < at.size(); ++n)
      gradients[at[n]] = to_lattice.transposed(field_.lit_gradient(positions[n], values[n], found[n]));
    return gradients;
  }

  void finish_maximum(size_t p, int x, int y, const Vec3& gradient) {
    const float value = pixel_.red[p], k = pixel_.depth[p];
    pixel_.red[p] = 0, pixel_.depth[p] = infinity;
    if (!(value > -infinity)) {
      if (pixel_.value) pixel_.value[p] = nan_value;
      if (pixel_.time) pixel_.time[p] = nan_value;
      return;
    }
    const auto& entry = scene_.table->entry[scene_.table->index(value)];
    const float alpha = absorbed(entry[3] * scene_.table->unit_distance);
    const int i = tile_.x + x, j = tile_.y + y;
    const Vec3 position = view_.sample(i, j, k);
    paint_pixel(p, entry, alpha, gradient, value - scene_.slice->base, i, j);
    if (alpha >= options_.depth_opacity) pixel_.depth[p] = k;
    if (pixel_.value) pixel_.value[p] = value;
    if (pixel_.time) pixel_.time[p] = static_cast<float>(time_.at(position));
  }

  const SplatScene& scene_;
  const SplatOptions& options_;
  const SplatPlan& plan_;
  const TileJob& job_;
  const PlannedTile& tile_;
  TileMemory& m_;
  DrawStats& stats_;
  const SheetView& view_;
  const SheetLoops& sheet_loops_;
  TimeField time_;
  SurfaceField field_;
  bool analytic_;
  SheetSource source_;
  OpenPixels open_pixels_;
  std::optional<TileSurfaces> surfaces_; // of mode isosurface
  int differences_ = 0;                  // neighbours on either side that gradients look at
  int around_ = 0;                       // sheets on either side that gradients or segments look at
  PixelPlanes pixel_;
  std::vector<SheetArgs> sheets_; // to be composited
  int64_t first_ = 0, last_ = -1; // sheets of this tile
  int open_ = 0, closed_ = 0;     // pixels
  int summed_closed_ = 0;         // closed pixels that open_pixels_ knows of
};

} // namespace

TilePixels draw_tile(const TileJob& job, const PlannedTile& tile, TileMemory& memory, DrawStats& stats) {
  return Tile(job, tile, memory, stats).draw();
}

} // namespace bccsplat

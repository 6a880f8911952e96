#include "splat/tile.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "splat/sheet.h"
#include "splat/sheet_args.h"
#include "splat/sheet_source.h"
#include "splat/surface.h"
#include "splat/tile_rays.h"

namespace bccsplat {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float nan_value = std::numeric_limits<float>::quiet_NaN();

class Tile {
 public:
  Tile(const TileJob& job, const PlannedTile& tile, TileMemory& memory, SplatStats& stats)
      : scene_(*job.scene), options_(*job.options), plan_(*job.plan), job_(job), tile_(tile), m_(memory),
        stats_(stats), view_(*scene_.view),
        sheet_kernels_(options_.scalar ? scalar_sheet_kernels() : simd_sheet_kernels()), time_(*scene_.slice),
        analytic_(options_.mode == RenderMode::composite && options_.shading &&
                  options_.gradient == GradientMethod::analytic),
        source_({&scene_, &plan_, job.kernel, options_.scalar, analytic_}, tile, memory, stats) {
    const bool shaded = options_.mode == RenderMode::composite && options_.shading;
    differences_ = shaded && !analytic_ ? plan_.lead : 0;
    m_.prepare_pixels(tile.width, tile.height);
    open_pixels_.prepare(tile.x, tile.y, tile.width, tile.height, plan_.border);
    prepare_pixels();
  }

  TilePixels draw() {
    if (first_ <= last_) march();
    return finish();
  }

 private:
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
    const size_t pixels = static_cast<size_t>(m_.pixel_pitch) * static_cast<size_t>(tile_.height);
    std::fill_n(pixel_.depth, pixels, infinity);
    if (options_.mode == RenderMode::maximum) std::fill_n(pixel_.red, pixels, -infinity);
    if (open_ == 0) return;
    const double low = rays.low, high = rays.high;
    // Surfaces lie between two sheets, of which one may stand outside the domain; slabs reach half a sheet
    // beyond it.
    const bool surface = options_.mode == RenderMode::isosurface;
    first_ = static_cast<int64_t>(surface ? std::floor(low) : std::ceil(low - 0.5));
    last_ = static_cast<int64_t>(surface ? std::ceil(high) : std::floor(high + 0.5));
    first_ = std::max({first_, view_.first_sheet(), plan_.first_sheet - plan_.lead});
    last_ = std::min(last_, plan_.last_sheet + plan_.lead);
  }

  void march() {
    const int64_t from = std::max(first_ - differences_, view_.first_sheet());
    const bool keep_empty = sees_air();
    // Differences look at the sheets behind; surfaces at the next.
    const int ahead = options_.mode == RenderMode::isosurface ? 1 : differences_;
    source_.begin(from, last_ + ahead);
    auto clock = StageClock::now();
    const int at_once = sheets_at_once();
    for (int64_t k = first_; k <= last_ && open_ > 0; k += at_once) {
      if (((k - first_) & 15) < at_once) job_.context->progress.check();
      const int64_t end = std::min(k + at_once, last_ + 1);
      source_.complete(end - 1 + ahead, open_pixels(), clock);
      sheets_.clear();
      for (int64_t sheet = k; sheet < end; ++sheet)
        if (!keep_empty && options_.mode != RenderMode::isosurface && !source_.filled(sheet))
          ++stats_.sheets_skipped;
        else
          process(sheet);
      composite();
      lap(clock, stats_.ms_shade);
    }
  }

  // Whether samples that no point reaches are looked at.
  [[nodiscard]] bool sees_air() const {
    return plan_.air_visible || (options_.disable_skips & skip_empty_sheets);
  }

  // Sheets that are composited together: each needs the planes of those it looks at.
  [[nodiscard]] int sheets_at_once() const {
    if (options_.mode != RenderMode::composite || scene_.slice->has_holes) return 1;
    return std::min(4, SheetSource::kept_sheets - 2 * differences_);
  }

  // The pixels still open, brought up to date when enough have closed since; null: do not look.
  const OpenPixels* open_pixels() {
    if ((options_.disable_skips & skip_occlusion) || closed_ == 0) return nullptr;
    if (summed_closed_ == 0 || (closed_ - summed_closed_) * 16 >= open_) {
      summed_closed_ = closed_;
      open_pixels_.count(m_.pixel_pitch, [stop = stop(), alpha = pixel_.alpha, enter = pixel_.enter,
                                          leave = pixel_.leave](size_t p) {
        return static_cast<bool>(static_cast<int>(alpha[p] < stop) & static_cast<int>(enter[p] <= leave[p]));
      });
    }
    return &open_pixels_;
  }

  [[nodiscard]] float stop() const { return static_cast<float>(options_.opacity_stop); }

  void process(int64_t k) {
    if (options_.mode == RenderMode::isosurface) {
      find_surface(k);
      return;
    }
    SheetArgs a;
    a.x = tile_.x, a.y = tile_.y, a.width = tile_.width, a.height = tile_.height, a.pitch = m_.pixel_pitch;
    a.plane_pitch = source_.plane_pitch();
    a.shading = options_.shading;
    if (!sees_air()) a.seen = source_.touched(k);
    a.air = scene_.slice->air;
    a.stop = options_.opacity_stop < 1 ? stop() : 2.0f;
    a.table = scene_.table, a.lights = scene_.lights;
    a.pixel = pixel_;
    a.whole = plan_.whole_sheet.empty() ? nullptr : plan_.whole_sheet.data();
    set_sheet(a, view_, k, analytic_, differences_, scene_.slice->kernel.space.radius,
              [&](int64_t sheet, size_t quantity) { return source_.plane(sheet, quantity); });
    if (scene_.slice->has_holes) {
      find_holes(*scene_.slice, view_, tile_, k, pixel_, m_.pixel_pitch, m_.hole.data());
      a.hole = m_.hole.data();
    }
    if (pixel_.time) a.time = sheet_time(time_, view_, k);
    if (options_.mode == RenderMode::xray) {
      sheet_kernels_.integrate(a);
    } else if (options_.mode == RenderMode::maximum) {
      sheet_kernels_.maximum(a);
    } else {
      sheets_.push_back(a);
    }
  }

  void composite() {
    if (sheets_.empty()) return;
    const int closed = sheet_kernels_.composite(sheets_);
    closed_ += closed, open_ -= closed;
  }

  // Whether a sample is on air's side of the surface only because points beyond it are left out.
  [[nodiscard]] bool lacks_points(int64_t k, int x, int y, float value, float target) const {
    return !plan_.inside.cells.empty() && (value < target) == (target > 0) &&
           plan_.inside.contains(view_.sample(tile_.x + x, tile_.y + y, static_cast<double>(k)));
  }

  // Surfaces between the sheets k - 1 and k.
  void find_surface(int64_t k) {
    if (k - 1 < first_) return;
    const float target = static_cast<float>(options_.iso_value - static_cast<double>(scene_.slice->air));
    const bool filled = source_.filled(k) || source_.filled(k - 1);
    if (!filled && !(options_.disable_skips & skip_empty_sheets)) {
      ++stats_.sheets_skipped;
      return;
    }
    CrossingArgs c;
    c.k = static_cast<float>(k), c.target = target;
    c.width = tile_.width, c.height = tile_.height, c.pitch = m_.pixel_pitch;
    c.before = source_.plane(k - 1, 0), c.value = source_.plane(k, 0), c.plane_pitch = source_.plane_pitch();
    c.alpha = pixel_.alpha, c.enter = pixel_.enter, c.leave = pixel_.leave;
    c.before2 = source_.plane(std::max(k - 2, first_), 0), c.after = source_.plane(k + 1, 0);
    if (!(options_.disable_skips & skip_empty_sheets)) {
      c.seen = {};
      for (int64_t sheet = std::max(k - 2, first_); sheet <= k + 1; ++sheet)
        c.seen.include(source_.touched(sheet));
    }
    m_.crossings.resize(static_cast<size_t>(tile_.width * tile_.height));
    c.found = m_.crossings.data();
    const size_t found = sheet_kernels_.crossings(c);
    if (found == 0) return;
    std::vector<Crossing> crossings, grazes;
    crossings.reserve(found);
    for (size_t n = 0; n < found; ++n) {
      const int x = static_cast<int>(c.found[n] & 0xffff), y = static_cast<int>(c.found[n] >> 16 & 0x7fff);
      const std::ptrdiff_t at = y * source_.plane_pitch() + x;
      if (lacks_points(k - 1, x, y, c.before[at], target) || lacks_points(k, x, y, c.value[at], target))
        continue;
      (c.found[n] & grazing ? grazes : crossings)
          .push_back({tile_.x + x, tile_.y + y, static_cast<double>(k - 1), static_cast<double>(k),
                      static_cast<double>(c.before[at]), static_cast<double>(c.value[at])});
    }
    for (const Crossing& g : find_grazes(*scene_.slice, view_, options_.iso_value, grazes))
      crossings.push_back(g);
    const auto hits = refine_crossings(*scene_.slice, view_, options_.iso_value, crossings);
    const auto& color =
        scene_.table->entry[static_cast<size_t>(scene_.table->index(static_cast<float>(options_.iso_value)))];
    for (size_t n = 0; n < hits.size(); ++n) {
      const auto p = static_cast<size_t>(crossings[n].j - tile_.y) * static_cast<size_t>(m_.pixel_pitch) +
                     static_cast<size_t>(crossings[n].i - tile_.x);
      const double tolerance = 1e-5;
      if (hits[n].k < static_cast<double>(pixel_.enter[p]) - tolerance ||
          hits[n].k > static_cast<double>(pixel_.leave[p]) + tolerance)
        continue;
      if (scene_.slice->has_holes && scene_.slice->is_hole(hits[n].position)) continue;
      paint(p, color, 1.0f, hits[n].gradient, crossings[n].i, crossings[n].j);
      pixel_.depth[p] = static_cast<float>(hits[n].k);
      if (pixel_.value) pixel_.value[p] = static_cast<float>(options_.iso_value);
      if (pixel_.time) pixel_.time[p] = static_cast<float>(time_.at(hits[n].position));
      ++closed_, --open_;
    }
  }

  void paint(size_t p, const std::array<float, 4>& color, float alpha, const Vec3& gradient, int i, int j) {
    Shading lit{{1, 1, 1}, {}};
    if (options_.shading) lit = shade(*scene_.lights, gradient, to_viewer(view_, i, j));
    float* const out[3] = {&pixel_.red[p], &pixel_.green[p], &pixel_.blue[p]};
    for (size_t c = 0; c < 3; ++c)
      *out[c] = alpha * (color[c] * static_cast<float>(lit.scale[c]) + static_cast<float>(lit.highlight[c]));
    pixel_.alpha[p] = alpha;
  }

  TilePixels finish() {
    auto clock = StageClock::now();
    for (int y = 0; y < tile_.height; ++y)
      for (int x = 0; x < tile_.width; ++x) {
        const auto p = static_cast<size_t>(y) * static_cast<size_t>(m_.pixel_pitch) + static_cast<size_t>(x);
        if (options_.mode == RenderMode::xray)
          finish_xray(p);
        else if (options_.mode == RenderMode::maximum)
          finish_maximum(p, x, y);
        else if (options_.mode == RenderMode::composite)
          finish_composite(p);
        if (options_.mode == RenderMode::isosurface && !(pixel_.alpha[p] > 0)) {
          if (pixel_.value) pixel_.value[p] = nan_value;
          if (pixel_.time) pixel_.time[p] = nan_value;
        }
      }
    lap(clock, stats_.ms_shade);
    return {tile_.x,      tile_.y,     tile_.width,  tile_.height, m_.pixel_pitch, pixel_.red,
            pixel_.green, pixel_.blue, pixel_.alpha, pixel_.depth, pixel_.value,   pixel_.time};
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

  void finish_maximum(size_t p, int x, int y) {
    const float value = pixel_.red[p], k = pixel_.depth[p];
    pixel_.red[p] = 0, pixel_.depth[p] = infinity;
    if (!(value > -infinity)) {
      if (pixel_.value) pixel_.value[p] = nan_value;
      if (pixel_.time) pixel_.time[p] = nan_value;
      return;
    }
    const auto& entry = scene_.table->entry[static_cast<size_t>(scene_.table->index(value))];
    const float alpha = absorbed(entry[3] * scene_.table->unit_distance);
    const int i = tile_.x + x, j = tile_.y + y;
    const Vec3 position = view_.sample(i, j, static_cast<double>(k));
    Vec3 gradient{};
    if (options_.shading) {
      float unused;
      field_at(*scene_.slice, {&position, 1}, {&unused, 1}, {&gradient, 1});
      gradient = view_.lattice_to_world.inverse().transposed(gradient);
    }
    paint(p, entry, alpha, gradient, i, j);
    if (alpha >= 0.5f) pixel_.depth[p] = k;
    if (pixel_.value) pixel_.value[p] = value;
    if (pixel_.time) pixel_.time[p] = static_cast<float>(time_.at(position));
  }

  const SplatScene& scene_;
  const SplatOptions& options_;
  const SplatPlan& plan_;
  const TileJob& job_;
  const PlannedTile& tile_;
  TileMemory& m_;
  SplatStats& stats_;
  const SheetView& view_;
  const SheetKernels& sheet_kernels_;
  TimeField time_;
  bool analytic_;
  SheetSource source_;
  OpenPixels open_pixels_;
  int differences_ = 0; // neighbours on either side that gradients look at
  PixelPlanes pixel_;
  std::vector<SheetArgs> sheets_; // to be composited
  int64_t first_ = 0, last_ = -1; // sheets of this tile
  int open_ = 0, closed_ = 0;     // pixels
  int summed_closed_ = 0;         // closed pixels that open_sum knows of
};

} // namespace

TilePixels draw_tile(const TileJob& job, const PlannedTile& tile, TileMemory& memory, SplatStats& stats) {
  return Tile(job, tile, memory, stats).draw();
}

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Draws one tile of a picture: marches through its sheets and divides the sums at the end. Of one object that
// is drawn alone each sheet is classified and composited as it is completed, or surfaces are looked for
// between two of them. Else what all stills absorb on a sheet, each made of one object or a weighted sum of
// several, is gathered in groups (tile_matter.h). What one sheet does to its pixels is in splat/sheet; where
// the sheets come from is in sheet_source.h.
#include "splat/tile/tile.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "splat/sheet/sheet_args.h"
#include "splat/tile/drawn_sheets.h"
#include "splat/tile/sheet_painter.h"
#include "splat/tile/tile_finish.h"
#include "splat/tile/tile_holes.h"
#include "splat/tile/tile_matter.h"
#include "splat/tile/tile_rays.h"
#include "splat/tile/tile_surfaces.h"

namespace bccsplat {
namespace {

constexpr float never = std::numeric_limits<float>::infinity();

// What is classified: a still, or the field of the object that is drawn alone.
struct Drawn {
  SplatStill still;
  TimeField time;
  DrawnSheets sheets;
};

class Tile {
 public:
  Tile(const TileJob& job, size_t n, const TilePixels* front, TileMemory& memory, DrawStats& stats)
      : job_(job), options_(*job.options), n_(n), tile_(job.objects.front().plan.tiles[n]), m_(memory),
        stats_(stats), view_(*job.main->view),
        alone_(job.alone()), front_{front, front && job.combine == TrailCombine::interleaved},
        surface_(options_.mode == RenderMode::isosurface) {
    const SplatPlan& plan = job.objects.front().plan;
    const bool shaded = options_.mode == RenderMode::composite && options_.shading;
    analytic_ = shaded && options_.gradient == GradientMethod::analytic;
    differences_ = shaded && !analytic_ ? plan.sheets.border : 0;
    halfway_ = plan.sheets.halfway;
    for (const TileObject& o : job.objects) halfway_ = std::min(halfway_, o.plan.sheets.halfway);
    // A sheet looks at so many before and behind it. Surfaces ask for slopes at the two sheets around them,
    // which takes one more on either side.
    around_ = surface_ ? 1 : std::max(differences_, halfway_);
    list_sources();
    list_rings();
    prepare_pixels();
    prepare_rays();
    list_drawn();
    if (!alone_) matter_.emplace(job, tile_, memory, pixel_);
    if (surface_ || options_.mode == RenderMode::maximum)
      field_.emplace(*job.main->slice, job.objects.front().plan.sums);
    if (surface_) surfaces_.emplace(job, tile_, memory, *field_, sources_.front(), pixel_);
  }

  TilePixels draw() {
    if (first_ <= last_ && !(alone_ && job_.objects.front().plan.sheets.none())) march_sheets();
    for (SheetSource& s : sources_) s.end_sheets();
    auto clock = StageClock::now();
    finish_pixels();
    add_lap(clock, stats_.ms_shade);
    TilePixels done = finished_tile(tile_, m_.pixel_pitch, pixel_, options_.with_deep ? &m_.deep : nullptr);
    if (options_.with_hits) done.hits = m_.hits;
    return done;
  }

 private:
  void list_sources() {
    m_.sheets.resize(std::max(m_.sheets.size(), job_.objects.size()));
    sources_.reserve(job_.objects.size());
    KeptTile* const kept = job_.use == KeptSheets::Use::draw ? nullptr : &job_.kept->tile(n_);
    for (size_t i = 0; i < job_.objects.size(); ++i) {
      const TileObject& o = job_.objects[i];
      sources_.emplace_back(
          SheetSourceArgs{o.scene, &o.plan, &o.kernel, options_.reference_loops, analytic_, kept, job_.use},
          o.plan.tiles[n_], m_.sheets[i], stats_);
    }
    drawn_sources_ = {.object = sources_,
                      .loops = options_.reference_loops ? &reference_matter_loops() : &simd_matter_loops(),
                      .first_sheet = view_.first_sheet(),
                      .height = tile_.height,
                      .border = job_.objects.front().plan.sheets.border,
                      .plane_pitch = sources_.front().plane_pitch(),
                      .halfway = halfway_,
                      .gradients = analytic_};
  }

  // Open pixels are counted by the samples of a ring: once for all objects whose rings are alike.
  void list_rings() {
    for (const TileObject& o : job_.objects) {
      OpenPixels own;
      own.prepare(o.plan.tiles[n_], o.plan);
      const auto like = std::find_if(open_pixels_.begin(), open_pixels_.end(),
                                     [&](const OpenPixels& other) { return own.counts_like(other); });
      ring_of_.push_back(like - open_pixels_.begin());
      if (like == open_pixels_.end()) open_pixels_.push_back(std::move(own));
    }
  }

  void prepare_pixels() {
    m_.prepare_pixels(tile_, alone_ ? most_sheets_at_once : 1);
    pixels_ = plane_size(m_.pixel_pitch, tile_.height);
    float** const planes[] = {&pixel_.red,   &pixel_.green, &pixel_.blue, &pixel_.alpha,
                              &pixel_.depth, &pixel_.value, &pixel_.time};
    static_assert(std::size(planes) == TileMemory::pixel_planes);
    float* next = m_.pixels.data();
    for (float** p : planes) *p = std::exchange(next, next + pixels_);
    if (!options_.with_value) pixel_.value = nullptr;
    if (!options_.with_time) pixel_.time = nullptr;
    std::fill_n(pixel_.depth, pixels_, never);
    if (options_.mode == RenderMode::maximum) std::fill_n(pixel_.red, pixels_, -never);
    size_t painted = 0;
    for (const TileObject& o : job_.objects)
      if (!alone_) painted = std::max(painted, paint_planes(*o.scene));
    reserve_numbers(m_.paint, painted * pixels_);
    if (options_.with_deep)
      m_.deep.begin_tile(tile_.width, tile_.height, m_.pixel_pitch, options_.deep_tolerance,
                         options_.opacity_stop >= 1);
  }

  // Makes room for floats that are numbers, as what is read beside a tile must be.
  static void reserve_numbers(AlignedArray<float>& floats, size_t count) {
    if (floats.capacity() >= count) return;
    floats.reserve(count);
    std::fill_n(floats.data(), floats.capacity(), 0.0f);
  }

  // Makes the rays of the picture (set 0) and of the objects that have a domain of their own. The picture's
  // then run where any object is; a surface ends all rays.
  void prepare_rays() {
    m_.rays.reserve(ray_planes * pixels_ * (alone_ ? 1 : job_.objects.size() + 1));
    const TileRays main = make_rays(*job_.main->slice, view_, tile_, m_.pixel_pitch, ray_plane(0, 0), pixel_);
    double low = main.low, high = main.high;
    rays_.assign(job_.objects.size(), pixel_);
    float *const enter = ray_plane(0, 0), *const leave = ray_plane(0, 1);
    for (size_t i = 0; i < job_.objects.size(); ++i) {
      const TileObject& o = job_.objects[i];
      if (!own_rays(o)) continue;
      const float *const own_enter = ray_plane(i + 1, 0), *const own_leave = ray_plane(i + 1, 1);
      const TileRays r =
          make_rays(*o.scene->slice, *o.scene->view, tile_, m_.pixel_pitch, ray_plane(i + 1, 0), rays_[i]);
      if (r.open == 0) continue;
      low = low <= high ? std::min(low, r.low) : r.low, high = std::max(high, r.high);
      for (size_t p = 0; p < pixels_; ++p)
        enter[p] = std::min(enter[p], own_enter[p]), leave[p] = std::max(leave[p], own_leave[p]);
    }
    if (front_.ends_rays()) {
      end_at_front(leave);
      for (size_t i = 0; i < job_.objects.size(); ++i)
        if (own_rays(job_.objects[i])) end_at_front(ray_plane(i + 1, 1));
    }
    open_ = main.open;
    if (!alone_) open_ = count_rays(enter, leave);
    if (open_ > 0 && low <= high) set_sheets(low, high);
  }

  [[nodiscard]] bool own_rays(const TileObject& object) const { return !alone_ && object.own_rays; }

  [[nodiscard]] int count_rays(const float* enter, const float* leave) const {
    int count = 0;
    for (size_t p = 0; p < pixels_; ++p) count += enter[p] < leave[p] ? 1 : 0;
    return count;
  }

  // Plane `n` of a set of rays: 0 where they enter, 1 where they leave.
  [[nodiscard]] float* ray_plane(size_t set, size_t n) const {
    return m_.rays.data() + (set * ray_planes + n) * pixels_;
  }

  void end_at_front(float* leaves) const {
    for (int y = 0; y < tile_.height; ++y)
      for (int x = 0; x < tile_.width; ++x) {
        float& at = leaves[plane_index(x, y, m_.pixel_pitch)];
        at = std::min(at, front_.at(x, y));
      }
  }

  // Sets the sheets to be drawn: those that rays are in, from `low` to `high`, and some object was planned
  // for. Surfaces lie between two sheets, of which one may be outside the domain; segments reach half a sheet
  // beyond it.
  void set_sheets(double low, double high) {
    int64_t first = INT64_MAX, last = INT64_MIN;
    for (const TileObject& o : job_.objects) {
      const int lead = surface_ ? 1 : o.plan.sheets.lead;
      first = std::min(first, o.plan.sheets.first - lead), last = std::max(last, o.plan.sheets.last + lead);
    }
    first_ = static_cast<int64_t>(surface_ ? std::floor(low) : std::ceil(low - 0.5));
    last_ = static_cast<int64_t>(surface_ ? std::ceil(high) : std::floor(high + 0.5));
    first_ = std::max({first_, view_.first_sheet(), first}), last_ = std::min(last_, last);
  }

  void list_drawn() {
    const SplatScene& own = *job_.objects.front().scene;
    std::span<const SplatStill> stills = job_.stills;
    const SplatStill field{std::span(&whole_, 1), own.table, 1, own.slice->frame, {}, true, 0};
    if (alone_) stills = std::span(&field, 1);
    const auto mixed =
        std::count_if(stills.begin(), stills.end(), [](const SplatStill& s) { return s.shares.size() > 1; });
    const size_t floats = drawn_sources_.mixed_floats();
    reserve_numbers(m_.mixed, mixed * floats);
    float* next = m_.mixed.data();
    const bool all_seen = (options_.disable_skips & skip_empty_sheets) != 0;
    drawn_.reserve(stills.size());
    for (const SplatStill& s : stills) {
      const SplatScene& of = *job_.objects[s.shares.front().source].scene;
      const bool base_seen = all_seen || (alone_ ? job_.objects.front().plan.base_visible
                                                 : s.table->visible(of.slice->base, of.slice->base));
      const bool mixes = s.shares.size() > 1;
      drawn_.push_back({s, TimeField(*of.slice),
                        DrawnSheets(drawn_sources_, s.shares, *s.table, of.slice->base, base_seen, next)});
      if (mixes) drawn_.back().time.offset = s.frame, drawn_.back().time.gradient = {}, next += floats;
    }
  }

  void march_sheets() {
    for (SheetSource& s : sources_)
      s.begin_sheets(std::max(first_ - around_, view_.first_sheet()), last_ + around_);
    next_mixed_ = first_ - around_;
    auto clock = StageClock::now();
    int64_t end = 0;
    for (int64_t k = first_; k <= last_ && open_ > 0; k = end) {
      job_.context->progress.check();
      end = std::min(end_of_batch(k), last_ + 1);
      const bool hides = count_open(k);
      if (alone_) {
        complete(0, end - 1 + around_, hides, clock);
        draw_alone(k, end);
      } else {
        draw_side_by_side(k, end, hides, clock);
      }
      add_lap(clock, stats_.ms_shade);
    }
    if (job_.use == KeptSheets::Use::keep) sources_.front().complete_sheets(last_ + around_, nullptr, clock);
  }

  // Returns the end of the sheets that are looked at together from k on; each needs the planes of its
  // neighbours. How segments of stills are lit depends on what is open where those together begin: in all
  // tiles the same.
  [[nodiscard]] int64_t end_of_batch(int64_t k) const {
    if (!alone_) return (k | (most_sheets_at_once - 1)) + 1;
    if (surface_) return k + CrossingArgs::most;
    if (options_.mode != RenderMode::composite || options_.with_deep) return k + 1;
    return k + std::min(most_sheets_at_once, static_cast<int>(finished_sheets) - 2 * around_);
  }

  void complete(size_t object, int64_t through, bool hides, StageClock::time_point& clock) {
    if (!alone_) {
      if (job_.objects[object].plan.tiles[n_].empty()) return;
      job_.context->progress.check();
    }
    sources_[object].complete_sheets(through, hides ? &open_pixels_[ring_of_[object]] : nullptr, clock);
  }

  // Counts the pixels still open anew when enough have closed since or have come to the surface in front;
  // returns whether anything is to be left out.
  bool count_open(int64_t k) {
    if ((options_.disable_skips & skip_occlusion) || (closed_ == 0 && !front_.ends_rays())) return false;
    if (!front_.pixels && summed_closed_ > 0 && (closed_ - summed_closed_) * closed_part < open_) return true;
    summed_closed_ = closed_;
    // Rays of one object that miss its domain leave it nowhere.
    const float begin = alone_ ? -never : static_cast<float>(k) - 0.5f;
    const auto stop = static_cast<float>(options_.opacity_stop);
    for (OpenPixels& ring : open_pixels_)
      ring.count(m_.pixel_pitch, [stop, begin, alpha = pixel_.alpha, leave = pixel_.leave](size_t p) {
        return static_cast<bool>(static_cast<int>(alpha[p] < stop) & static_cast<int>(begin < leave[p]));
      });
    return true;
  }

  void close(int pixels) { closed_ += pixels, open_ -= pixels; }

  // Draws sheets k .. end - 1 of one object straight onto the pixels.
  void draw_alone(int64_t k, int64_t end) {
    if (surfaces_) return close(surfaces_->draw(std::max(k, first_ + 1), end, stats_));
    const SheetLoops& loops = options_.reference_loops ? reference_sheet_loops() : simd_sheet_loops();
    const Drawn& field = drawn_.front();
    batch_.clear();
    for (int64_t sheet = k; sheet < end; ++sheet) {
      if (!field.sheets.seen(sheet)) {
        ++stats_.sheets_skipped;
        continue;
      }
      SheetArgs& a = batch_.emplace_back();
      if (!describe(field, sheet, m_.hole.data() + (batch_.size() - 1) * pixels_, a)) batch_.pop_back();
    }
    if (batch_.empty()) return;
    if (options_.mode == RenderMode::xray) return loops.integrate(batch_.front());
    if (options_.mode == RenderMode::maximum) return loops.maximum(batch_.front());
    close(loops.composite(batch_));
    if (!options_.with_deep) return;
    PixelRect seen;
    for (const SheetArgs& s : batch_) seen.include(s.tile.seen);
    m_.deep.add_segment(pixel_, batch_.front().segment.begin(), batch_.back().segment.end(), seen);
  }

  // Draws sheets k .. end - 1 of all stills, of which each sheet is joined when all have absorbed.
  void draw_side_by_side(int64_t k, int64_t end, bool hides, StageClock::time_point& clock) {
    const int64_t through = end - 1 + around_;
    matter_->clear();
    for (Drawn& d : drawn_) {
      for (const SheetShare& s : d.still.shares) complete(s.source, through, hides, clock);
      if (d.still.paint) complete(*d.still.paint, through, hides, clock);
      d.sheets.mix(next_mixed_, through);
      for (int64_t sheet = k; sheet < end; ++sheet) absorb(d, sheet, sheet - k);
      add_lap(clock, stats_.ms_shade);
    }
    next_mixed_ = through + 1;
    for (int64_t sheet = k; front_.through && sheet < end; ++sheet)
      matter_->add_front(front_, sheet, sheet - k);
    for (int64_t sheet = k; sheet < end; ++sheet) {
      const size_t n = sheet - k;
      if (!matter_->any(n)) continue;
      close(matter_->join(sheet, n, stop()));
      const float begin = static_cast<float>(sheet) - (sheet == view_.first_sheet() ? 2 : 0.5f);
      if (options_.with_deep)
        m_.deep.add_segment(pixel_, begin, static_cast<float>(sheet) + 0.5f, all_pixels);
    }
  }

  // Adds what `d` absorbs on sheet k, which is number n of those under way.
  void absorb(Drawn& d, int64_t k, size_t n) {
    if (!d.sheets.seen(k)) {
      ++stats_.sheets_skipped;
      return;
    }
    const MatterPlanes& matter = matter_->of(n, d.still.group);
    if (d.still.lit) d.sheets.mix_gradients(k);
    SheetArgs a;
    if (describe(d, k, m_.hole.data(), a)) drawn_sources_.loops->absorb(a, d.still.weight, matter);
  }

  // Describes sheet k to the loops; returns false where all of it is missing. hole: room for a plane.
  bool describe(const Drawn& d, int64_t k, uint8_t* hole, SheetArgs& a) {
    const size_t object = d.sheets.object();
    const TileObject& of = job_.objects[object];
    const SplatScene& scene = *of.scene;
    const auto& whole = of.plan.whole_sheet;
    const bool all_seen = options_.mode != RenderMode::composite || d.sheets.sees_base();
    a.tile = {.x = tile_.x,
              .y = tile_.y,
              .width = tile_.width,
              .height = tile_.height,
              .pitch = m_.pixel_pitch,
              .plane_pitch = drawn_sources_.plane_pitch,
              .seen = all_seen ? all_pixels : d.sheets.touched(k)};
    a.field = {.base = scene.slice->base, .above_air = scene.slice->base - scene.slice->air};
    a.analytic = {.ripple = {.sums = of.plan.sums.get()}};
    a.classes = {.table = d.still.table,
                 .whole = alone_ && !whole.empty() ? whole.data() : nullptr,
                 .stop = stop(),
                 .depth_at = options_.depth_opacity};
    a.shading = {.on = options_.shading && d.still.lit, .lights = scene.lights};
    a.pixel = rays_[object];
    set_sheet(a, *scene.slice, *scene.view, k, analytic_, differences_,
              [&](int64_t sheet, size_t quantity) { return d.sheets.plane(sheet, quantity); });
    if (!d.still.table->integrals.empty())
      set_halfway(a, *scene.view, k, halfway_, [&](int64_t sheet) { return d.sheets.plane(sheet, 0); });
    if (scene.slice->has_holes) {
      const Missing missing = find_holes(*scene.slice, *scene.view, a, hole);
      if (missing == Missing::all) return false;
      if (missing == Missing::some) a.hole = hole;
    }
    if (pixel_.time) a.time = sheet_time(d.time, *scene.view, k);
    if (!alone_) paint(d, scene, k, a);
    return true;
  }

  // Sets what the pixels of a sheet have from elsewhere.
  void paint(const Drawn& d, const SplatScene& scene, int64_t k, SheetArgs& a) {
    if (!d.still.paint && !scene.light && !scene.slice->labels) return;
    const SheetPainter painter(a, k, m_.paint, pixels_);
    if (scene.slice->labels) painter.labels(scene);
    if (const auto by = d.still.paint) painter.color(*job_.objects[*by].scene, sources_[*by].plane(k, 0));
    if (scene.light && options_.shading) painter.light(scene);
  }

  // The opacity at which a pixel is finished; 2: never.
  [[nodiscard]] float stop() const {
    return options_.opacity_stop < 1 ? static_cast<float>(options_.opacity_stop) : 2.0f;
  }

  void finish_pixels() {
    const FinishedPixels all{*job_.main, options_, tile_, m_.pixel_pitch, pixel_};
    if (front_.ends_rays()) add_behind(all, front_, stop(), options_.with_deep ? &m_.deep : nullptr);
    if (options_.with_deep) m_.deep.put_fronts_back(pixel_);
    if (options_.mode == RenderMode::xray)
      finish_xray(all);
    else if (options_.mode == RenderMode::maximum)
      finish_maximum(all, *field_);
    else
      finish_means(all);
    if (options_.with_deep) m_.deep.finish_tile(job_.context->progress);
  }

  const TileJob& job_;
  const SplatOptions& options_;
  size_t n_;
  const PlannedTile& tile_;
  TileMemory& m_;
  DrawStats& stats_;
  const SheetView& view_;
  bool alone_;
  TileFront front_;
  bool surface_;
  bool analytic_ = false;
  int differences_ = 0, halfway_ = 0; // neighbours on either side that gradients, and segments, look at
  int around_ = 0;                    // sheets on either side that are looked at
  std::vector<SheetSource> sources_;  // per object
  DrawnSources drawn_sources_;
  std::vector<OpenPixels> open_pixels_; // per ring
  std::vector<size_t> ring_of_;         // per object
  PixelPlanes pixel_;
  size_t pixels_ = 0;             // floats of a plane
  std::vector<PixelPlanes> rays_; // per object
  SheetShare whole_{0, 1};        // of the object that is drawn alone
  std::vector<Drawn> drawn_;
  std::optional<TileMatter> matter_;     // of stills
  std::optional<SurfaceField> field_;    // of modes isosurface and maximum
  std::optional<TileSurfaces> surfaces_; // of mode isosurface
  std::vector<SheetArgs> batch_;         // to be composited
  int64_t first_ = 0, last_ = -1, next_mixed_ = 0;
  int open_ = 0, closed_ = 0; // pixels
  int summed_closed_ = 0;     // closed pixels that open_pixels_ knows of
};

} // namespace

TilePixels draw_tile(const TileJob& job, size_t n, const TilePixels* front, TileMemory& memory,
                     DrawStats& stats) {
  return Tile(job, n, front, memory, stats).draw();
}

} // namespace bccsplat

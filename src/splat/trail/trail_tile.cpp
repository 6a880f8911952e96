// SPDX-License-Identifier: Apache-2.0
// Draws one tile of a picture with a trail. Each object (the slice, and each source of the trail) has sheets
// of its own; a still is one object or a weighted sum of several, and what all of them absorb on a sheet is
// gathered in two groups, the slice's and the trail's, and composited by the rule of TrailCombine.
#include "splat/trail/trail_tile.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "base/grid.h"
#include "splat/sheet/sheet_args.h"
#include "splat/tile/tile_holes.h"
#include "splat/tile/tile_rays.h"
#include "splat/trail/sheet_painter.h"
#include "splat/trail/trail_sheets.h"

namespace bccsplat {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float nan_value = std::numeric_limits<float>::quiet_NaN();

// The slice or a still of the trail: what is classified.
struct Drawn {
  std::vector<SheetShare> shares; // of objects
  const ClassTable* table = nullptr;
  size_t group = 0;
  float weight = 1;
  TimeField time;
  std::optional<uint32_t> paint{}; // an object
  bool lit = true;                 // where the picture is
};

class TrailTile {
 public:
  TrailTile(const TrailJob& job, size_t n, const PlannedTile& tile, const TilePixels* surface,
            TrailMemory& memory, DrawStats& stats)
      : job_(job), options_(*job.options), tile_(tile), surface_(surface), m_(memory), stats_(stats),
        view_(*job.main->view),
        loops_(options_.reference_loops ? reference_matter_loops() : simd_matter_loops()),
        pitch_((tile.width + 15) / 16 * 16), pixels_(plane_size(pitch_, tile.height)) {
    if (job.slice) objects_.push_back(job.slice);
    for (const TrailObject& o : job.sources) objects_.push_back(&o);
    analytic_ = options_.shading && options_.gradient == GradientMethod::analytic;
    const SplatPlan& plan = objects_.front()->plan;
    differences_ = options_.shading && !analytic_ ? plan.sheets.border : 0;
    halfway_ = plan.sheets.halfway;
    for (const TrailObject* o : objects_) halfway_ = std::min(halfway_, o->plan.sheets.halfway);
    around_ = std::max(differences_, halfway_);
    m_.sheets.resize(std::max(m_.sheets.size(), objects_.size()));
    sources_.reserve(objects_.size());
    for (size_t i = 0; i < objects_.size(); ++i) {
      const TrailObject& o = *objects_[i];
      sources_.emplace_back(SheetSourceArgs{o.scene, &o.plan, &o.kernel, options_.reference_loops, analytic_},
                            o.plan.tiles[n], m_.sheets[i], stats);
      touched_.push_back(!o.plan.tiles[n].empty());
    }
    sheet_sources_ = {.object = sources_,
                      .loops = &loops_,
                      .first_sheet = view_.first_sheet(),
                      .height = tile.height,
                      .border = plan.sheets.border,
                      .plane_pitch = sources_.front().plane_pitch(),
                      .halfway = halfway_,
                      .gradients = analytic_,
                      .skip_empty = !(options_.disable_skips & skip_empty_sheets)};
    list_rings(n);
    prepare_pixels();
    prepare_rays();
    list_drawn();
    prepare_sheets();
  }

  TilePixels draw() {
    if (open_ > 0) march_sheets();
    for (SheetSource& s : sources_) s.end_sheets();
    finish_pixels();
    if (options_.with_deep) m_.deep.finish_tile(job_.context->progress);
    return finished_tile(tile_, pitch_, pixel_, options_.with_deep ? &m_.deep : nullptr);
  }

 private:
  // Open pixels are counted by the samples of a ring: once for all objects whose rings are alike.
  void list_rings(size_t n) {
    for (const TrailObject* o : objects_) {
      OpenPixels own;
      own.prepare(o->plan.tiles[n], o->plan);
      const auto like = std::find_if(open_pixels_.begin(), open_pixels_.end(),
                                     [&](const OpenPixels& other) { return own.counts_like(other); });
      ring_of_.push_back(static_cast<size_t>(like - open_pixels_.begin()));
      if (like == open_pixels_.end()) open_pixels_.push_back(std::move(own));
    }
  }

  void prepare_pixels() {
    float** const planes[] = {&pixel_.red,   &pixel_.green, &pixel_.blue, &pixel_.alpha,
                              &pixel_.depth, &pixel_.value, &pixel_.time};
    m_.pixels.reserve(7 * pixels_);
    std::fill_n(m_.pixels.data(), 7 * pixels_, 0.0f);
    for (size_t n = 0; n < 7; ++n) *planes[n] = m_.pixels.data() + n * pixels_;
    std::fill_n(pixel_.depth, pixels_, infinity);
    if (!options_.with_value) pixel_.value = nullptr;
    if (!options_.with_time) pixel_.time = nullptr;
    m_.matter.reserve(matter_planes(job_) * pixels_);
    float* at = m_.matter.data();
    for (auto& sheet : matter_) {
      sheet.resize(joined_groups + 2 * job_.pairs.size());
      for (MatterPlanes& group : sheet) {
        group = {at, at + pixels_, at + 2 * pixels_, at + 3 * pixels_, nullptr, nullptr};
        if (pixel_.value) group.value = at + 4 * pixels_;
        if (pixel_.time) group.time = at + 5 * pixels_;
        at += group_planes * pixels_;
      }
    }
    m_.hole.reserve(pixels_);
    size_t painted = 0;
    for (const TrailObject* o : objects_) painted = std::max(painted, paint_planes(*o->scene));
    if (m_.paint.capacity() < painted * pixels_) {
      m_.paint.reserve(painted * pixels_);
      std::fill_n(m_.paint.data(), m_.paint.capacity(), 0.0f); // what is read beside the tile are numbers
    }
    if (options_.with_deep)
      m_.deep.begin_tile(tile_.width, tile_.height, pitch_, options_.deep_tolerance,
                         options_.opacity_stop >= 1);
  }

  // Makes the rays of the picture (set 0) and of the objects that have a domain of their own. The picture's
  // then run where any object is; a surface ends all rays.
  void prepare_rays() {
    m_.rays.reserve((objects_.size() + 1) * ray_planes * pixels_);
    TileRays main = make_rays(*job_.main->slice, view_, tile_, pitch_, ray_plane(0, 0), pixel_);
    double low = main.low, high = main.high;
    rays_.assign(objects_.size(), pixel_);
    float *const enter = ray_plane(0, 0), *const leave = ray_plane(0, 1);
    for (size_t i = 0; i < objects_.size(); ++i) {
      const TrailObject& o = *objects_[i];
      if (!o.own_rays) continue;
      const float *const own_enter = ray_plane(i + 1, 0), *const own_leave = ray_plane(i + 1, 1);
      const TileRays r =
          make_rays(*o.scene->slice, *o.scene->view, tile_, pitch_, ray_plane(i + 1, 0), rays_[i]);
      if (r.open == 0) continue;
      low = low <= high ? std::min(low, r.low) : r.low, high = std::max(high, r.high);
      for (size_t p = 0; p < pixels_; ++p)
        enter[p] = std::min(enter[p], own_enter[p]), leave[p] = std::max(leave[p], own_leave[p]);
    }
    if (surface_ && !through_surface()) {
      end_at_surface(leave);
      for (size_t i = 0; i < objects_.size(); ++i)
        if (objects_[i]->own_rays) end_at_surface(ray_plane(i + 1, 1));
    }
    for (size_t p = 0; p < pixels_; ++p) open_ += enter[p] < leave[p];
    if (low <= high) set_sheets(low, high);
  }

  // Plane `n` of a set of rays: 0 where they enter, 1 where they leave.
  [[nodiscard]] float* ray_plane(size_t set, size_t n) const {
    return m_.rays.data() + (set * ray_planes + n) * pixels_;
  }

  void end_at_surface(float* leaves) const {
    for (int y = 0; y < tile_.height; ++y)
      for (int x = 0; x < tile_.width; ++x)
        if (const float hit = surface_hit(x, y); hit < infinity) {
          float& at = leaves[plane_index(x, y, pitch_)];
          at = std::min(at, hit);
        }
  }

  // Sets the sheets to be drawn: those that rays are in, from `low` to `high`, and some object was planned
  // for.
  void set_sheets(double low, double high) {
    int64_t first = INT64_MAX, last = INT64_MIN;
    for (const TrailObject* o : objects_) {
      first = std::min(first, o->plan.sheets.first - o->plan.sheets.lead);
      last = std::max(last, o->plan.sheets.last + o->plan.sheets.lead);
    }
    first_ = std::max({static_cast<int64_t>(std::ceil(low - 0.5)), view_.first_sheet(), first});
    last_ = std::min(static_cast<int64_t>(std::floor(high + 0.5)), last);
  }

  void list_drawn() {
    const uint32_t first_source = job_.slice ? 1 : 0;
    if (job_.slice)
      drawn_.push_back(
          {{{0, 1.0f}}, job_.slice->scene->table, 0, 1, TimeField(*job_.slice->scene->slice), {}});
    for (const TrailStill& s : job_.stills) {
      Drawn d{{s.shares.begin(), s.shares.end()},
              s.table,
              s.group,
              s.weight,
              TimeField(*job_.sources[s.shares.front().source].scene->slice),
              {}};
      for (SheetShare& share : d.shares) share.source += first_source;
      if (s.paint) d.paint = *s.paint + first_source;
      d.lit = s.lit;
      if (d.shares.size() > 1) d.time.offset = s.frame, d.time.gradient = {};
      drawn_.push_back(std::move(d));
    }
  }

  void prepare_sheets() {
    size_t mixed = 0;
    for (const Drawn& d : drawn_) mixed += d.shares.size() > 1 ? 1u : 0u;
    const size_t floats = sheet_sources_.mixed_floats();
    if (m_.mixed.capacity() < mixed * floats) {
      m_.mixed.reserve(mixed * floats);
      std::fill_n(m_.mixed.data(), m_.mixed.capacity(), 0.0f);
    }
    float* next = m_.mixed.data();
    sheets_.reserve(drawn_.size());
    for (const Drawn& d : drawn_) {
      sheets_.emplace_back(sheet_sources_, d.shares, *d.table, next);
      if (d.shares.size() > 1) next += floats;
    }
  }

  // Returns whether rays go on behind the surface: by equation (8) as printed nothing is opaque.
  [[nodiscard]] bool through_surface() const { return surface_ && job_.combine == TrailCombine::interleaved; }

  [[nodiscard]] float surface_hit(int x, int y) const {
    const size_t at = plane_index(x, y, surface_->pitch);
    return surface_->alpha[at] > 0 ? surface_->depth[at] : infinity;
  }

  void march_sheets() {
    for (SheetSource& s : sources_)
      s.begin_sheets(std::max(first_ - around_, view_.first_sheet()), last_ + around_);
    next_mixed_ = first_ - around_;
    auto clock = StageClock::now();
    int64_t end = 0;
    for (int64_t k = first_; k <= last_ && open_ > 0; k = end) {
      job_.context->progress.check();
      // How segments are lit depends on what is open where those together begin: in all tiles the same.
      end = std::min((k | (sheets_together - 1)) + 1, last_ + 1);
      const int64_t through = end - 1 + around_;
      const bool hides = count_open(k);
      for (auto& sheet : used_) sheet.assign(matter_.front().size(), 0);
      for (size_t n = 0; n < drawn_.size(); ++n) {
        for (const SheetShare& s : drawn_[n].shares) complete(s.source, through, hides, clock);
        if (drawn_[n].paint) complete(*drawn_[n].paint, through, hides, clock);
        sheets_[n].mix(next_mixed_, through);
        for (int64_t sheet = k; sheet < end; ++sheet) add_sheet(drawn_[n], sheets_[n], sheet, sheet - k);
        add_lap(clock, stats_.ms_shade);
      }
      next_mixed_ = through + 1;
      for (int64_t sheet = k; through_surface() && sheet < end; ++sheet) add_surface_to(sheet, sheet - k);
      for (int64_t sheet = k; sheet < end; ++sheet) join_sheet(sheet, sheet - k);
      add_lap(clock, stats_.ms_shade);
    }
  }

  void complete(uint32_t object, int64_t through, bool hides, StageClock::time_point& clock) {
    if (!touched_[object]) return;
    job_.context->progress.check();
    sources_[object].complete_sheets(through, hides ? &open_pixels_[ring_of_[object]] : nullptr, clock);
  }

  // Counts the pixels still open anew when enough have closed since or have come to the surface; returns
  // whether anything is to be left out.
  bool count_open(int64_t k) {
    if ((options_.disable_skips & skip_occlusion) || (closed_ == 0 && (!surface_ || through_surface())))
      return false;
    const bool few = summed_closed_ > 0 && (closed_ - summed_closed_) * closed_part < open_;
    if (!few || surface_) {
      summed_closed_ = closed_;
      const float front = static_cast<float>(k) - 0.5f;
      for (OpenPixels& ring : open_pixels_)
        ring.count(pitch_, [&](size_t p) {
          return pixel_.alpha[p] < options_.opacity_stop && front < pixel_.leave[p];
        });
    }
    return true;
  }

  // Adds what `d` absorbs on sheet k, which is number n of those under way.
  void add_sheet(const Drawn& d, TrailSheets& sheets, int64_t k, int64_t n) {
    const size_t object = sheets.object(), at = n;
    const SplatScene& scene = *objects_[object]->scene;
    if (!sheets.seen(scene.slice->base, k)) {
      ++stats_.sheets_skipped;
      return;
    }
    const MatterPlanes& matter = cleared(at, d.group);
    if (d.lit) sheets.mix_gradients(k);
    absorb_sheet(d, sheets, *objects_[object], rays_[object], k, matter);
  }

  // Returns the planes of a group on sheet `n` of those under way, which hold nothing when it is first used.
  const MatterPlanes& cleared(size_t n, size_t group) {
    const MatterPlanes& matter = matter_[n][group];
    if (!std::exchange(used_[n][group], 1)) std::fill_n(matter.red, group_planes * pixels_, 0.0f);
    return matter;
  }

  // Joins slice and trail of each pair, and adds them to what all objects absorb.
  void join_pairs(size_t n) {
    for (size_t pair = 0; pair < job_.pairs.size(); ++pair) {
      const size_t first = joined_groups + 2 * pair;
      MatterPair a{tile_.width, tile_.height, pitch_, {}, job_.pairs[pair]};
      for (size_t g = 0; g < 2; ++g) a.group[g] = used_[n][first + g] ? &matter_[n][first + g] : nullptr;
      if (a.group[0] || a.group[1]) pair_up(a, cleared(n, 1));
    }
  }

  // The slice's part of a sheet, where it is a surface that rays go through: pixels whose surface is in the
  // sheet's segment or before it are opaque.
  void add_surface_to(int64_t k, int64_t n) {
    constexpr float opaque = 64; // an optical depth: floats know no more
    const size_t at = n;
    const MatterPlanes& matter = matter_[at][0];
    const float end = static_cast<float>(k) + 0.5f;
    for (int y = 0; y < tile_.height; ++y)
      for (int x = 0; x < tile_.width; ++x) {
        const size_t p = plane_index(x, y, pitch_), s = plane_index(x, y, surface_->pitch);
        if (!(surface_hit(x, y) <= end) || end - 1 > pixel_.leave[p]) continue;
        (void)cleared(at, 0);
        matter.red[p] = opaque * surface_->red[s], matter.green[p] = opaque * surface_->green[s];
        matter.blue[p] = opaque * surface_->blue[s];
        matter.depth[p] = opaque;
        if (matter.value) matter.value[p] = opaque * surface_->value[s];
        if (matter.time) matter.time[p] = opaque * surface_->time[s];
      }
  }

  void join_sheet(int64_t k, int64_t n) {
    const size_t at = n;
    join_pairs(at);
    if (!used_[at][0] && !used_[at][1]) return;
    JoinArgs j;
    j.k = static_cast<float>(k), j.front = k == view_.first_sheet() ? 2 : 0.5f;
    j.width = tile_.width, j.height = tile_.height, j.pitch = pitch_;
    for (size_t g = 0; g < 2; ++g) j.group[g] = used_[at][g] ? &matter_[at][g] : nullptr;
    j.combine = job_.combine;
    j.stop = stop(), j.depth_at = options_.depth_opacity;
    j.pixel = pixel_;
    const int closed = loops_.join(j);
    closed_ += closed, open_ -= closed;
    if (options_.with_deep) m_.deep.add_segment(pixel_, j.k - j.front, j.k + 0.5f, all_pixels);
  }

  void absorb_sheet(const Drawn& d, const TrailSheets& sheets, const TrailObject& object,
                    const PixelPlanes& rays, int64_t k, const MatterPlanes& out) {
    const SplatScene& scene = *object.scene;
    const float base = scene.slice->base;
    SheetArgs a{.tile = {.x = tile_.x,
                         .y = tile_.y,
                         .width = tile_.width,
                         .height = tile_.height,
                         .pitch = pitch_,
                         .plane_pitch = sheet_sources_.plane_pitch,
                         .seen = sheets.sees_base(base) ? all_pixels : sheets.touched(k)},
                .field = {.base = base},
                .analytic = {.ripple = {.sums = object.plan.sums.get()}},
                .classes = {.table = d.table, .stop = stop()},
                .shading = {.on = options_.shading && d.lit, .lights = scene.lights},
                .pixel = rays};
    set_sheet(a, *scene.slice, *scene.view, k, analytic_, differences_,
              [&](int64_t sheet, size_t quantity) { return sheets.plane(sheet, quantity); });
    if (!d.table->integrals.empty())
      set_halfway(a, *scene.view, k, halfway_, [&](int64_t sheet) { return sheets.plane(sheet, 0); });
    if (scene.slice->has_holes) {
      const Missing missing = find_holes(*scene.slice, *scene.view, a, m_.hole.data());
      if (missing == Missing::all) return;
      if (missing == Missing::some) a.hole = m_.hole.data();
    }
    if (pixel_.time) a.time = sheet_time(d.time, *scene.view, k);
    if (d.paint || scene.light || scene.slice->labels) {
      const SheetPainter painter(a, k, m_.paint, pixels_);
      if (scene.slice->labels) painter.labels(scene);
      if (d.paint) painter.color(*objects_[*d.paint]->scene, sources_[*d.paint].plane(k, 0));
      if (scene.light && options_.shading) painter.light(scene);
    }
    loops_.absorb(a, d.weight, out);
  }

  [[nodiscard]] float stop() const {
    return options_.opacity_stop < 1 ? static_cast<float>(options_.opacity_stop) : 2.0f;
  }

  void finish_pixels() {
    for (int y = 0; y < (surface_ && !through_surface() ? tile_.height : 0); ++y)
      for (int x = 0; x < tile_.width; ++x) {
        const size_t p = plane_index(x, y, pitch_);
        if (surface_hit(x, y) < infinity && pixel_.alpha[p] < stop()) add_surface(x, y, p);
      }
    if (options_.with_deep) m_.deep.put_fronts_back(pixel_);
    for (int y = 0; y < tile_.height; ++y)
      for (int x = 0; x < tile_.width; ++x) {
        const size_t p = plane_index(x, y, pitch_);
        const float alpha = pixel_.alpha[p];
        if (pixel_.value) pixel_.value[p] = alpha > 0 ? pixel_.value[p] / alpha : nan_value;
        if (pixel_.time) pixel_.time[p] = alpha > 0 ? pixel_.time[p] / alpha : nan_value;
      }
  }

  void add_surface(int x, int y, size_t p) {
    const size_t at = plane_index(x, y, surface_->pitch);
    const float open = 1 - pixel_.alpha[p];
    pixel_.red[p] += open * surface_->red[at], pixel_.green[p] += open * surface_->green[at];
    pixel_.blue[p] += open * surface_->blue[at];
    if (pixel_.value) pixel_.value[p] += open * surface_->value[at];
    if (pixel_.time) pixel_.time[p] += open * surface_->time[at];
    if (pixel_.alpha[p] < options_.depth_opacity) pixel_.depth[p] = surface_->depth[at];
    pixel_.alpha[p] = 1;
    if (options_.with_deep) (void)m_.deep.add_surface(pixel_, p, surface_->depth[at], 1);
  }

  const TrailJob& job_;
  const SplatOptions& options_;
  const PlannedTile& tile_;
  const TilePixels* surface_;
  TrailMemory& m_;
  DrawStats& stats_;
  const SheetView& view_;
  const MatterLoops& loops_;
  int pitch_;
  size_t pixels_;
  std::vector<const TrailObject*> objects_;
  std::vector<SheetSource> sources_; // per object
  std::vector<bool> touched_;        // per object: it has points in this tile
  std::vector<PixelPlanes> rays_;    // per object
  std::vector<Drawn> drawn_;
  TrailSheetSources sheet_sources_;
  std::vector<TrailSheets> sheets_; // per drawn
  bool analytic_ = false;
  int differences_ = 0, halfway_ = 0;
  int around_ = 0; // sheets on either side that gradients or segments look at
  PixelPlanes pixel_;
  std::array<std::vector<MatterPlanes>, sheets_together> matter_; // of the sheets under way, by group
  std::array<std::vector<char>, sheets_together> used_;           // there is something
  std::vector<OpenPixels> open_pixels_;                           // per ring
  std::vector<size_t> ring_of_;                                   // per object
  int64_t first_ = 0, last_ = -1, next_mixed_ = 0;
  int open_ = 0, closed_ = 0, summed_closed_ = 0; // pixels
};

} // namespace

TilePixels draw_trail_tile(const TrailJob& job, size_t n, const PlannedTile& tile, const TilePixels* surface,
                           TrailMemory& memory, DrawStats& stats) {
  return TrailTile(job, n, tile, surface, memory, stats).draw();
}

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Settles a shot in the order of settled_picture.h, and has it drawn with smooth edges and deep samples.
#include "scene/settled_picture.h"

#include <algorithm>
#include <cmath>

#include "base/grid.h"
#include "draw/deep.h"
#include "draw/edge_smoother.h"

namespace bccsplat {
namespace {

// Returns whether the same lattice units are the same point of slice space.
bool same_place(const Slice& a, const Slice& b) {
  return a.domain_begin == b.domain_begin && a.domain_end == b.domain_end &&
         a.lattice_to_slice.linear == b.lattice_to_slice.linear &&
         a.lattice_to_slice.offset == b.lattice_to_slice.offset;
}

bool masked(const Slice& slice, const Trail* trail) {
  return slice.mask || (trail && std::any_of(trail->sources.begin(), trail->sources.end(),
                                             [](const TrailSource& s) { return s.slice.mask != nullptr; }));
}

bool corrected(const Slice& slice, const Trail* trail) {
  return slice.corrections ||
         (trail && std::any_of(trail->sources.begin(), trail->sources.end(),
                               [](const TrailSource& s) { return s.slice.corrections != nullptr; }));
}

ShotOptions shot_options(const RenderOptions& options, const Slice& slice, const Image& image) {
  ShotOptions o;
  o.mode = options.mode;
  o.shading = shaded(options, slice);
  o.without_ripple = options.without_ripple && o.shading;
  if (o.mode == RenderMode::isosurface) o.surfaces = drawn_surfaces(options);
  o.opacity_stop = options.opacity_stop;
  o.disable_skips = options.disable_skips;
  o.tile_size = options.tile_size;
  o.with_depth = image.depth.pixels;
  o.with_value = image.value.pixels, o.with_time = image.time.pixels;
  o.with_deep = image.deep, o.deep_tolerance = options.deep_tolerance;
  o.depth_opacity = static_cast<float>(std::min(options.depth_opacity, options.opacity_stop));
  return o;
}

// Returns the level of the slice that is drawn; `view` is of the slice itself.
int level_of(const Scene& scene, const RenderOptions& options, const SliceView& view) {
  // A trail is on the lattice of its slice, and the mean of a maximum is not the maximum of a mean.
  if (!scene.levels || scene.trail || scene.slice->labels || scene.slice->scattered ||
      options.mode == RenderMode::maximum || (options.disable_skips & skip_fine_detail))
    return 0;
  if (!quality_settings(options.quality).coarse_levels && options.mode != RenderMode::xray) return 0;
  return minification_level(*scene.slice, view);
}

// Returns the least distance that sheets may have, lattice units.
double least_step(const Slice& slice) { return 2 * slice.kernel.space.radius / most_sheets_in_reach; }

// Returns the distance of the sheets, in lattice units of the slice that is drawn. A step asked for stays the
// same length at every level, down to what the smoother field can show. Corrections and masks are as fine as
// the source, however coarse the lattice; coarser levels have no corrections, and their sheets are as far
// from each other as without the mask.
double step_of(const Scene& scene, const RenderOptions& options, int level, const Slice& slice,
               const SliceView& view) {
  constexpr double finest_coarse_step = 1.0 / 16;
  double step = options.sheet_step > 0 ? options.sheet_step : quality_settings(options.quality).sheet_step;
  if (options.sheet_step > 0 && level > 0) step = std::max(std::ldexp(step, -level), finest_coarse_step);
  if (options.sheet_step == 0 &&
      (corrected(slice, scene.trail) || (level == 0 && masked(slice, scene.trail))))
    step /= std::max(1.0, length(slice.lattice_to_slice.vector(view.normal()))); // source samples per unit
  return std::max(step, least_step(slice));
}

// Returns the function's colours, all of which are looked at.
TransferFunction opaque(const TransferFunction& function) {
  TransferFunction f = function;
  f.opacities = {{f.colors.front().value, 1}};
  return f;
}

// Returns the table of a transfer function over values `bounds`, in the units of the scene's own slice.
ClassTable table_of(const Scene& scene, const RenderOptions& options, const TransferFunction& function,
                    const std::array<double, 2>& bounds, float base) {
  const double unit = function.unit_distance > 0 ? function.unit_distance : mean_voxel(*scene.slice);
  return make_class_table(function, bounds[0], bounds[1], base, unit,
                          quality_settings(options.quality).table_entries);
}

} // namespace

void write_tile(const TilePixels& tile, const SheetView& view, Image& image) {
  for (int y = 0; y < tile.height; ++y) {
    const size_t row = plane_index(0, y, tile.pitch);
    const int py = tile.y + y;
    float* rgba = image.rgba.at(tile.x, py);
    const float *const red = tile.red + row, *const green = tile.green + row, *const blue = tile.blue + row,
                       *const alpha = tile.alpha + row;
    for (int x = 0; x < tile.width; ++x, rgba += 4)
      rgba[0] = red[x], rgba[1] = green[x], rgba[2] = blue[x], rgba[3] = alpha[x];
    if (!image.depth.pixels && !image.value.pixels && !image.time.pixels) continue;
    for (int x = 0; x < tile.width; ++x) {
      const size_t p = row + x;
      const int px = tile.x + x;
      if (image.depth.pixels)
        *image.depth.at(px, py) = static_cast<float>((tile.depth[p] + view.depth) * view.step_world);
      if (image.value.pixels) *image.value.at(px, py) = tile.value[p];
      if (image.time.pixels) *image.time.at(px, py) = tile.time[p];
    }
  }
}

void tell_drawn(const TilePixels& tile, const Image& image) {
  image.tell_drawn({tile.x, tile.y, tile.x + tile.width, tile.y + tile.height});
}

void SettledPicture::settle_level() {
  const Sight sight = sight_of(scene_, image_.width, image_.height);
  seen_.emplace(*scene_.slice, sight, image_.width, image_.height);
  level_ = level_of(scene_, options_, *seen_);
  shot_.slice = scene_.slice, shot_.points = scene_.points;
  if (level_ > 0) {
    scene_.slice->coset.make(context_);
    const CoarseLevels::Level& coarse = scene_.levels->level(*scene_.slice, level_, context_);
    shot_.slice = &coarse.slice, shot_.points = &coarse.points;
    seen_.emplace(coarse.slice, sight, image_.width, image_.height);
  }
  step_ = step_of(scene_, options_, level_, *shot_.slice, *seen_);
}

double SettledPicture::least_apart() const { return least_step(*shot_.slice) * seen_->world_per_unit(); }

void SettledPicture::settle_view(std::optional<double> sheets_apart) {
  if (sheets_apart) step_ = *sheets_apart / seen_->world_per_unit();
  view_ = seen_->sheets(step_);
  (void)sheet_range(*shot_.slice, view_); // refuses what has too many sheets
  shot_.view = &view_;
}

void SettledPicture::settle_look() {
  shot_.function = &scene_.function;
  table_ = table_of(scene_, options_, scene_.function, shot_.slice->bounds, shot_.slice->base);
  shot_.table = &table_;
  shot_.lights = &scene_.lights;
  shot_.noise_of_ripple = scene_.noise_of_ripple;
  shot_.voxel = mean_voxel(*scene_.slice); // at every level, so that levels are lit alike
  shot_.quality = options_.quality;
  shot_.preintegrate = options_.preintegrate;
  shot_.options = shot_options(options_, *scene_.slice, image_);
  shot_.options.with_depth = shot_.options.with_depth || smooths_edges(); // which are known by their depths
  shot_.options.with_hits = smooths_edges() && EdgeSmoother::needs_hits(shot_.options);
  // Nobody knows whether the host's depths are those of the picture before.
  if (view_.ends.distance) shot_.options.disable_skips |= skip_unchanged;
  shot_.wishes = &options_, shot_.target = options_.target;
}

void SettledPicture::settle_paint() {
  if (!scene_.paint) return;
  const ScenePaint& by = *scene_.paint;
  paint_.slice = by.slice, paint_.points = by.points;
  by.slice->coset.make(context_);
  if (level_ > 0 && by.levels && !by.slice->labels) { // no coarser slice has labels
    const CoarseLevels::Level& coarse = by.levels->level(*by.slice, level_, context_);
    paint_.slice = &coarse.slice, paint_.points = &coarse.points;
  }
  const SliceView seen(*paint_.slice, sight_of(scene_, image_.width, image_.height), image_.width,
                       image_.height);
  paint_view_ = seen.sheets(step_ * seen_->world_per_unit() / seen.world_per_unit());
  paint_function_ = opaque(by.function);
  paint_table_ = table_of(scene_, options_, paint_function_, paint_.slice->bounds, paint_.slice->base);
  paint_.view = &paint_view_, paint_.function = &paint_function_, paint_.table = &paint_table_;
  shot_.paint = &paint_;
}

void SettledPicture::settle_light() {
  if (!casts_shadows(scene_, options_)) return;
  light_ = drawers().light.of(shot_, context_);
  shot_.light = light_.get();
}

void SettledPicture::settle_trail() {
  if (scene_.trail && !scene_.trail->moments.empty()) settle_trail(*scene_.trail);
}

void SettledPicture::settle_trail(const Trail& trail) {
  settled_trail_ = &trail, trail_ = {}, moved_.clear();
  trail_.combine = scene_.combine, trail_.unlit = scene_.trail_unlit;
  trail_.functions = scene_.trail_functions;
  for (const TransferFunction& f : scene_.trail_functions)
    trail_.tables.push_back(table_of(scene_, options_, f, trail.bounds, scene_.slice->base));
  for (const TrailSource& source : trail.sources) {
    const SheetView* of_source = &view_;
    if (!same_place(*scene_.slice, source.slice))
      of_source = &moved_.emplace_back(move_view(view_, *scene_.slice, source.slice));
    trail_.sources.push_back({&source.slice, &source.points, of_source});
  }
  for (const TrailMoment& m : trail.moments)
    trail_.stills.push_back({m.shares, std::min(static_cast<size_t>(m.interval), trail_.functions.size() - 1),
                             static_cast<float>(m.weight), m.frame});
  shot_.trail = &trail_;
}

Drawer& SettledPicture::choose_drawer(Backend backend) {
  for (SettledPicture* p : all_) p->shot_.sums = &p->drawers().sums;
  Drawer& drawer = drawers().drawer_of(shots_, {!options_.rays || scene_.trail, backend, options_.gpu});
  for (SettledPicture* p : all_) {
    if (drawer.merges()) break;
    p->shot_.slice->coset.make(context_);
    if (const Trail* const trail = p->settled_trail_; trail && trail->by_cpu)
      p->settle_trail(trail->by_cpu->get(context_));
  }
  return drawer;
}

void SettledPicture::settle_drawer() {
  drawer_ = &choose_drawer(options_.backend);
  drawer_->prepare(shots_, context_);
}

// Draws, by the CPU where a GPU fails that nobody insists on.
DrawStats SettledPicture::draw_tiles(RenderStats& stats, const std::function<void(const TilePixels&)>& emit) {
  try {
    stats.drawer = drawer_->name();
    return drawer_->draw(shots_, context_, emit);
  } catch (const GpuFailure& e) {
    if (options_.backend == Backend::gpu || !has_cpu_drawers) throw;
    stats.gpu_failed = e.message();
    note_failure(options_.gpu.get(), e);
  }
  drawer_ = &choose_drawer(Backend::cpu);
  stats.drawer = drawer_->name();
  return drawer_->draw(shots_, context_, emit);
}

RenderStats SettledPicture::draw() {
  // Trails end at the pixel centre's surface and deep samples have one depth: neither has edges to be
  // smoothed.
  EdgeSmoother edges(smooths_edges(), context_, image_, shot_.options);
  DeepCollector deep(context_.memory);
  RenderStats stats;
  stats.drawn = draw_tiles(stats, [&](const TilePixels& tile) {
    write_tile(tile, view_, image_);
    edges.add(tile);
    if (tile.deep) deep.add(tile, view_, context_.progress);
    if (!edges.at_work()) tell_drawn(tile, image_);
  });
  if (!shot_.trail) {
    const EdgeStats smoothed = edges.smooth(shot_, context_);
    stats.edge_pixels = smoothed.pixels;
    stats.drawn.ms_shade += smoothed.ms;
  }
  if (image_.deep) *image_.deep = deep.collect(image_.width, image_.height, context_.progress);
  stats.sheet_step = std::ldexp(view_.step, level_);
  stats.level = level_;
  return stats;
}

RenderStats SettledPicture::draw_truth(const FieldAt* field, const ReferenceOptions* reference) {
  view_ =
      make_view(*scene_.slice, sight_of(scene_, image_.width, image_.height), image_.width, image_.height, 1);
  shot_.slice = scene_.slice, shot_.view = &view_;
  settle_look();
  // A field of the caller's has no noise of the kernel.
  if (field) shot_.noise_of_ripple = false;
  const FieldAt own = slice_field(
      *scene_.slice, shot_.options.without_ripple
                         ? lattice_sums(*scene_.slice, scene_.drawers ? &scene_.drawers->sums : nullptr)
                         : nullptr);
  const ReferenceOptions steps = reference ? *reference
                                 : options_.mode == RenderMode::composite
                                     ? ReferenceOptions{reference_step(scene_.function, scene_.slice->bounds)}
                                     : ReferenceOptions{};
  draw_reference(shot_, field ? *field : own, steps, context_, image_);
  image_.tell_all_drawn();
  RenderStats stats;
  stats.drawn.points_total = static_cast<uint64_t>(scene_.slice->points());
  stats.sheet_step = steps.step;
  return stats;
}

} // namespace bccsplat

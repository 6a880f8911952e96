// SPDX-License-Identifier: Apache-2.0
// Settles a picture: the level of the slice and its view, by the camera and the quality; the table of the
// transfer function; the trail's; and the drawer. Then has it drawn, with smooth edges and deep samples.
#include "scene/picture.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>

#include "base/error.h"
#include "base/grid.h"
#include "draw/deep.h"
#include "draw/edge_smoother.h"
#include "draw/stage_clock.h"
#include "view/sheet_metric.h"

namespace bccsplat {
namespace {

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

// Pixels per side of an image: the number of any pixel fits 32 bits (SurfaceHit).
constexpr int most_pixels = 65536;

void check_options(const Scene& scene, const RenderOptions& options, const Image& image) {
  if (scene.trail && options.reference)
    fail(Code::unsupported, "render: the reference integrator draws no trails");
  if (scene.trail && (options.mode == RenderMode::xray || options.mode == RenderMode::maximum))
    fail(Code::unsupported, "render: a trail goes with modes composite and isosurface");
  if (scene.trail && scene.trail_functions.empty())
    fail(Code::invalid_argument, "render: the trail has no transfer function");
  for (const TransferFunction& f : scene.trail_functions) f.check();
  if (scene.trail && options.mode == RenderMode::isosurface && sees_through(drawn_surfaces(options)))
    fail(Code::unsupported, "render: a trail goes with isosurfaces that are opaque");

  if (image.deep) {
    if (options.mode == RenderMode::xray || options.mode == RenderMode::maximum)
      fail(Code::unsupported, "render: deep pictures are of modes composite and isosurface");
    if (options.reference) fail(Code::unsupported, "render: the reference integrator draws no deep pictures");
    if (scene.trail && scene.combine == TrailCombine::post)
      fail(Code::unsupported,
           "render: a trail laid under a finished picture has no depth; combine it in depth");
  }
  if (!(options.deep_tolerance >= 0 && options.deep_tolerance <= 1))
    fail(Code::invalid_argument, "render: deep_tolerance ", options.deep_tolerance, " is outside [0, 1]");
  if (!scene.slice) fail(Code::wrong_state, "render: no slice is set");
  if (image.width < 1 || image.height < 1 || image.width > most_pixels || image.height > most_pixels ||
      !image.rgba.pixels)
    fail(Code::invalid_argument, "render: the image needs 1 to ", most_pixels,
         " pixels per side and an RGBA plane");
  if (!(options.sheet_step >= 0 && std::isfinite(options.sheet_step)))
    fail(Code::invalid_argument, "render: sheet_step must be finite and not negative");
  if (!(options.opacity_stop > 0 && options.opacity_stop <= 1))
    fail(Code::invalid_argument, "render: opacity_stop ", options.opacity_stop, " is outside (0, 1]");
  if (options.tile_size < 0) fail(Code::invalid_argument, "render: tile_size must not be negative");
  if (options.mode == RenderMode::isosurface)
    for (const IsoSurface& s : drawn_surfaces(options))
      if (!std::isfinite(s.value) || !(s.opacity >= 0 && s.opacity <= 1))
        fail(Code::invalid_argument, "render: values of isosurfaces must be finite, their opacities 0 to 1");
  if (options.mode == RenderMode::xray && shaded(options))
    fail(Code::unsupported, "render: an X-ray has no surface to shade; turn shading off");
  for (const Light& light : scene.lights.lights)
    for (size_t a = 0; a < 3; ++a)
      if (!std::isfinite(light.direction[a]) || !std::isfinite(light.color[a]))
        fail(Code::invalid_argument, "render: lights must be finite");
  scene.function.check();
}

ShotOptions shot_options(const RenderOptions& options, const Image& image) {
  ShotOptions o;
  o.mode = options.mode;
  o.shading = shaded(options);
  o.without_ripple = options.without_ripple && o.shading;
  if (o.mode == RenderMode::isosurface) o.surfaces = drawn_surfaces(options);
  o.opacity_stop = options.opacity_stop;
  o.disable_skips = options.disable_skips;
  o.tile_size = options.tile_size;
  o.with_value = image.value.pixels, o.with_time = image.time.pixels;
  o.with_deep = image.deep, o.deep_tolerance = options.deep_tolerance;
  return o;
}

// Returns the level of the slice that is drawn; `view` is of the slice itself.
int level_of(const Scene& scene, const RenderOptions& options, const SliceView& view) {
  // A trail is on the lattice of its slice, and the mean of a maximum is not the maximum of a mean.
  if (!scene.levels || scene.trail || options.mode == RenderMode::maximum ||
      (options.disable_skips & skip_fine_detail))
    return 0;
  if (!quality_settings(options.quality).coarse_levels && options.mode != RenderMode::xray) return 0;
  return minification_level(*scene.slice, view);
}

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
  return std::max(step, 2 * slice.kernel.space.radius / most_sheets_in_reach);
}

// Returns the table of a transfer function over values `bounds`, in the units of the scene's own slice.
ClassTable table_of(const Scene& scene, const RenderOptions& options, const TransferFunction& function,
                    const std::array<double, 2>& bounds, float base) {
  const double unit = function.unit_distance > 0 ? function.unit_distance : mean_voxel(*scene.slice);
  return make_class_table(function, bounds[0], bounds[1], base, unit,
                          quality_settings(options.quality).table_entries);
}

} // namespace

// What a shot refers to.
struct Picture::Settled {
  const Scene& scene;
  const RenderOptions& options;
  const Context& context;
  Image& image;
  std::chrono::steady_clock::time_point begin = std::chrono::steady_clock::now();

  int level = 0;
  SheetView view;
  ClassTable table;
  ShotTrail trail;
  std::deque<SheetView> moved; // of the trail's sources with a domain of their own
  Shot shot;
  Drawers of_picture; // where nothing is kept
  Drawer* drawer = nullptr;

  Settled(const Scene& s, const RenderOptions& o, const Context& c, Image& i)
      : scene(s), options(o), context(c), image(i) {}

  void settle_slice() {
    const Sight sight = sight_of(scene, image.width, image.height);
    SliceView seen(*scene.slice, sight, image.width, image.height);
    level = level_of(scene, options, seen);
    shot.slice = scene.slice, shot.points = scene.points;
    if (level > 0) {
      const CoarseLevels::Level& coarse = scene.levels->level(*scene.slice, level, context);
      shot.slice = &coarse.slice, shot.points = &coarse.points;
      seen = SliceView(coarse.slice, sight, image.width, image.height);
    }
    view = seen.sheets(step_of(scene, options, level, *shot.slice, seen));
    (void)sheet_range(*shot.slice, view); // refuses what has too many sheets
    shot.view = &view;
  }

  void settle_look() {
    shot.function = &scene.function;
    table = table_of(scene, options, scene.function, shot.slice->bounds, shot.slice->base);
    shot.table = &table;
    shot.lights = &scene.lights;
    shot.noise_of_ripple = scene.noise_of_ripple;
    shot.voxel = mean_voxel(*scene.slice); // at every level, so that levels are lit alike
    shot.quality = options.quality;
    shot.preintegrate = options.preintegrate;
    shot.options = shot_options(options, image);
    // Nobody knows whether the host's depths are those of the picture before.
    if (view.ends.distance) shot.options.disable_skips |= skip_unchanged;
    shot.wishes = &options;
  }

  void settle_trail() {
    if (!scene.trail || scene.trail->moments.empty()) return;
    trail.combine = scene.combine;
    trail.functions = scene.trail_functions;
    for (const TransferFunction& f : scene.trail_functions)
      trail.tables.push_back(table_of(scene, options, f, scene.trail->bounds, scene.slice->base));
    for (const TrailSource& source : scene.trail->sources) {
      const SheetView* of_source = &view;
      if (!same_place(*scene.slice, source.slice))
        of_source = &moved.emplace_back(move_view(view, *scene.slice, source.slice));
      trail.sources.push_back({&source.slice, &source.points, of_source});
    }
    for (const TrailMoment& m : scene.trail->moments)
      trail.stills.push_back({m.shares, std::min(static_cast<size_t>(m.interval), trail.functions.size() - 1),
                              static_cast<float>(m.weight), m.frame});
    shot.trail = &trail;
  }

  void settle_drawer() {
    Drawers& drawers = scene.drawers ? *scene.drawers : of_picture;
    shot.sums = &drawers.sums;
    drawer = &drawers.drawer_of(shot, !options.rays || scene.trail);
    drawer->prepare(shot, context);
  }

  RenderStats draw() {
    // Trails end at the pixel centre's surface and deep samples have one depth: neither has edges to be
    // smoothed.
    EdgeSmoother edges(options.smooth_edges && !shot.trail && !image.deep, context, image, shot.options);
    DeepCollector deep(context.memory);
    RenderStats stats;
    stats.drawn = drawer->draw(shot, context, [&](const TilePixels& tile) {
      write_tile(tile, view, image);
      edges.add(tile);
      if (tile.deep) deep.add(tile, view, context.progress);
    });
    if (!shot.trail) {
      const EdgeStats smoothed = edges.smooth(shot, context);
      stats.edge_pixels = smoothed.pixels;
      stats.drawn.ms_shade += smoothed.ms;
    }
    if (image.deep) *image.deep = deep.collect(image.width, image.height, context.progress);
    stats.sheet_step = std::ldexp(view.step, level);
    stats.level = level;
    return stats;
  }

  // Draws by the reference, whose samples are `reference` lattice units apart; field: null for the slice's.
  RenderStats draw_truth(const FieldAt* field, const ReferenceOptions* reference) {
    view = make_view(*scene.slice, sight_of(scene, image.width, image.height), image.width, image.height, 1);
    shot.slice = scene.slice, shot.view = &view;
    settle_look();
    // A field of the caller's has no noise of the kernel.
    if (field) shot.noise_of_ripple = false;
    const FieldAt own = slice_field(
        *scene.slice, shot.options.without_ripple
                          ? lattice_sums(*scene.slice, scene.drawers ? &scene.drawers->sums : nullptr)
                          : nullptr);
    const ReferenceOptions steps = reference ? *reference
                                   : options.mode == RenderMode::composite
                                       ? ReferenceOptions{reference_step(scene.function, scene.slice->bounds)}
                                       : ReferenceOptions{};
    draw_reference(shot, field ? *field : own, steps, context, image);
    RenderStats stats;
    stats.drawn.points_total = static_cast<uint64_t>(scene.slice->points());
    stats.sheet_step = steps.step;
    return stats;
  }
};

Picture::Picture(const Scene& scene, const RenderOptions& options, const Context& context, Image& image) {
  check_options(scene, options, image);
  settled_ = std::make_unique<Settled>(scene, options, context, image);
  if (options.reference) return;
  settled_->settle_slice();
  settled_->settle_look();
  settled_->settle_trail();
  settled_->settle_drawer();
}

Picture::~Picture() = default;

const char* Picture::drawer() const { return settled_->drawer ? settled_->drawer->name() : "reference"; }

RenderStats Picture::draw() {
  Settled& s = *settled_;
  RenderStats stats = s.options.reference ? s.draw_truth(nullptr, nullptr) : s.draw();
  stats.threads = s.context.tasks.threads();
  stats.ms_total = ms_since(s.begin);
  return stats;
}

RenderStats Picture::draw_truth(const FieldAt& field, const ReferenceOptions& reference) {
  return settled_->draw_truth(&field, &reference);
}

Sight sight_of(const Scene& scene, int width, int height) {
  return scene.sight ? *scene.sight : make_sight(scene.camera, width, height);
}

RenderStats render(const Scene& scene, const RenderOptions& options, const Context& context, Image& image) {
  return Picture(scene, options, context, image).draw();
}

RenderStats render_reference(const Scene& scene, const RenderOptions& options, const FieldAt& field,
                             const ReferenceOptions& reference, const Context& context, Image& image) {
  RenderOptions by_reference = options;
  by_reference.reference = true;
  return Picture(scene, by_reference, context, image).draw_truth(field, reference);
}

bool shaded(const RenderOptions& options) {
  return options.shading.value_or(options.mode == RenderMode::composite ||
                                  options.mode == RenderMode::isosurface);
}

std::vector<IsoSurface> drawn_surfaces(const RenderOptions& options) {
  if (options.surfaces.empty()) return {{options.iso_value, 1, {}}};
  std::vector<IsoSurface> out;
  for (const IsoSurface& s : options.surfaces)
    if (s.opacity != 0) out.push_back(s);
  return out;
}

} // namespace bccsplat

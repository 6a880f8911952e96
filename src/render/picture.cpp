// SPDX-License-Identifier: Apache-2.0
// Draws a picture: chooses the slice's level, sheet distance, gradient, kernel form and raising by the
// quality asked for, makes the table of the transfer function, and has the splatter draw, with a trail or
// without.
#include "render/picture.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <functional>
#include <limits>

#include "base/error.h"
#include "base/grid.h"
#include "render/deep.h"
#include "render/edge_smoother.h"
#include "render/gradient_noise.h"
#include "render/reference.h"
#include "splat/loop/loops.h"
#include "splat/plan/sheet_metric.h"
#include "splat/rays/rays.h"
#include "splat/trail/trail.h"

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

// Returns whether corrections are in any of the sheets; coarser levels have none.
bool corrected(const Scene& scene, const Slice& drawn) {
  if (drawn.corrections) return true;
  return scene.trail && std::any_of(scene.trail->sources.begin(), scene.trail->sources.end(),
                                    [](const TrailSource& s) { return s.slice.corrections != nullptr; });
}

// Returns whether a mask of missing samples is in any of the sheets. Coarser levels have it, too, but their
// sheets are as far from each other as without it.
bool masked(const Scene& scene, const Slice& drawn) {
  if (&drawn != scene.slice) return false;
  if (drawn.mask) return true;
  return scene.trail && std::any_of(scene.trail->sources.begin(), scene.trail->sources.end(),
                                    [](const TrailSource& s) { return s.slice.mask != nullptr; });
}

// Returns the source samples per lattice unit across the sheets, at least 1, where corrections or masks are
// drawn: they are as fine as the source, however coarse the lattice.
double samples_per_unit(const Scene& scene, const Slice& drawn, int width, int height) {
  if (!corrected(scene, drawn) && !masked(scene, drawn)) return 1;
  const SheetView view = make_view(drawn, resolve_camera(scene.camera), width, height, 1);
  return std::max(1.0, length(drawn.lattice_to_slice.vector(view.normal)));
}

// Pixels per side of an image: the number of any pixel fits 32 bits (SurfaceHit).
constexpr int most_pixels = 65536;

// Pixels per unit: from as near as this their differences drown in the rounding of floats.
constexpr double analytic_above = 4096;

KernelForm kernel_form(const SplatOptions& o, const QualitySettings& quality, double step) {
  if (o.mode == RenderMode::composite && o.shading && step >= quality.flat_kernel)
    return KernelForm::flat_form;
  // Unshaded pictures converge faster, so that what shading hides shows one step earlier.
  return step >= (o.shading ? 1 : 2) * quality.short_kernel ? KernelForm::short_form : KernelForm::exact;
}

// Steps as small as a ring of sheets holds.
double finest_step(double radius) { return 2 * radius / max_ring_sheets; }

// Returns whether segments are classified by integrals: where the transfer function is narrower than the
// change of the field from sheet to sheet, in any direction.
bool needs_integrals(const SplatScene& scene, const TransferFunction& function, Preintegrate choice) {
  if (choice != Preintegrate::automatic) return choice == Preintegrate::on;
  const double change = scene.view->step * change_per_unit(*scene.slice, *scene.points);
  return narrowness(function, *scene.table, change, scene.view->step_world) >= narrow_function;
}

// Adds them to the tables of a trail where one of its functions asks for them. The change from sheet to sheet
// is taken from the slice, of which the trail is the past.
void add_integrals(const Scene& scene, const SplatScene& slice, Preintegrate choice,
                   std::vector<ClassTable>& tables) {
  bool needed = false;
  for (size_t n = 0; n < tables.size() && !needed; ++n) {
    SplatScene of = slice;
    of.table = &tables[n];
    needed = needs_integrals(of, scene.trail_functions[n], choice);
  }
  if (!needed) return;
  for (size_t n = 0; n < tables.size(); ++n)
    tables[n].integrals = integrate_values(scene.trail_functions[n], tables[n]);
}

// What of a scene is drawn, and in which steps.
struct Drawn {
  int level;
  const Slice* slice;
  const SplatPoints* points; // null: to be made
  double step;               // T of the slice
};

Drawn drawn_slice(const Scene& scene, const RenderOptions& options, const Context& context,
                  const Image& image) {
  Drawn d{drawn_level(scene, options, image.width, image.height), scene.slice, scene.points, 0};
  if (d.level > 0) {
    const CoarseLevels::Level& coarse = scene.levels->level(*scene.slice, d.level, context);
    d.slice = &coarse.slice, d.points = &coarse.points;
  }
  // The step is in lattice units of the slice that is drawn. A step asked for stays the same length, down to
  // what the smoother field can show.
  constexpr double finest_coarse_step = 1.0 / 16;
  d.step = options.sheet_step > 0 ? options.sheet_step : quality_settings(options.quality).sheet_step;
  if (options.sheet_step > 0 && d.level > 0)
    d.step = std::max(std::ldexp(d.step, -d.level), finest_coarse_step);
  if (options.sheet_step == 0) d.step /= samples_per_unit(scene, *d.slice, image.width, image.height);
  d.step = std::max(d.step, finest_step(d.slice->kernel.space.radius));
  return d;
}

// The splatter's options that follow from those of the picture.
SplatOptions splat_options(const Scene& scene, const RenderOptions& options, const Drawn& drawn,
                           const SheetView& view, const Image& image) {
  const QualitySettings quality = quality_settings(options.quality);
  SplatOptions o;
  o.mode = options.mode;
  o.shading = shaded(options);
  const double pixels = pixels_per_unit(view);
  o.gradient = options.gradient.value_or(pixels < quality.analytic_below || pixels > analytic_above
                                             ? GradientMethod::analytic
                                             : GradientMethod::fourth_order);
  // The analytic sums know nothing of the lattice sum that such kernels divide by, nor of corrections.
  if ((scene.slice->kernel.normalised || corrected(scene, *drawn.slice)) &&
      o.gradient == GradientMethod::analytic)
    o.gradient = GradientMethod::fourth_order;
  o.kernel_form = options.kernel_form.value_or(kernel_form(o, quality, drawn.step));
  o.raise = options.raise.value_or(o.mode == RenderMode::isosurface               ? quality.raise_surface
                                   : o.mode == RenderMode::composite && o.shading ? quality.raise
                                                                                  : quality.raise_unshaded);
  o.without_ripple = options.without_ripple && o.shading;
  if (o.mode == RenderMode::isosurface) o.surfaces = drawn_surfaces(options);
  o.opacity_stop = options.opacity_stop;
  o.disable_skips = options.disable_skips;
  o.tile_size = options.tile_size;
  o.rays = options.rays;
  o.with_value = image.value.pixels, o.with_time = image.time.pixels;
  o.with_deep = image.deep, o.deep_tolerance = options.deep_tolerance;
  return o;
}

// Returns the table of a transfer function over values `bounds`, in the units of the scene's own slice.
ClassTable table_of(const Scene& scene, const TransferFunction& function, const std::array<double, 2>& bounds,
                    float base, int entries) {
  const double unit = function.unit_distance > 0 ? function.unit_distance : mean_voxel(*scene.slice);
  return make_class_table(function, bounds[0], bounds[1], base, unit, entries);
}

// Draws the scene's slice, which `of_slice` is, with its trail.
void draw_with_trail(const Scene& scene, const SplatScene& of_slice, const RenderOptions& options,
                     SplatOptions& o, const Context& context,
                     const std::function<void(const TilePixels&)>& emit, RenderStats& stats) {
  const Trail& trail = *scene.trail;
  const int entries = quality_settings(options.quality).table_entries;
  std::vector<ClassTable> tables;
  for (const TransferFunction& f : scene.trail_functions)
    tables.push_back(table_of(scene, f, trail.bounds, scene.slice->base, entries));
  add_integrals(scene, of_slice, options.preintegrate, tables);
  for (const ClassTable& t : tables) o.preintegrate = o.preintegrate || !t.integrals.empty();
  std::vector<SplatScene> sources;
  std::deque<SheetView> moved; // of sources with a domain of their own
  for (const TrailSource& source : trail.sources) {
    const SheetView* of_source = of_slice.view;
    if (!same_place(*scene.slice, source.slice))
      of_source = &moved.emplace_back(move_view(*of_slice.view, *scene.slice, source.slice));
    sources.push_back(
        {&source.slice, &source.points, of_source, &tables.front(), of_slice.lights, of_slice.sums});
    stats.points_total += source.points.count;
  }
  std::vector<TrailStill> stills;
  for (const TrailMoment& m : trail.moments)
    stills.push_back({m.shares, &tables[std::min(static_cast<size_t>(m.interval), tables.size() - 1)],
                      static_cast<float>(m.weight), m.frame});
  stats.drawn = splat_with_trail(of_slice, sources, stills, scene.combine, o, context, emit);
}

RenderStats splat_picture(const Scene& scene, const RenderOptions& options, const Context& context,
                          Image& image) {
  const Drawn drawn = drawn_slice(scene, options, context, image);
  const Slice* slice = drawn.slice;
  const SheetView view =
      make_view(*slice, resolve_camera(scene.camera), image.width, image.height, drawn.step);
  ClassTable table = table_of(scene, scene.function, slice->bounds, slice->base,
                              quality_settings(options.quality).table_entries);
  SplatOptions o = splat_options(scene, options, drawn, view, image);
  DeepCollector deep(context.memory);
  Lights lights = scene.lights;
  // The volume's own voxels count at every level, so that levels are lit alike.
  if (scene.noise_of_ripple)
    lights.noise.of_value =
        ripple_noise(*slice, o.mode, o.kernel_form, o.without_ripple) / mean_voxel(*scene.slice);
  const bool with_trail = scene.trail && !scene.trail->moments.empty();
  const bool by_rays = !scene.trail && rays_cover(*slice, view, o);
  const SplatPoints* points = by_rays ? nullptr : drawn.points;
  SplatPoints made;
  if (!points && !by_rays) {
    made = make_points(*slice, context);
    points = &made;
  }
  KeptLatticeSums of_picture; // shared by surfaces and their edges
  const SplatScene s{.slice = slice,
                     .points = points,
                     .view = &view,
                     .table = &table,
                     .lights = &lights,
                     .sums = scene.sums ? scene.sums : &of_picture,
                     .cells = scene.cells};
  if (o.mode == RenderMode::composite && needs_integrals(s, scene.function, options.preintegrate))
    table.integrals = integrate_values(scene.function, table);
  o.preintegrate = !table.integrals.empty();
  // Trails end at the pixel centre's surface and deep samples have one depth: neither has edges to be
  // smoothed.
  EdgeSmoother edges(options.smooth_edges && !with_trail && !image.deep, context, image, o);
  const auto emit = [&](const TilePixels& tile) {
    write_tile(tile, view, image);
    edges.add(tile);
    if (tile.deep) deep.add(tile, view, context.progress);
  };
  RenderStats stats;
  // Pictures by rays count the sites, without mirror images.
  stats.points_total = points ? points->count : static_cast<uint64_t>(slice->points());
  if (with_trail) {
    draw_with_trail(scene, s, options, o, context, emit, stats);
  } else {
    stats.drawn = by_rays ? draw_rays(s, o, context, emit)
                          : splat(s, o, context, emit, points == &made ? nullptr : scene.kept);
    const EdgeStats smoothed = edges.smooth(s, o, context);
    stats.edge_pixels = smoothed.pixels;
    stats.drawn.ms_shade += smoothed.ms;
  }
  if (image.deep) *image.deep = deep.collect(image.width, image.height, context.progress);

  stats.sheet_step = std::ldexp(drawn.step, drawn.level);
  stats.level = drawn.level;
  stats.preintegrated = o.preintegrate;
  return stats;
}

} // namespace

int drawn_level(const Scene& scene, const RenderOptions& options, int width, int height) {
  // A trail is on the lattice of its slice, and the mean of a maximum is not the maximum of a mean.
  if (!scene.levels || scene.trail || options.reference || options.mode == RenderMode::maximum ||
      (options.disable_skips & skip_fine_detail))
    return 0;
  if (!quality_settings(options.quality).coarse_levels && options.mode != RenderMode::xray) return 0;
  return minification_level(*scene.slice, scene.camera, width, height);
}

double pixels_per_unit(const SheetView& view) {
  return 1 / (view.scale(0) * SheetMetric(view).extremes()[1]);
}

double mean_voxel(const Slice& slice) { return std::cbrt(std::fabs(slice.slice_to_world.determinant())); }

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

namespace {

RenderStats reference_picture(const Scene& scene, const RenderOptions& options, const Context& context,
                              Image& image) {
  const auto sums =
      options.without_ripple && shaded(options) ? lattice_sums(*scene.slice, scene.sums) : nullptr;
  Scene lit = scene;
  if (scene.noise_of_ripple)
    lit.lights.noise.of_value =
        ripple_noise(*scene.slice, options.mode, KernelForm::flat_form, sums != nullptr) /
        mean_voxel(*scene.slice);
  return render_reference(lit, options, slice_field(*scene.slice, sums),
                          options.mode == RenderMode::composite
                              ? ReferenceOptions{reference_step(scene.function, scene.slice->bounds)}
                              : ReferenceOptions{},
                          context, image);
}

} // namespace

bool drawn_by_rays(const Scene& scene, const RenderOptions& options, const Context& context,
                   const Image& image) {
  if (scene.trail || options.reference || options.mode != RenderMode::isosurface) return false;
  const Drawn drawn = drawn_slice(scene, options, context, image);
  const SheetView view =
      make_view(*drawn.slice, resolve_camera(scene.camera), image.width, image.height, drawn.step);
  return rays_cover(*drawn.slice, view, splat_options(scene, options, drawn, view, image));
}

void check_picture(const Scene& scene, const RenderOptions& options, const Context& context,
                   const Image& image) {
  check_options(scene, options, image);
  if (options.reference) return;
  const Drawn drawn = drawn_slice(scene, options, context, image);
  const SheetView view =
      make_view(*drawn.slice, resolve_camera(scene.camera), image.width, image.height, drawn.step);
  (void)sheet_range(*drawn.slice, view);
}

RenderStats render(const Scene& scene, const RenderOptions& options, const Context& context, Image& image) {
  check_options(scene, options, image);
  const auto start = std::chrono::steady_clock::now();
  RenderStats stats;
  if (options.reference)
    stats = reference_picture(scene, options, context, image);
  else
    stats = splat_picture(scene, options, context, image);
  stats.threads = context.tasks.threads();
  stats.ms_total =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return stats;
}

} // namespace bccsplat

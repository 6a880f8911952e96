// SPDX-License-Identifier: Apache-2.0
// A picture of a slice.
#pragma once

#include <optional>
#include <vector>

#include "base/context.h"
#include "field/slice.h"
#include "render/camera.h"
#include "render/image.h"
#include "render/minify.h"
#include "render/preintegrate.h"
#include "render/quality.h"
#include "render/trail.h"
#include "render/transfer_function.h"
#include "splat/rays/surface_cells.h"
#include "splat/splat.h"
#include "splat/tile/kept_sheets.h"

namespace bccsplat {

// One more bit of disable_skips: detail finer than half a pixel, by a coarser level of the slice.
inline constexpr uint32_t skip_fine_detail = 16;

// A quarter of a step of 8 bits.
inline constexpr double default_deep_tolerance = 0.001;

struct RenderOptions {
  RenderMode mode = RenderMode::composite;
  Quality quality = Quality::normal;
  std::optional<bool> shading;            // none: on for composite and isosurface
  double sheet_step = 0;                  // T; 0: by quality
  std::optional<GradientMethod> gradient; // none: by quality
  std::optional<KernelForm> kernel_form;  // none: by quality, shading and sheet_step
  double iso_value = 0;
  std::vector<IsoSurface> surfaces;                    // of mode isosurface; empty: one, opaque, at iso_value
  double opacity_stop = default_opacity_stop;          // 1: never
  uint32_t disable_skips = 0;                          // SkipBits, skip_fine_detail
  int tile_size = 0;                                   // pixels; 0: chosen
  Preintegrate preintegrate = Preintegrate::automatic; // of mode composite and trails
  std::optional<RaiseFilter> raise;                    // none: by quality
  // Surfaces, maxima, analytic gradients and references are lit without that of the kernel.
  bool without_ripple = true;
  bool rays = true;                               // isosurfaces without sheets, where they can (rays.h)
  bool reference = false;                         // render/reference.h instead of the splatter
  double deep_tolerance = default_deep_tolerance; // of deep pictures, see DeepTile
  // Takes four samples of edge pixels, in isosurfaces without a trail that are not deep. Pictures are
  // compared sample by sample without.
  bool smooth_edges = false;
};

struct Scene {
  const Slice* slice = nullptr;
  const SplatPoints* points = nullptr;  // of the slice; null: made for this picture
  const CoarseLevels* levels = nullptr; // of the slice; null: it is drawn itself at any size
  Camera camera;
  TransferFunction function;
  Lights lights;
  bool noise_of_ripple = false; // beside that of the lights: what the kernel's ripple makes of gradients
  const Trail* trail = nullptr; // null: none
  std::vector<TransferFunction> trail_functions; // of its sub-intervals, or one for all
  TrailCombine combine = TrailCombine::physical;
  // Sheets of earlier pictures of this slice and these points; null: none are kept.
  KeptSheets* kept = nullptr;
  // What the kernel makes of a constant, as earlier pictures looked it up; null: it is worked out anew.
  KeptLatticeSums* sums = nullptr;
  // The cells that rays look at, of earlier pictures of this slice and its levels; null: none are kept.
  KeptSurfaceCells* cells = nullptr;
};

struct RenderStats {
  SplatStats drawn; // of the points; zero from the reference integrator
  uint64_t points_total = 0;
  int threads = 0;
  double ms_total = 0;   // wall
  double sheet_step = 0; // T
  int level = 0;         // of the slice that was drawn; 0: the scene's own
  bool preintegrated = false;
  uint64_t edge_pixels = 0; // that were smoothed
};

// Returns the pixels per lattice unit at the centre of the domain, in the direction in which pixels are
// largest.
[[nodiscard]] double pixels_per_unit(const SheetView& view);

// Returns the level of the slice that render() draws; above 0 it does not need the scene's points.
[[nodiscard]] int drawn_level(const Scene& scene, const RenderOptions& options, int width, int height);

// Returns whether render() draws by rays, for which the scene needs no points.
[[nodiscard]] bool drawn_by_rays(const Scene& scene, const RenderOptions& options, const Context& context,
                                 const Image& image);

// Refuses what render() would refuse before it draws anything.
void check_picture(const Scene& scene, const RenderOptions& options, const Context& context,
                   const Image& image);

// Draws into every plane the image has. Throws invalid_argument, unsupported (a mode that cannot be shaded),
// cancelled, memory_budget.
RenderStats render(const Scene& scene, const RenderOptions& options, const Context& context, Image& image);

// Returns the world length of one mean voxel of the slice's source, the default unit distance.
[[nodiscard]] double mean_voxel(const Slice& slice);

// Returns the isosurfaces that are there: those that are not wholly transparent.
[[nodiscard]] std::vector<IsoSurface> drawn_surfaces(const RenderOptions& options);

// Both ways of drawing share these checks and defaults.
void check_options(const Scene& scene, const RenderOptions& options, const Image& image);
[[nodiscard]] bool shaded(const RenderOptions& options);

} // namespace bccsplat

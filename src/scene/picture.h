// SPDX-License-Identifier: Apache-2.0
// A picture of a slice.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/context.h"
#include "draw/image.h"
#include "draw/shot.h"
#include "field/slice.h"
#include "reference/reference.h"
#include "scene/drawers.h"
#include "scene/minify.h"
#include "scene/trail.h"
#include "splat/sheet_settings.h"
#include "view/camera.h"

namespace bccsplat {

// A quarter of a step of 8 bits.
inline constexpr double default_deep_tolerance = 0.001;

struct RenderOptions : SheetWishes {
  RenderMode mode = RenderMode::composite;
  Quality quality = Quality::normal;
  std::optional<bool> shading; // none: on for composite and isosurface
  double sheet_step = 0;       // T; 0: by quality
  double iso_value = 0;
  std::vector<IsoSurface> surfaces;                    // of mode isosurface; empty: one, opaque, at iso_value
  double opacity_stop = default_opacity_stop;          // 1: never
  uint32_t disable_skips = 0;                          // SkipBits
  int tile_size = 0;                                   // pixels; 0: chosen
  Preintegrate preintegrate = Preintegrate::automatic; // of mode composite and trails
  // Surfaces, maxima, analytic gradients and references are lit without that of the kernel.
  bool without_ripple = true;
  bool rays = true;                               // isosurfaces without sheets, where they can (rays.h)
  bool reference = false;                         // reference/reference.h instead of a drawer
  double deep_tolerance = default_deep_tolerance; // of deep pictures, see DeepTile
  double depth_opacity = 0.5;                     // of the plane of depths, where no surface is; (0, 1]
  // Takes four samples of edge pixels, in isosurfaces without a trail that are not deep. Pictures are
  // compared sample by sample without.
  bool smooth_edges = false;
  Backend backend = Backend::cpu;
  std::shared_ptr<GpuDevice> gpu; // that it may be drawn by
  // A texture in the GPU's context that the picture goes to, and nowhere else: the image needs no planes.
  const GpuTarget* target = nullptr;

  bool operator==(const RenderOptions&) const = default;
};

// A slice of another channel at the same moment, whose values say the colours.
struct ScenePaint {
  const Slice* slice = nullptr;
  const KeptPoints* points = nullptr;   // as of a scene
  const CoarseLevels* levels = nullptr; // as of a scene
  TransferFunction function;            // its colours; the opacities are not looked at
};

struct Scene {
  const Slice* slice = nullptr;
  const KeptPoints* points = nullptr;   // of the slice; null: made for this picture
  const CoarseLevels* levels = nullptr; // of the slice; null: it is drawn itself at any size
  Camera camera;
  std::optional<Sight> sight; // instead of the camera
  TransferFunction function;
  Lights lights;
  bool noise_of_ripple = false; // beside that of the lights: what the kernel's ripple makes of gradients
  const Trail* trail = nullptr; // null: none
  std::vector<TransferFunction> trail_functions; // of its sub-intervals, or one for all
  TrailCombine combine = TrailCombine::physical;
  bool trail_unlit = false; // whatever the slice is
  std::optional<ScenePaint>
      paint; // of modes composite and isosurface, without a trail; none: its own colours
  // What earlier pictures of this slice and its levels made; null: nothing is kept.
  Drawers* drawers = nullptr;
};

// What a picture of this size sees.
[[nodiscard]] Sight sight_of(const Scene& scene, int width, int height);

class SettledPicture; // settled_picture.h

struct RenderStats {
  DrawStats drawn; // of the points; zero from the reference integrator
  int threads = 0;
  double ms_total = 0;      // wall
  double sheet_step = 0;    // T
  int level = 0;            // of the slice that was drawn; 0: the scene's own
  uint64_t edge_pixels = 0; // that were smoothed
  const char* drawer = "";
  std::string gpu_failed; // why the CPU drew what the GPU had begun; empty: it did not
};

// A picture that is settled: its level, its view, what it is drawn by. Scene, options, context and image
// outlive it.
class Picture {
 public:
  // Settles all, and makes what is kept with the slice; the image stays as it is. Throws invalid_argument,
  // unsupported (a mode that cannot be shaded), cancelled, memory_budget.
  Picture(const Scene& scene, const RenderOptions& options, const Context& context, Image& image);
  ~Picture();

  // Returns the name of what draws it: "sheets", "rays", "gpu" or "reference".
  [[nodiscard]] const char* drawer() const;
  // Draws into every plane the image has. Once. Throws cancelled, memory_budget.
  RenderStats draw();
  // Draws by the reference another field than the slice's.
  RenderStats draw_truth(const FieldAt& field, const ReferenceOptions& reference);

 private:
  const RenderOptions& options_;
  int threads_;
  std::unique_ptr<SettledPicture> settled_;
};

// Throws what Picture does where a picture cannot be drawn whatever is seen.
void check_picture(const Scene& scene, const RenderOptions& options, const Image& image);

// Settles and draws.
RenderStats render(const Scene& scene, const RenderOptions& options, const Context& context, Image& image);

// Settles, and draws by the slow truth (reference/reference.h). `field` need not be the slice's: an analytic
// field in the slice's domain gives the error against the original.
RenderStats render_reference(const Scene& scene, const RenderOptions& options, const FieldAt& field,
                             const ReferenceOptions& reference, const Context& context, Image& image);

// Returns whether samples are lit: as asked, or by the mode. What is one sample thick has no surfaces: its
// gradients lie in it.
[[nodiscard]] bool shaded(const RenderOptions& options, const Slice& slice);

// Returns whether the volume stands in the way of its own light: lit composites, where the lights ask for it.
[[nodiscard]] bool casts_shadows(const Scene& scene, const RenderOptions& options);

// Returns the isosurfaces that are there: those that are not wholly transparent.
[[nodiscard]] std::vector<IsoSurface> drawn_surfaces(const RenderOptions& options);

} // namespace bccsplat

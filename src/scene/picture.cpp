// SPDX-License-Identifier: Apache-2.0
// Checks what a picture is asked for, has it settled (settled_picture.h), and drawn.
#include "scene/picture.h"

#include <cmath>

#include "base/error.h"
#include "draw/stage_clock.h"
#include "scene/settled_picture.h"

namespace bccsplat {
namespace {

// Pixels per side of an image: the number of any pixel fits 32 bits (SurfaceHit).
constexpr int most_pixels = 65536;

} // namespace

void check_picture(const Scene& scene, const RenderOptions& options, const Image& image) {
  if (scene.trail && options.reference)
    fail(Code::unsupported, "render: the reference integrator draws no trails");
  if (scene.trail && (options.mode == RenderMode::xray || options.mode == RenderMode::maximum))
    fail(Code::unsupported, "render: a trail goes with modes composite and isosurface");
  if (scene.trail && scene.trail_functions.empty())
    fail(Code::invalid_argument, "render: the trail has no transfer function");
  for (const TransferFunction& f : scene.trail_functions) f.check();
  if (scene.trail && options.mode == RenderMode::isosurface && sees_through(drawn_surfaces(options)))
    fail(Code::unsupported, "render: a trail goes with isosurfaces that are opaque");

  if (scene.paint && (options.mode == RenderMode::xray || options.mode == RenderMode::maximum))
    fail(Code::unsupported, "render: colours by another channel go with modes composite and isosurface; ",
         options.mode == RenderMode::xray ? "an X-ray has none" : "a maximum has those of its value");
  if (scene.paint && scene.trail)
    fail(Code::unsupported, "render: a trail has no colours by another channel");
  if (scene.paint && options.reference)
    fail(Code::unsupported, "render: the reference integrator has no colours by another channel");
  if (scene.paint) scene.paint->function.check();
  if (casts_shadows(scene, options) && (scene.trail || options.reference))
    fail(Code::unsupported, "render: shadow and ambient occlusion are not drawn ",
         scene.trail ? "with a trail" : "by the reference integrator");
  if (image.deep) {
    if (options.mode == RenderMode::xray || options.mode == RenderMode::maximum)
      fail(Code::unsupported, "render: deep pictures are of modes composite and isosurface");
    if (options.reference) fail(Code::unsupported, "render: the reference integrator draws no deep pictures");
  }
  if (image.deep && image.depth.pixels && options.opacity_stop == 1 && options.depth_opacity > 0.5)
    fail(Code::unsupported,
         "render: depths beside deep samples that never end are those of opacities up to 1/2");
  if (!(options.deep_tolerance >= 0 && options.deep_tolerance <= 1))
    fail(Code::invalid_argument, "render: deep_tolerance ", options.deep_tolerance, " is outside [0, 1]");
  if (!scene.slice) fail(Code::wrong_state, "render: no slice is set");
  if (image.width < 1 || image.height < 1 || image.width > most_pixels || image.height > most_pixels ||
      !(image.rgba.pixels || options.target))
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
  if (options.mode == RenderMode::xray && shaded(options, *scene.slice))
    fail(Code::unsupported, "render: an X-ray has no surface to shade; turn shading off");
  for (const Light& light : scene.lights.lights)
    for (size_t a = 0; a < 3; ++a)
      if (!std::isfinite(light.direction[a]) || !std::isfinite(light.color[a]))
        fail(Code::invalid_argument, "render: lights must be finite");
  scene.function.check();
}

Picture::Picture(const Scene& scene, const RenderOptions& options, const Context& context, Image& image)
    : options_(options), threads_(context.tasks.threads()) {
  check_picture(scene, options, image);
  settled_ = std::make_unique<SettledPicture>(scene, options, context, image);
  if (options.reference) return;
  settled_->settle_level();
  settled_->settle_view();
  settled_->settle_look();
  settled_->settle_paint();
  settled_->settle_light();
  settled_->settle_trail();
  settled_->settle_drawer();
}

Picture::~Picture() = default;

const char* Picture::drawer() const { return settled_->drawer(); }

RenderStats Picture::draw() {
  RenderStats stats = options_.reference ? settled_->draw_truth(nullptr, nullptr) : settled_->draw();
  stats.threads = threads_;
  stats.ms_total = ms_since(settled_->begin);
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

bool casts_shadows(const Scene& scene, const RenderOptions& options) {
  return (scene.lights.shadow || scene.lights.occlusion) && options.mode == RenderMode::composite &&
         scene.slice && shaded(options, *scene.slice);
}

bool shaded(const RenderOptions& options, const Slice& slice) {
  if (options.shading) return *options.shading;
  if (options.mode == RenderMode::composite) return !one_sample_thick(slice);
  return options.mode == RenderMode::isosurface;
}

std::vector<IsoSurface> drawn_surfaces(const RenderOptions& options) {
  if (options.surfaces.empty()) return {{options.iso_value, 1, {}}};
  std::vector<IsoSurface> out;
  for (const IsoSurface& s : options.surfaces)
    if (s.opacity != 0) out.push_back(s);
  return out;
}

} // namespace bccsplat

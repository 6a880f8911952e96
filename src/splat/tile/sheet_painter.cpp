// SPDX-License-Identifier: Apache-2.0
#include "splat/tile/sheet_painter.h"

#include <algorithm>

#include "shade/light_volume.h"

namespace bccsplat {
namespace {

// Planes in their order; those of the lights follow.
enum Plane : size_t { red_plane, green_plane, blue_plane, label_plane, ambient_plane, light_planes };

} // namespace

size_t paint_planes(const SplatScene& scene) {
  if (!scene.paint && !scene.light && !scene.slice->labels) return 0;
  return light_planes + (scene.light ? scene.light->lights() : 0);
}

template<class Body> void SheetPainter::each_pixel(const Body& body) const {
  const PixelRect seen = s_.tile.seen.within(s_.tile.width, s_.tile.height);
  for (int y = seen.y0; y < seen.y1; ++y)
    for (int x = seen.x0; x < seen.x1; ++x) {
      const size_t p = s_.tile.pixel(x, y);
      if (s_.pixel.alpha[p] < s_.classes.stop && segment_weight(s_, p) > 0) body(x, y, p);
    }
}

void SheetPainter::color(const SplatScene& paint, const float* values) const {
  const ClassTable& table = *paint.table;
  float *const red = plane(red_plane), *const green = plane(green_plane), *const blue = plane(blue_plane);
  const SliceLabels* const labels = paint.slice->labels.get();
  const Affine3& to_slice = paint.slice->lattice_to_slice;
  each_pixel([&](int x, int y, size_t p) {
    const float value = labels
                            ? labels->at(to_slice.point(paint.view->sample(s_.tile.x + x, s_.tile.y + y, k_)))
                            : paint.slice->base + values[s_.tile.sample(x, y)];
    const auto& color = table.entry[static_cast<size_t>(table.index(value))];
    red[p] = color[0], green[p] = color[1], blue[p] = color[2];
  });
  s_.paint.red = red, s_.paint.green = green, s_.paint.blue = blue;
}

void SheetPainter::labels(const SplatScene& scene) const {
  const SliceLabels& labels = *scene.slice->labels;
  const Affine3& to_slice = scene.slice->lattice_to_slice;
  float* const out = plane(label_plane);
  each_pixel([&](int x, int y, size_t p) {
    out[p] = labels.at(to_slice.point(scene.view->sample(s_.tile.x + x, s_.tile.y + y, k_)));
  });
  s_.paint.value = out;
}

void SheetPainter::light(const SplatScene& scene) const {
  const LightVolume& volume = *scene.light;
  float *const ambient = plane(ambient_plane), *const lights = plane(light_planes);
  each_pixel([&](int x, int y, size_t p) {
    const Vec3 at = scene.view->sample(s_.tile.x + x, s_.tile.y + y, k_);
    if (volume.has_ambient()) ambient[p] = volume.ambient(at);
    for (size_t n = 0; n < volume.lights(); ++n) lights[n * pixels_ + p] = volume.light(n, at);
  });
  if (volume.has_ambient()) s_.paint.ambient = ambient;
  if (volume.lights() > 0) s_.paint.lights = lights, s_.paint.light_floats = pixels_;
}

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
#include "splat/tile/tile_finish.h"

#include <limits>
#include <vector>

#include "shade/absorption.h"

namespace bccsplat {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float nan_value = std::numeric_limits<float>::quiet_NaN();

template<class Body> void each_pixel(const FinishedPixels& of, const Body& body) {
  for (int y = 0; y < of.tile.height; ++y)
    for (int x = 0; x < of.tile.width; ++x) body(x, y, plane_index(x, y, of.pitch));
}

// Returns the gradients in world space where the largest values of a row's pixels are, computed together.
std::vector<Vec3> maximum_gradients(const FinishedPixels& of, const SurfaceField& field, int y) {
  const SheetView& view = *of.scene.view;
  std::vector<int> at;
  std::vector<Vec3> positions;
  for (int x = 0; x < of.tile.width; ++x) {
    const size_t p = plane_index(x, y, of.pitch);
    if (!(of.pixel.red[p] > -infinity)) continue;
    at.push_back(x);
    positions.push_back(view.sample(of.tile.x + x, of.tile.y + y, of.pixel.depth[p]));
  }
  std::vector<float> values(positions.size());
  std::vector<Vec3> found(positions.size()), gradients(of.tile.width);
  field_at(field, positions, values, found);
  const Affine3 to_lattice = view.lattice_to_world.inverse();
  for (size_t n = 0; n < at.size(); ++n)
    gradients[at[n]] = to_lattice.transposed(field.lit_gradient(positions[n], values[n], found[n]));
  return gradients;
}

void finish_largest(const FinishedPixels& of, const TimeField& time, size_t p, int i, int j,
                    const Vec3& gradient) {
  const PixelPlanes& pixel = of.pixel;
  const SplatScene& scene = of.scene;
  const float value = pixel.red[p], k = pixel.depth[p];
  pixel.red[p] = 0, pixel.depth[p] = infinity;
  if (!(value > -infinity)) {
    if (pixel.value) pixel.value[p] = nan_value;
    if (pixel.time) pixel.time[p] = nan_value;
    return;
  }
  const auto& entry = scene.table->entry[scene.table->index(value)];
  const float alpha = absorbed(entry[3] * scene.table->unit_distance);
  Shading lit{{1, 1, 1}, {}};
  if (of.options.shading)
    lit = shade(*scene.lights, gradient, to_viewer(*scene.view, i, j), value - scene.slice->base);
  const std::array<float, 3> seen = lit_color(entry, lit);
  pixel.red[p] = alpha * seen[0], pixel.green[p] = alpha * seen[1], pixel.blue[p] = alpha * seen[2];
  pixel.alpha[p] = alpha;
  if (alpha >= of.options.depth_opacity) pixel.depth[p] = k;
  if (pixel.value) pixel.value[p] = value;
  if (pixel.time) pixel.time[p] = static_cast<float>(time.at(scene.view->sample(i, j, k)));
}

} // namespace

void add_behind(const FinishedPixels& of, const TileFront& front, float stop, DeepTile* deep) {
  const PixelPlanes& pixel = of.pixel;
  const TilePixels& seen = *front.pixels;
  each_pixel(of, [&](int x, int y, size_t p) {
    if (!(front.at(x, y) < infinity && pixel.alpha[p] < stop)) return;
    const size_t at = front.pixel(x, y);
    const float open = 1 - pixel.alpha[p];
    pixel.red[p] += open * seen.red[at], pixel.green[p] += open * seen.green[at];
    pixel.blue[p] += open * seen.blue[at];
    if (pixel.value) pixel.value[p] += open * seen.value[at];
    if (pixel.time) pixel.time[p] += open * seen.time[at];
    if (pixel.alpha[p] < of.options.depth_opacity) pixel.depth[p] = seen.depth[at];
    pixel.alpha[p] = 1;
    if (deep) (void)deep->add_surface(pixel, p, seen.depth[at], 1);
  });
}

void finish_means(const FinishedPixels& of) {
  const PixelPlanes& pixel = of.pixel;
  if (!pixel.value && !pixel.time) return;
  each_pixel(of, [&](int, int, size_t p) {
    const float alpha = pixel.alpha[p];
    if (pixel.value) pixel.value[p] = alpha > 0 ? pixel.value[p] / alpha : nan_value;
    if (pixel.time) pixel.time[p] = alpha > 0 ? pixel.time[p] / alpha : nan_value;
  });
}

void finish_xray(const FinishedPixels& of) {
  const PixelPlanes& pixel = of.pixel;
  each_pixel(of, [&](int, int, size_t p) {
    const bool inside = pixel.enter[p] < pixel.leave[p];
    const float sum = pixel.red[p];
    pixel.green[p] = pixel.blue[p] = sum;
    if (pixel.value) pixel.value[p] = inside ? sum : nan_value;
    if (pixel.time) pixel.time[p] = pixel.alpha[p] > 0 ? pixel.time[p] / pixel.alpha[p] : nan_value;
    pixel.alpha[p] = inside ? 1.0f : 0.0f;
  });
}

void finish_maximum(const FinishedPixels& of, const SurfaceField& field) {
  const TimeField time(*of.scene.slice);
  for (int y = 0; y < of.tile.height; ++y) {
    const std::vector<Vec3> gradients =
        of.options.shading ? maximum_gradients(of, field, y) : std::vector<Vec3>();
    for (int x = 0; x < of.tile.width; ++x)
      finish_largest(of, time, plane_index(x, y, of.pitch), of.tile.x + x, of.tile.y + y,
                     gradients.empty() ? Vec3{} : gradients[x]);
  }
}

} // namespace bccsplat

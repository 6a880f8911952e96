// SPDX-License-Identifier: Apache-2.0
#include "gpu/trail_apart.h"

#include <algorithm>

namespace bccsplat {
namespace {

// Planes of a picture beside its colours, as GpuPixels has them.
enum Plane : uint8_t { depth, value, time, known };

// Lays a pixel before another: a is its opacity, b how much of the other is seen.
void lay_pixel(const Vec4f& front, const Vec4f& front_more, float open, Vec4f& color, Vec4f& more) {
  const float a = front[3], b = open * color[3], sum = a + b;
  for (size_t c = 0; c < color.size(); ++c) color[c] = front[c] + open * color[c];
  for (const size_t n : {value, time})
    if (sum > 0) more[n] = ((a > 0 ? a * front_more[n] : 0) + (b > 0 ? b * more[n] : 0)) / sum;
  more[known] = sum > 0 ? 1.0f : 0.0f;
}

} // namespace

std::vector<float> ends_at(const GpuPixels& surface, const SheetView& view, const std::vector<float>& ends) {
  constexpr float far = 1e30f;
  std::vector<float> out(surface.color.size(), far);
  for (size_t p = 0; p < out.size(); ++p) {
    if (surface.color[p][3] > 0)
      out[p] = static_cast<float>((surface.more[p][depth] + view.depth) * view.step_world);
    if (!ends.empty()) out[p] = std::min(out[p], ends[p]);
  }
  return out;
}

void add_surface(const GpuPixels& surface, const ShotOptions& options, GpuPixels& onto) {
  const float stop = options.opacity_stop < 1 ? static_cast<float>(options.opacity_stop) : 2.0f;
  onto.more.resize(onto.color.size());
  for (size_t p = 0; p < onto.color.size(); ++p) {
    Vec4f &color = onto.color[p], &more = onto.more[p];
    if (!(surface.color[p][3] > 0) || color[3] >= stop) continue;
    if (color[3] < options.depth_opacity) more[depth] = surface.more[p][depth];
    const Vec4f before = color, before_more = more;
    color = surface.color[p];
    color[3] = 1;
    const float at = more[depth];
    more = surface.more[p], more[depth] = at;
    lay_pixel(before, before_more, 1 - before[3], color, more);
  }
}

} // namespace bccsplat

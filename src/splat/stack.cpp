#include "splat/stack.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bccsplat {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

// What one group holds at one sample: optical depth, and colour, value and time per optical depth.
struct Matter {
  float depth = 0;
  std::array<float, 5> content{}; // red, green, blue, value, time
};

Matter matter(const SheetStack& stack, int64_t k, size_t group, size_t p) {
  Matter m;
  const float* depth = stack.plane(k, group, SheetStack::depth);
  if (!depth || !(depth[p] > 0)) return m;
  m.depth = depth[p];
  constexpr size_t from[] = {SheetStack::red, SheetStack::green, SheetStack::blue, SheetStack::value,
                             SheetStack::time};
  for (size_t i = 0; i < 5; ++i) m.content[i] = stack.plane(k, group, from[i])[p] / m.depth;
  return m;
}

// Opacity and opacity-weighted content of a sheet in which both groups are.
struct Layer {
  float opacity = 0;
  std::array<float, 5> content{};
};

Layer join(const Matter& a, const Matter& b, TrailCombine combine) {
  Layer l;
  float wa, wb; // shares of the content, summing to the opacity
  if (combine == TrailCombine::interleaved) {
    wa = absorbed(a.depth) / 2, wb = absorbed(b.depth) / 2;
  } else {
    const float sum = a.depth + b.depth;
    const float opacity = absorbed(combine == TrailCombine::interleaved_consistent ? sum / 2 : sum);
    wa = sum > 0 ? opacity * (a.depth / sum) : 0, wb = sum > 0 ? opacity * (b.depth / sum) : 0;
  }
  l.opacity = wa + wb;
  for (size_t i = 0; i < 5; ++i) l.content[i] = wa * a.content[i] + wb * b.content[i];
  return l;
}

struct Pixel {
  std::array<float, 5> content{};
  float alpha = 0, depth = infinity;

  void add(const Layer& l, float at, float thickness) {
    const float open = 1 - alpha;
    for (size_t i = 0; i < 5; ++i) content[i] += open * l.content[i];
    const float before = alpha;
    alpha += open * l.opacity;
    if (before < 0.5f && alpha >= 0.5f) {
      const float part =
          alpha < 1 ? std::log(0.5f / (1 - before)) / std::log((1 - alpha) / (1 - before)) : 0.0f;
      depth = at + part * thickness;
    }
  }
};

} // namespace

void SheetStack::prepare(int64_t first, int64_t last, size_t pixels) {
  first_ = first, pixels_ = pixels;
  const auto count = static_cast<size_t>(std::max<int64_t>(last - first + 1, 0));
  for (auto& sheets : sheets_) {
    sheets.resize(count);
    for (Sheet& s : sheets) s.used = false;
  }
}

const float* SheetStack::plane(int64_t k, size_t group, size_t quantity) const {
  const Sheet& s = sheets_[group][static_cast<size_t>(k - first_)];
  return s.used ? s.planes.data() + quantity * pixels_ : nullptr;
}

float* SheetStack::plane_to_add(int64_t k, size_t group, size_t quantity) {
  Sheet& s = sheets_[group][static_cast<size_t>(k - first_)];
  if (!s.used) {
    s.planes.reserve(quantities * pixels_);
    std::fill_n(s.planes.data(), quantities * pixels_, 0.0f);
    s.used = true;
  }
  return s.planes.data() + quantity * pixels_;
}

void add_sheet(const SheetArgs& s, float weight, SheetStack& stack, size_t group) {
  const auto k = static_cast<int64_t>(s.k);
  if (k < stack.first() || k > stack.last()) return;
  std::array<float*, SheetStack::quantities> out{};
  for (int y = 0; y < s.height; ++y)
    for (int x = 0; x < s.width; ++x) {
      const size_t p = static_cast<size_t>(y) * static_cast<size_t>(s.pitch) + static_cast<size_t>(x);
      if (s.hole && s.hole[p]) continue;
      const float value = s.air + s.value[static_cast<std::ptrdiff_t>(y) * s.plane_pitch + x];
      const auto& [red, green, blue, extinction] = s.table->entry[static_cast<size_t>(s.table->index(value))];
      const float depth = weight * extinction * slab_weight(s, p) * s.pixel.path[p];
      if (!(depth > 0)) continue;
      Shading lit{{1, 1, 1}, {}};
      if (s.shading)
        lit = shade(*s.lights, world_gradient(s, x, y),
                    {static_cast<double>(s.pixel.view_x[p]), static_cast<double>(s.pixel.view_y[p]),
                     static_cast<double>(s.pixel.view_z[p])});
      if (!out[0])
        for (size_t q = 0; q < SheetStack::quantities; ++q) out[q] = stack.plane_to_add(k, group, q);
      const auto light = [&](float color, size_t c) {
        return depth * (color * static_cast<float>(lit.scale[c]) + static_cast<float>(lit.highlight[c]));
      };
      out[SheetStack::red][p] += light(red, 0);
      out[SheetStack::green][p] += light(green, 1);
      out[SheetStack::blue][p] += light(blue, 2);
      out[SheetStack::depth][p] += depth;
      out[SheetStack::value][p] += depth * value;
      out[SheetStack::time][p] += depth * (s.time[0] + s.time[1] * static_cast<float>(s.x + x) +
                                           s.time[2] * static_cast<float>(s.y + y));
    }
}

void composite_stack(const SheetStack& stack, TrailCombine combine, const TilePixels* surface, float stop,
                     int width, int height, int pitch, const PixelPlanes& out) {
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const auto p = static_cast<size_t>(y) * static_cast<size_t>(pitch) + static_cast<size_t>(x);
      const auto hit_at =
          surface ? static_cast<size_t>(y) * static_cast<size_t>(surface->pitch) + static_cast<size_t>(x) : 0;
      const float hit = surface && surface->alpha[hit_at] > 0 ? surface->depth[hit_at] : infinity;
      Pixel pixel;
      for (int64_t k = stack.first(); k <= stack.last() && pixel.alpha < stop; ++k) {
        const float front = static_cast<float>(k) - 0.5f;
        if (front >= hit) break;
        Matter a = matter(stack, k, 0, p), b = matter(stack, k, 1, p);
        const float part = std::min(hit - front, 1.0f); // of the slab before the surface
        a.depth *= part, b.depth *= part;
        if (a.depth > 0 || b.depth > 0) pixel.add(join(a, b, combine), front, part);
      }
      if (hit < infinity && pixel.alpha < stop)
        pixel.add({1,
                   {surface->red[hit_at], surface->green[hit_at], surface->blue[hit_at],
                    surface->value ? surface->value[hit_at] : 0, surface->time ? surface->time[hit_at] : 0}},
                  hit, 0);
      out.red[p] = pixel.content[0], out.green[p] = pixel.content[1], out.blue[p] = pixel.content[2];
      out.alpha[p] = pixel.alpha, out.depth[p] = pixel.depth;
      constexpr float nan_value = std::numeric_limits<float>::quiet_NaN();
      if (out.value) out.value[p] = pixel.alpha > 0 ? pixel.content[3] / pixel.alpha : nan_value;
      if (out.time) out.time[p] = pixel.alpha > 0 ? pixel.content[4] / pixel.alpha : nan_value;
    }
}

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
#include "tool/annotate/canvas.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "tool/annotate/font.h"

namespace bcc4 {
namespace {

constexpr double halo_opacity = 0.7;
constexpr double halo_width = 0.12; // of the font's size
// Coverage is opacity in linear light, which makes bright letters fat and dark ones thin.
constexpr double bright_power = 1.3, dark_power = 1.8;

// Sums over 2 r + 1 neighbours along rows (step 1) or columns (step: the width).
void spread(std::vector<float>& values, size_t lines, size_t line_step, size_t count, size_t step, size_t r) {
  std::vector<float> out(count);
  for (size_t l = 0; l < lines; ++l) {
    float* v = &values[l * line_step];
    float sum = 0;
    for (size_t i = 0; i < std::min(r, count); ++i) sum += v[i * step];
    for (size_t i = 0; i < count; ++i) {
      if (i + r < count) sum += v[(i + r) * step];
      if (i > r) sum -= v[(i - r - 1) * step];
      out[i] = sum;
    }
    for (size_t i = 0; i < count; ++i) v[i * step] = std::max(0.0F, out[i]);
  }
}

// Returns what is near letters, soft at its edge.
std::vector<float> halo_of(const TextMask& mask, size_t r) {
  std::vector<float> halo = mask.coverage;
  const size_t w = mask.width, h = mask.height;
  const float enough = static_cast<float>(r + 1) * 0.7F; // of the sum around a pixel, to be dark
  for (int pass = 0; pass < 2; ++pass) {
    spread(halo, h, w, w, 1, r);
    spread(halo, w, 1, h, w, r);
    for (float& v : halo) v = std::min(1.0F, v / (pass == 0 ? enough : 2 * enough * enough));
  }
  return halo;
}

} // namespace

Canvas::Canvas(const Image& image) : plane_(sized<bccsplat_plane>()) {
  check(bccsplat_frame_get_channel(image.get(), BCCSPLAT_FRAME_RGBA, &plane_), "--annotate");
}

void Canvas::blend(int64_t x, int64_t y, const Color& color, double opacity, Layer layer) {
  if (x < 0 || y < 0 || x >= plane_.width || y >= plane_.height || !(opacity > 0)) return;
  float* p = plane_.pixels + y * (plane_.row_bytes / sizeof(float)) + size_t{4} * x;
  const double there = std::clamp(double{p[3]}, 0.0, 1.0);
  const double keep = layer == Layer::before ? 1 - opacity : 1;
  const double add = layer == Layer::before ? opacity : opacity * (1 - there);
  for (size_t c = 0; c < 3; ++c) p[c] = static_cast<float>(keep * p[c] + add * color[c]);
  p[3] = static_cast<float>(keep * there + add);
}

void Canvas::fill(const Point& from, const Point& to, const Color& color) {
  for (int64_t y = std::llround(from[1]); y < std::llround(to[1]); ++y)
    for (int64_t x = std::llround(from[0]); x < std::llround(to[0]); ++x)
      blend(x, y, color, 1, Layer::before);
}

void Canvas::line(const Point& from, const Point& to, double thickness, const Color& color, double opacity,
                  Layer layer) {
  const double dx = to[0] - from[0], dy = to[1] - from[1], length = std::hypot(dx, dy);
  if (!std::isfinite(length)) return;
  // Along the longer direction the line is met once in each row or column of pixels.
  const size_t a = std::fabs(dx) >= std::fabs(dy) ? 0 : 1, b = 1 - a;
  const double reach = thickness / 2 + 1, sides = a == 0 ? plane_.width : plane_.height;
  const double slope = length > 0 ? (to[b] - from[b]) / (to[a] - from[a]) : 0;
  const double half = reach * std::hypot(1, slope);
  const double first = std::max(0.0, std::floor(std::min(from[a], to[a]) - reach));
  const double last = std::min(sides - 1, std::ceil(std::max(from[a], to[a]) + reach));
  for (double u = first; u <= last; ++u) {
    const double middle = from[b] + slope * (u + 0.5 - from[a]);
    if (std::fabs(middle) > 1e9) continue;
    for (double v = std::floor(middle - half); v <= middle + half; ++v) {
      const double x = (a == 0 ? u : v) + 0.5 - from[0], y = (a == 0 ? v : u) + 0.5 - from[1];
      const double t = length > 0 ? std::clamp((x * dx + y * dy) / (length * length), 0.0, 1.0) : 0;
      const double distance = std::hypot(x - t * dx, y - t * dy);
      const double covered = std::clamp(thickness / 2 + 0.5 - distance, 0.0, 1.0);
      blend(static_cast<int64_t>(a == 0 ? u : v), static_cast<int64_t>(a == 0 ? v : u), color,
            opacity * covered, layer);
    }
  }
}

void Canvas::seamed_line(const Point& from, const Point& to, double thickness, const Color& color,
                         const Ink& ink) {
  line(from, to, 2 * thickness + 1, ink.halo, halo_opacity);
  line(from, to, thickness, color, 1);
}

void Canvas::text(const std::string& text, const Point& at, double em, Anchor anchor, const Ink& ink) {
  const auto radius = static_cast<size_t>(std::max(1.0, std::round(halo_width * em / 2)));
  const TextMask mask = text_mask(text, em, static_cast<int>(2 * radius + 1));
  const std::vector<float> halo = halo_of(mask, radius);
  const double width = text_width(text, em);
  const double before = anchor == Anchor::left ? 0 : anchor == Anchor::middle ? width / 2 : width;
  const int64_t left = std::llround(at[0] - before) - mask.pad, top = std::llround(at[1]) - mask.baseline;
  const bool bright = ink.color[1] > 0.5;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) {
      const size_t n = static_cast<size_t>(y) * mask.width + x;
      const double c = double{mask.coverage[n]};
      const double opacity = bright ? std::pow(c, bright_power) : 1 - std::pow(1 - c, dark_power);
      blend(left + x, top + y, ink.halo, halo_opacity * double{halo[n]}, Layer::before);
      blend(left + x, top + y, ink.color, opacity, Layer::before);
    }
}

} // namespace bcc4

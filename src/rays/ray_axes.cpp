// SPDX-License-Identifier: Apache-2.0
// Numerators and denominators of slopes are linear in the pixel, so that the corners of a rectangle of pixels
// have the extremes of slopes, and of what bounds their differences.
#include "rays/ray_axes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "rays/ray_lanes.h"
#include "view/pixel_rect.h"

namespace bccsplat {
namespace {

// Up to this slope a picture takes one axis, and the few blocks more that steep rays pass in a slab.
constexpr double steepest_of_one = 1.5;
// Steeper rays would pass more blocks of a slab than there are masks for.
constexpr double steepest_of_any = PassMasks::most_across - 1;

// The rays of the corners of whole pieces.
std::array<Vec3, 4> corner_rays(const SheetView& view, const PixelRect& pixels) {
  const auto last = [](int end) { return (end + piece_edge - 1) / piece_edge * piece_edge - 1; };
  const int i = last(pixels.x1), j = last(pixels.y1);
  return {view.ray(pixels.x0, pixels.y0), view.ray(i, pixels.y0), view.ray(pixels.x0, j), view.ray(i, j)};
}

RayAxis::Across find_across(const SheetView& view, const std::array<Vec3, 4>& rays, size_t axis,
                            const RayAxis& main) {
  const size_t w = main.along;
  RayAxis::Across across{axis, rays[0][axis] / rays[0][w], rays[0][axis] / rays[0][w], 0};
  for (const Vec3& r : rays) {
    across.low = std::min(across.low, r[axis] / r[w]), across.high = std::max(across.high, r[axis] / r[w]);
    if (!view.perspective) continue;
    const double di = view.ex[axis] * r[w] - r[axis] * view.ex[w],
                 dj = view.ey[axis] * r[w] - r[axis] * view.ey[w];
    across.of_piece = std::max(across.of_piece, (piece_edge - 1) * (std::fabs(di) + std::fabs(dj)) /
                                                    (main.least * main.least));
  }
  return across;
}

// The axis along which all rays advance, chosen so that the steepest of them is least steep.
std::optional<RayAxis> find_axis(const SheetView& view, const PixelRect& pixels) {
  const auto rays = corner_rays(view, pixels);
  std::optional<RayAxis> best;
  for (size_t along = 0; along < 3; ++along) {
    RayAxis axis;
    axis.along = along, axis.direction = rays[0][along] > 0 ? 1 : -1;
    axis.least = std::numeric_limits<double>::infinity();
    for (const Vec3& r : rays) axis.least = std::min(axis.least, axis.direction * r[along]);
    if (!(axis.least > 0)) continue;
    axis.across = {find_across(view, rays, along == 0 ? 1 : 0, axis),
                   find_across(view, rays, along == 2 ? 1 : 2, axis)};
    if (axis.steepest() <= steepest_of_any && (!best || axis.steepest() < best->steepest())) best = axis;
  }
  return best;
}

} // namespace

double RayAxis::steepest() const {
  double most = 0;
  for (const Across& a : across) most = std::max({most, std::fabs(a.low), std::fabs(a.high)});
  return most;
}

void RayAxis::include(const RayAxis& other) {
  least = std::min(least, other.least);
  for (size_t n = 0; n < 2; ++n) {
    Across& a = across[n];
    const Across& b = other.across[n];
    a.low = std::min(a.low, b.low), a.high = std::max(a.high, b.high);
    a.of_piece = std::max(a.of_piece, b.of_piece);
  }
}

std::optional<RayAxes> find_ray_axes(const SheetView& view) {
  RayAxes found;
  const auto whole = find_axis(view, {0, 0, view.width, view.height});
  const bool one = whole && whole->steepest() <= steepest_of_one;
  if (one) found.axes.push_back(*whole);
  for (int y = 0; y < view.height; y += ray_tile_edge)
    for (int x = 0; x < view.width; x += ray_tile_edge) {
      if (one) {
        found.of_tile.push_back(0);
        continue;
      }
      const auto axis = find_axis(
          view, {x, y, std::min(x + ray_tile_edge, view.width), std::min(y + ray_tile_edge, view.height)});
      if (!axis) return std::nullopt;
      const auto same = std::find_if(found.axes.begin(), found.axes.end(), [&](const RayAxis& a) {
        return a.along == axis->along && a.direction == axis->direction;
      });
      found.of_tile.push_back(static_cast<uint8_t>(same - found.axes.begin()));
      if (same == found.axes.end())
        found.axes.push_back(*axis);
      else
        same->include(*axis);
    }
  return found;
}

} // namespace bccsplat

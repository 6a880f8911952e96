// SPDX-License-Identifier: Apache-2.0
#include "splat/tile/sheet_corrections.h"

#include <algorithm>
#include <cmath>

#include "base/grid.h"

namespace bccsplat {

// Pixel (i, j) of a sheet is the point origin + i per_i + j per_j of the corrections' grid.
struct SheetCorrections::Sheet {
  double k;
  Vec3 origin, per_i, per_j;

  Sheet(const SplatScene& scene, int64_t number) : k(static_cast<double>(number)) {
    const SheetView& v = *scene.view;
    const Affine3& to_slice = scene.slice->lattice_to_slice;
    origin = to_slice.point(v.sample(0, 0, k)) - scene.slice->corrections->origin;
    per_i = v.scale(k) * to_slice.vector(v.ex), per_j = v.scale(k) * to_slice.vector(v.ey);
  }
};

SheetCorrections::SheetCorrections(const SplatScene& scene, const SplatPlan& plan, const PlannedTile& tile)
    : scene_(scene), plan_(plan), tile_(tile), at_(scene), fall_(scene.slice->corrections->shape) {}

bool SheetCorrections::reach(int64_t k) const {
  return std::any_of(tile_.corrections.begin(), tile_.corrections.end(), [&](uint32_t n) {
    return k >= plan_.corrections[n].first_sheet && k <= plan_.corrections[n].last_sheet;
  });
}

PixelRect SheetCorrections::add(int64_t k, const PlanePixels& plane) const {
  const SparseGrid& grid = scene_.slice->corrections->add;
  const Sheet sheet(scene_, k);
  PixelRect changed;
  for (const uint32_t n : tile_.corrections) {
    const PlannedCorrections& c = plan_.corrections[n];
    if (k < c.first_sheet || k > c.last_sheet) continue;
    grid.each(grid.bricks()[c.brick],
              [&](const Int3& at, float value) { add_point(sheet, at, value, plane, changed); });
  }
  return changed;
}

void SheetCorrections::add_point(const Sheet& sheet, const Int3& at, float value, const PlanePixels& plane,
                                 PixelRect& changed) const {
  const Vec3 g{static_cast<double>(at[0]), static_cast<double>(at[1]), static_cast<double>(at[2])};
  if (!(std::fabs(sheet.k - at_.sheet(g)) < at_.half_sheet)) return;
  const auto [x, y] = at_.pixel(g, sheet.k);
  const double scale = at_.scale(sheet.k), half_x = at_.half_x / scale, half_y = at_.half_y / scale;
  if (x + half_x < plane.x || x - half_x > plane.x + plane.width) return;
  const auto row = [](double p) { return static_cast<int>(std::clamp(p, -1e8, 1e8)); };
  const int from = std::max(row(std::ceil(y - half_y)), plane.y),
            to = std::min(row(std::floor(y + half_y)), plane.y + plane.height - 1);
  for (int j = from; j <= to; ++j) {
    // The stretch of the row that lies within 1 of the point along every axis.
    const Vec3 start = sheet.origin + j * sheet.per_j - g;
    double low = x - half_x, high = x + half_x;
    for (size_t a = 0; a < 3; ++a) {
      const double per = sheet.per_i[a];
      if (std::fabs(per) < 1e-12) {
        if (!(std::fabs(start[a]) < 1)) low = high + 1;
        continue;
      }
      const double one = (-1 - start[a]) / per, other = (1 - start[a]) / per;
      low = std::max(low, std::min(one, other)), high = std::min(high, std::max(one, other));
    }
    if (!(low <= high)) continue;
    const int first = row(std::ceil(low)), begin = std::max(first, plane.x),
              end = std::min(row(std::floor(high)) + 1, plane.x + plane.width);
    if (begin >= end) continue;
    // Counted from the row's own first pixel, so that no pixel depends on where its plane begins.
    std::array<float, 3> q, step;
    for (size_t a = 0; a < 3; ++a) {
      q[a] = static_cast<float>(start[a] + first * sheet.per_i[a]);
      step[a] = static_cast<float>(sheet.per_i[a]);
    }
    float* out = plane.first + plane_offset(0, j - plane.y, plane.pitch) - plane.x;
    for (int i = begin; i < end; ++i) {
      const auto n = static_cast<float>(i - first);
      out[i] += value * (fall_.value(q[0] + n * step[0]) * fall_.value(q[1] + n * step[1]) *
                         fall_.value(q[2] + n * step[2]));
    }
    changed.include({begin - plane.x, j - plane.y, end - plane.x, j - plane.y + 1});
  }
}

} // namespace bccsplat

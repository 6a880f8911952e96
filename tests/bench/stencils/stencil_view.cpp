// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/stencils/stencil_view.h"

#include <algorithm>
#include <cmath>

namespace bccsplat::bench {
namespace {

// Samples per T below which lines are sampled more densely: the band of a field ends at 0.5 per T.
constexpr double least_density = 1.35;
constexpr int most_phases = 4;

Vec3 unit(size_t axis, double length) {
  Vec3 e{};
  e[axis] = length;
  return e;
}

} // namespace

StencilView make_stencil_view(const Slice& slice, const WorldCamera& camera, int width, int height,
                              double sheet_step) {
  StencilView s;
  SheetView v = make_view(slice, camera, width, height, sheet_step);
  size_t w = 0;
  for (size_t a = 1; a < 3; ++a)
    if (std::fabs(v.ez[a]) > std::fabs(v.ez[w])) w = a;
  // Pixels and the eye go to the sheets along the rays; sheet 0 stays in the middle of the domain.
  const auto along = [&](const Vec3& p) { return p[w] / v.ez[w]; };
  v.ex = v.ex - along(v.ex) * v.ez, v.ey = v.ey - along(v.ey) * v.ez;
  const double back = along(v.eye - slice.centre());
  v.eye = v.eye - back * v.ez, v.depth -= back;
  v.step = std::fabs(v.ez[w]);
  v.normal = unit(w, v.ez[w] > 0 ? 1 : -1);
  const Vec3 nx = cross(v.ey, v.normal), ny = cross(v.normal, v.ex);
  v.gx = (1 / dot(v.ex, nx)) * nx, v.gy = (1 / dot(v.ey, ny)) * ny;

  std::array<size_t, 2> in_sheet{(w + 1) % 3, (w + 2) % 3};
  if (std::fabs(v.ey[in_sheet[0]]) > std::fabs(v.ey[in_sheet[1]])) std::swap(in_sheet[0], in_sheet[1]);
  s.axes = {in_sheet[0], in_sheet[1], w};
  const double plane = slice.lattice.plane_distance();
  for (size_t n = 0; n < 3; ++n) {
    s.origin[n] = v.eye[s.axes[n]] / plane;
    s.shift[n] = v.ez[s.axes[n]] / plane;
  }
  const auto map = [&](size_t axis, double pitch) {
    return std::array{v.ex[axis] / (plane * pitch), v.ey[axis] / (plane * pitch)};
  };
  s.u = map(s.axes[0], 1), s.v = map(s.axes[1], 1);
  // In a column of pixels u changes along with v: what the second pass runs on is longer than v alone.
  const double slant = std::hypot(1.0, s.u[1] / s.v[1]);
  while (s.phases_v < most_phases && s.phases_v / (2 * plane * slant) < least_density) ++s.phases_v;
  s.pitch_v = 2.0 / s.phases_v;
  s.v = map(s.axes[1], s.pitch_v);
  s.density_u = 1 / plane, s.density_v = s.phases_v / (2 * plane * slant);
  s.view = v;
  return s;
}

} // namespace bccsplat::bench

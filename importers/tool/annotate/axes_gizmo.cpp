// SPDX-License-Identifier: Apache-2.0
#include "tool/annotate/axes_gizmo.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>

namespace bcc4 {
namespace {

struct Axis {
  Vector direction; // right, up, away
  std::string name;
  Color color; // display
};

// The colours of x, y, z and t; other directions of a slice have none of them.
constexpr std::array<Color, 4> axis_colors{
    {{0.94, 0.27, 0.24}, {0.3, 0.78, 0.3}, {0.33, 0.56, 1}, {0.95, 0.77, 0.2}}};
constexpr Color other_color{0.6, 0.6, 0.6};
constexpr double arrow_length = 2.6, head_length = 0.45, name_distance = 0.75; // in em
constexpr double shortest = 0.25; // of an arrow towards who looks: its name stands beside it

constexpr double aslant = 0.17; // sine of the angle from which on an axis of the world is not called so

// The axes of the world, t the fourth, that a slice's world has in place of x, y and z, where it lies along
// them: a moment has x, y and z.
std::optional<std::array<size_t, 3>> world_axes(const bccsplat_slice_info& slice, const Affine& volume) {
  const double* const h = slice.hyperplane;
  if (h[0] == 0 && h[1] == 0 && h[2] == 0) return {{0, 1, 2}};
  if (h[3] != 0) return std::nullopt;
  const auto column = [&](size_t k) { return Vector{volume[k], volume[4 + k], volume[8 + k]}; };
  Vector normal{}; // in the world: covectors turn as areas do
  for (size_t k = 0; k < 3; ++k) {
    const Vector area = cross(column((k + 1) % 3), column((k + 2) % 3));
    for (size_t a = 0; a < 3; ++a) normal[a] += h[k] * area[a];
  }
  normal = normalised(normal);
  for (size_t a = 0; a < 3; ++a) {
    const size_t b = (a + 1) % 3, c = (a + 2) % 3;
    if (std::fabs(normal[b]) < aslant && std::fabs(normal[c]) < aslant)
      return {{std::min(b, c), std::max(b, c), 3}};
  }
  return std::nullopt;
}

std::array<Axis, 3> axes_of(const Projection& projection, const bccsplat_slice_info& slice,
                            const Affine& volume) {
  std::array<Axis, 3> axes;
  const auto world = world_axes(slice, volume);
  for (size_t k = 0; k < 3; ++k) {
    if (world) {
      Vector d{};
      d[k] = 1;
      axes[k] = {projection.turned(d), std::string(1, "xyzt"[(*world)[k]]), axis_colors[(*world)[k]]};
      continue;
    }
    axes[k] = {projection.turned(normalised({slice.affine[k], slice.affine[4 + k], slice.affine[8 + k]})),
               std::string(1, "uvw"[k]), other_color};
    for (size_t a = 0; a < 4; ++a)
      if (std::fabs(slice.basis[k][a]) > 1 - 1e-9)
        axes[k].name = std::string(1, "xyzt"[a]), axes[k].color = axis_colors[a];
  }
  return axes;
}

Point moved(const Point& p, const Point& by, double factor) {
  return {p[0] + factor * by[0], p[1] + factor * by[1]};
}

} // namespace

void draw_axes(Canvas& canvas, const Projection& projection, const bccsplat_slice_info& slice,
               const Affine& volume, const Point& origin, double em, const Ink& ink) {
  std::array<Axis, 3> axes = axes_of(projection, slice, volume);
  std::sort(axes.begin(), axes.end(),
            [](const Axis& a, const Axis& b) { return a.direction[2] > b.direction[2]; });
  const double thickness = std::max(1.5, 0.13 * em);
  for (const Axis& axis : axes) {
    const Point along{axis.direction[0], -axis.direction[1]};
    const double length = std::hypot(along[0], along[1]);
    Color color;
    for (size_t i = 0; i < 3; ++i) color[i] = srgb_to_linear(axis.color[i]);
    const Point tip = moved(origin, along, arrow_length * em);
    canvas.seamed_line(origin, tip, thickness, color, ink);
    Point away{0.7, -0.7};
    if (length > 1e-6) {
      const Point u{along[0] / length, along[1] / length};
      const double head = std::min(head_length, 0.8 * arrow_length * length) * em;
      for (const double side : {-0.5, 0.5})
        canvas.line(tip, {tip[0] - head * (u[0] + side * u[1]), tip[1] - head * (u[1] - side * u[0])},
                    thickness, color, 1);
      if (length > shortest) away = u;
    }
    const Point name = moved(tip, away, name_distance * em);
    canvas.text(axis.name, {name[0], name[1] + 0.3 * em}, em, Anchor::middle, {color, ink.halo});
  }
}

} // namespace bcc4

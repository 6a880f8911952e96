// SPDX-License-Identifier: Apache-2.0
#include "tool/annotate/axes_gizmo.h"

#include <algorithm>
#include <array>
#include <cmath>
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

Axis axis_of(const Projection& projection, const bccsplat_slice_info& slice, bool is_time_slice, size_t k) {
  if (is_time_slice) {
    Vector d{};
    d[k] = 1;
    return {projection.turned(d), std::string(1, "xyz"[k]), axis_colors[k]};
  }
  const Vector d = projection.turned(normalised({slice.affine[k], slice.affine[4 + k], slice.affine[8 + k]}));
  for (size_t a = 0; a < 4; ++a)
    if (std::fabs(slice.basis[k][a]) > 1 - 1e-9) return {d, std::string(1, "xyzt"[a]), axis_colors[a]};
  return {d, std::string(1, "uvw"[k]), other_color};
}

Point moved(const Point& p, const Point& by, double factor) {
  return {p[0] + factor * by[0], p[1] + factor * by[1]};
}

} // namespace

void draw_axes(Canvas& canvas, const Projection& projection, const bccsplat_slice_info& slice,
               bool is_time_slice, const Point& origin, double em, const Ink& ink) {
  std::array<Axis, 3> axes;
  for (size_t k = 0; k < 3; ++k) axes[k] = axis_of(projection, slice, is_time_slice, k);
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

// SPDX-License-Identifier: Apache-2.0
#include "tool/annotate/axes_gizmo.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace bcc4 {
namespace {

struct Axis {
  Vector direction;            // right, up, away
  std::string name, other_end; // the latter "": it has none
  Color color;                 // display
};

// The colours of x, y, z and t; directions that lie in several of them have another.
constexpr std::array<Color, 4> axis_colors{
    {{0.94, 0.27, 0.24}, {0.3, 0.78, 0.3}, {0.33, 0.56, 1}, {0.95, 0.77, 0.2}}};
constexpr Color other_color{0.6, 0.6, 0.6};
constexpr double arrow_length = 2.6, head_length = 0.45, name_distance = 0.75; // in em
constexpr double other_length = 0.7; // of the arrow's, to the name of the other end
constexpr double shortest = 0.25;    // of an arrow towards who looks: its name stands beside it

constexpr double aslant = 0.17; // sine of the angle from which on a direction lies in another axis, too

using WorldVector = std::array<double, 4>; // x, y, z and t, of which a frame is one mean voxel

// What x, y and z of a slice's world are in that of its volume. Slice space is in either: w = e (affine w).
std::array<WorldVector, 3> shown_axes(const bccsplat_slice_info& slice, const bccsplat_volume_info& volume) {
  const auto row = [&](size_t r) {
    const double* const m = slice.affine + 4 * (r % 3);
    return Vector{m[0], m[1], m[2]};
  };
  const double determinant = dot(row(0), cross(row(1), row(2)));
  std::array<WorldVector, 3> axes{};
  for (size_t r = 0; r < 3; ++r) {
    const Vector inverse = cross(row(r + 1), row(r + 2)); // its column r, times the determinant
    for (size_t k = 0; k < 3; ++k) {
      const double* const v = slice.basis[k];
      for (size_t a = 0; a < 3; ++a) {
        const double* const m = volume.affine + 4 * a;
        axes[r][a] += inverse[k] / determinant * (m[0] * v[0] + m[1] * v[1] + m[2] * v[2]);
      }
      axes[r][3] += inverse[k] / determinant * volume.mean_voxel * v[3];
    }
  }
  return axes;
}

std::array<Axis, 3> axes_of(const Projection& projection, const bccsplat_slice_info& slice,
                            const bccsplat_volume_info& volume, const std::optional<WorldNames>& names) {
  std::array<Axis, 3> axes;
  const std::array<WorldVector, 3> shown = shown_axes(slice, volume);
  for (size_t k = 0; k < 3; ++k) {
    Vector d{};
    d[k] = 1;
    axes[k].direction = projection.turned(d);
    for (size_t a = 0; a < 4; ++a) {
      if (std::fabs(shown[k][a]) < aslant) continue;
      axes[k].color = axes[k].name.empty() ? axis_colors[a] : other_color;
      axes[k].name += "xyzt"[a];
    }
    const size_t along = std::string("xyz").find(axes[k].name);
    if (!names || along == std::string::npos) continue;
    const size_t tip = shown[k][along] > 0 ? 1 : 0;
    if ((*names)[along][tip].empty()) continue;
    axes[k].name = (*names)[along][tip], axes[k].other_end = (*names)[along][1 - tip];
  }
  return axes;
}

Point moved(const Point& p, const Point& by, double factor) {
  return {p[0] + factor * by[0], p[1] + factor * by[1]};
}

} // namespace

void draw_axes(Canvas& canvas, const Projection& projection, const bccsplat_slice_info& slice,
               const bccsplat_volume_info& volume, const std::optional<WorldNames>& names,
               const Point& origin, double em, const Ink& ink) {
  std::array<Axis, 3> axes = axes_of(projection, slice, volume, names);
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
    if (axis.other_end.empty() || length <= shortest) continue;
    const Point other =
        moved(moved(origin, along, -other_length * arrow_length * em), away, -name_distance * em);
    canvas.text(axis.other_end, {other[0], other[1] + 0.3 * em}, em, Anchor::middle, {color, ink.halo});
  }
}

} // namespace bcc4

// SPDX-License-Identifier: Apache-2.0
#include "tool/annotate/box_outline.h"

namespace bcc4 {
namespace {

constexpr double opacity = 0.8;

// A point of slice space in the world.
Vector to_world(const bccsplat_slice_info& s, const Vector& uvw) {
  Vector out;
  for (size_t r = 0; r < 3; ++r) {
    const double* row = s.affine + 4 * r;
    out[r] = row[0] * uvw[0] + row[1] * uvw[1] + row[2] * uvw[2] + row[3];
  }
  return out;
}

// Returns the point at shares of the domain from 0 to 1.
Vector inside(const bccsplat_slice_info& s, const Vector& share) {
  Vector uvw;
  for (size_t a = 0; a < 3; ++a) uvw[a] = s.extent[a][0] + share[a] * (s.extent[a][1] - s.extent[a][0]);
  return to_world(s, uvw);
}

bool side_is_seen(const Projection& projection, const bccsplat_slice_info& s, size_t axis, size_t side) {
  const size_t b = (axis + 1) % 3, c = (axis + 2) % 3;
  const auto column = [&](size_t k) { return Vector{s.affine[k], s.affine[4 + k], s.affine[8 + k]}; };
  Vector normal = cross(column(b), column(c));
  const bool along = dot(normal, column(axis)) > 0;
  if (along != (side == 1))
    for (double& n : normal) n = -n;
  Vector middle{0.5, 0.5, 0.5};
  middle[axis] = static_cast<double>(side);
  return projection.faces(inside(s, middle), normal);
}

} // namespace

Vector domain_centre(const bccsplat_slice_info& slice) { return inside(slice, {0.5, 0.5, 0.5}); }

void draw_box(Canvas& canvas, const Projection& projection, const bccsplat_slice_info& slice,
              double thickness, const Color& color) {
  for (size_t axis = 0; axis < 3; ++axis)
    for (size_t corner = 0; corner < 4; ++corner) {
      const size_t b = (axis + 1) % 3, c = (axis + 2) % 3, at_b = corner & 1, at_c = corner >> 1;
      Vector from, to;
      from[axis] = 0, to[axis] = 1;
      from[b] = to[b] = static_cast<double>(at_b);
      from[c] = to[c] = static_cast<double>(at_c);
      const auto line = projection.line(inside(slice, from), inside(slice, to));
      const bool before =
          side_is_seen(projection, slice, b, at_b) || side_is_seen(projection, slice, c, at_c);
      if (line)
        canvas.line((*line)[0], (*line)[1], thickness, color, before ? opacity : opacity / 2,
                    before ? Layer::before : Layer::behind);
    }
}

} // namespace bcc4

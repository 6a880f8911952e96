// SPDX-License-Identifier: Apache-2.0
// Where the picture is seen from: a view fitted to the whole domain, turned, moved and enlarged.
#include <algorithm>
#include <array>
#include <cmath>

#include "viewer.h"

namespace web {
namespace {

using Vector = std::array<double, 3>;

Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Vector unit(const Vector& a) {
  const double length = std::hypot(a[0], a[1], a[2]);
  return {a[0] / length, a[1] / length, a[2] / length};
}

void bounds_of(const bccsplat_volume_info& info, double (&bounds)[6]) {
  for (int corner = 0; corner < 8; ++corner)
    for (int row = 0; row < 3; ++row) {
      double at = info.affine[4 * row + 3];
      for (int a = 0; a < 3; ++a)
        if (corner >> a & 1) at += info.affine[4 * row + a] * samples_across(info, a);
      bounds[row] = corner ? std::min(bounds[row], at) : at;
      bounds[row + 3] = corner ? std::max(bounds[row + 3], at) : at;
    }
}

constexpr double to_radians = 3.14159265358979323846 / 180;

// The same view of less around its middle, as `bcc4 render --zoom` has it.
void enlarge(bccsplat_camera& c, double factor) {
  c.ortho_height /= factor;
  c.fovy_degrees = 2 * std::atan(std::tan(c.fovy_degrees * to_radians / 2) / factor) / to_radians;
}

// The height of the picture in the world, at the target.
double height_of(const bccsplat_camera& c) {
  if (c.projection != BCCSPLAT_PROJECTION_PERSPECTIVE) return c.ortho_height;
  const double away =
      std::hypot(c.target[0] - c.position[0], c.target[1] - c.position[1], c.target[2] - c.position[2]);
  return 2 * away * std::tan(c.fovy_degrees * to_radians / 2);
}

} // namespace

void Viewer::fit(uint32_t width, uint32_t height) {
  auto fit = sized<bccsplat_fit>();
  fit.projection = wishes.perspective ? BCCSPLAT_PROJECTION_PERSPECTIVE : BCCSPLAT_PROJECTION_ORTHOGRAPHIC;
  check(bccsplat_volume_get_side(volume.get(), &fit.side));
  fit.rotate_x_degrees = wishes.turn_x, fit.rotate_y_degrees = wishes.turn_y;
  bounds_of(info, fit.bounds);
  camera = sized<bccsplat_camera>();
  check(bccsplat_fit_camera(&fit, width, height, &camera));
  const Vector up{camera.up[0], camera.up[1], camera.up[2]};
  Vector ahead{};
  for (size_t a = 0; a < 3; ++a) ahead[a] = camera.target[a] - camera.position[a];
  const Vector right = unit(cross(ahead, up)), above = unit(cross(right, ahead));
  enlarge(camera, wishes.zoom);
  const double size = height_of(camera);
  for (size_t a = 0; a < 3; ++a) {
    const double by = -size * (wishes.pan_x * right[a] + wishes.pan_y * above[a]);
    camera.target[a] += by, camera.position[a] += by;
  }
}

} // namespace web

// SPDX-License-Identifier: Apache-2.0
#include "tool/annotate/projection.h"

#include <cmath>
#include <numbers>

namespace bcc4 {

Projection::Projection(const bccsplat_camera& c, double width, double height)
    : perspective_(c.projection == BCCSPLAT_PROJECTION_PERSPECTIVE), width_(width), height_(height) {
  Vector up;
  for (size_t i = 0; i < 3; ++i)
    position_[i] = c.position[i], forward_[i] = c.target[i] - c.position[i], up[i] = c.up[i];
  nearest_ = 1e-3 * std::hypot(forward_[0], forward_[1], forward_[2]);
  forward_ = normalised(forward_);
  right_ = normalised(cross(forward_, up));
  up_ = cross(right_, forward_);
  pixel_ = (perspective_ ? 2 * std::tan(c.fovy_degrees * std::numbers::pi / 360) : c.ortho_height) / height;
}

Vector Projection::turned(const Vector& d) const { return {dot(d, right_), dot(d, up_), dot(d, forward_)}; }

Vector Projection::seen(const Vector& at) const {
  return turned({at[0] - position_[0], at[1] - position_[1], at[2] - position_[2]});
}

Point Projection::pixel(const Vector& s) const {
  const double length = perspective_ ? pixel_ * s[2] : pixel_;
  return {width_ / 2 + s[0] / length, height_ / 2 - s[1] / length};
}

std::optional<std::array<Point, 2>> Projection::line(const Vector& from, const Vector& to) const {
  Vector a = seen(from), b = seen(to);
  if (perspective_) {
    if (a[2] < nearest_ && b[2] < nearest_) return std::nullopt;
    Vector& behind = a[2] < b[2] ? a : b;
    const Vector& before = a[2] < b[2] ? b : a;
    if (behind[2] < nearest_) {
      const double t = (nearest_ - behind[2]) / (before[2] - behind[2]);
      for (size_t i = 0; i < 3; ++i) behind[i] += t * (before[i] - behind[i]);
    }
  }
  return std::array{pixel(a), pixel(b)};
}

double Projection::world_per_pixel(const Vector& at) const {
  if (!perspective_) return pixel_;
  const double depth = seen(at)[2];
  return depth > nearest_ ? pixel_ * depth : 0;
}

bool Projection::faces(const Vector& at, const Vector& normal) const {
  if (!perspective_) return dot(forward_, normal) < 0;
  return dot({position_[0] - at[0], position_[1] - at[1], position_[2] - at[2]}, normal) > 0;
}

} // namespace bcc4

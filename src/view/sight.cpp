// SPDX-License-Identifier: Apache-2.0
// The rays that a camera or matrices mean. The rows of projection * world_to_view are solved for the
// world: whatever convention they follow, a pixel is where x, y and w of clip space say.
#include "view/sight.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"

namespace bccsplat {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
// What rounding leaves of zero in a matrix that floats made, relative to its entries.
constexpr double matrix_rounding = 1e-5;
// Wider pictures, of 170 degrees and more, show next to nothing (the tangent of half of that is 11.4).
constexpr double widest = 100;

Vec3 direction_of(const ColumnMatrix& m, size_t row) { return {m[4 * row], m[4 * row + 1], m[4 * row + 2]}; }
double offset_of(const ColumnMatrix& m, size_t row) { return m[4 * row + 3]; }
double at(const ColumnMatrix& m, size_t row, const Vec3& p) {
  return dot(direction_of(m, row), p) + offset_of(m, row);
}

// The inverse of the matrix with these rows.
Affine3 inverse_of(const Vec3& a, const Vec3& b, const Vec3& c) {
  Affine3 m;
  m.linear = {a, b, c};
  const double determinant = m.determinant();
  if (!(std::fabs(determinant) > matrix_rounding * matrix_rounding * length(a) * length(b) * length(c)) ||
      !std::isfinite(1 / determinant))
    fail(Code::invalid_argument,
         "view: the matrices are no camera, they take the world to less than a picture");
  return m.inverse();
}

ColumnMatrix world_to_clip(const MatrixView& view) {
  ColumnMatrix m = multiply(view.projection, view.world_to_view);
  for (const double v : m)
    if (!std::isfinite(v)) fail(Code::invalid_argument, "view: the product of the matrices is not finite");
  return m;
}

bool is_perspective(const MatrixView& view) {
  const ColumnMatrix& p = view.projection;
  return std::fabs(p[12]) + std::fabs(p[13]) + std::fabs(p[14]) > 0;
}

Vec3 eye_of(const MatrixView& view) {
  Affine3 m;
  for (size_t r = 0; r < 3; ++r) {
    m.linear[r] = direction_of(view.world_to_view, r);
    m.offset[r] = offset_of(view.world_to_view, r);
  }
  const double determinant = m.determinant();
  if (!(std::fabs(determinant) > 0) || !std::isfinite(1 / determinant))
    fail(Code::invalid_argument, "view: world_to_view is singular");
  return m.inverse().offset;
}

struct Ndc {
  double x, x_per_pixel, y, y_per_pixel; // of the centre of pixel (0, 0), and what a pixel adds
  Ndc(const MatrixView& view, int width, int height)
      : x(1.0 / width - 1), x_per_pixel(2.0 / width), y(1 - 1.0 / height), y_per_pixel(-2.0 / height) {
    if (view.y_down) y = -y, y_per_pixel = -y_per_pixel;
  }
};

// Along the rays of an orthographic view, away from the eye.
Vec3 parallel_direction(const MatrixView& view, const ColumnMatrix& m) {
  const Vec3 along = cross(direction_of(m, 0), direction_of(m, 1));
  if (!(length(along) > 0)) fail(Code::invalid_argument, "view: the matrices are no camera");
  const double rises = dot(direction_of(m, 2), along) * (view.reversed ? -1 : 1) * offset_of(m, 3);
  if (rises == 0) fail(Code::invalid_argument, "view: depth does not change along the rays");
  return (rises > 0 ? 1 : -1) / length(along) * along;
}

} // namespace

ColumnMatrix multiply(const ColumnMatrix& a, const ColumnMatrix& b) {
  ColumnMatrix m{};
  for (size_t r = 0; r < 4; ++r)
    for (size_t c = 0; c < 4; ++c)
      for (size_t k = 0; k < 4; ++k) m[4 * r + c] += a[4 * r + k] * b[4 * k + c];
  return m;
}

Vec3 Sight::point(double i, double j, double distance) const {
  const Vec3 pixel = corner + (i * across + j * down);
  return perspective ? position + distance * pixel : position + (pixel + distance * forward);
}

Vec3 Sight::project(const Vec3& world) const {
  const Vec3 from = world - position;
  const double distance = dot(forward, from);
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  if (perspective && !(distance > 0)) return {none, none, distance};
  const Vec3 q = (perspective ? (1 / distance) * from : from - distance * forward) - corner;
  const double xx = dot(across, across), xy = dot(across, down), yy = dot(down, down);
  const double x = dot(across, q), y = dot(down, q), determinant = xx * yy - xy * xy;
  return {(yy * x - xy * y) / determinant, (xx * y - xy * x) / determinant, distance};
}

Sight Sight::region(int x, int y) const {
  Sight part = *this;
  if (ends.distance) part.ends.distance += static_cast<size_t>(y) * ends.row + static_cast<size_t>(x);
  part.corner = corner + (x * across + y * down);
  return part;
}

Sight make_sight(const WorldCamera& camera, int width, int height) {
  const double pixel = camera.height / height;
  Sight s;
  s.perspective = camera.perspective;
  s.position = camera.position, s.forward = camera.forward;
  // Pixel (0, 0) is the centre of the top left pixel.
  s.corner = (-0.5 * (width - 1) * pixel) * camera.right + (0.5 * (height - 1) * pixel) * camera.up;
  if (camera.perspective) s.corner = camera.forward + s.corner;
  s.across = pixel * camera.right, s.down = -pixel * camera.up;
  s.middle = camera.forward;
  return s;
}

double DeviceDepth::distance(double depth) const {
  if (perspective) {
    const double over = (depth - constant) / factor;
    return over > 0 ? 1 / over : infinite;
  }
  const double d = (depth - constant) / factor;
  return std::isfinite(d) ? d : infinite;
}

double DeviceDepth::depth(double distance) const {
  return perspective ? constant + factor / distance : constant + factor * distance;
}

Sight sight_of(const MatrixView& view, int width, int height) {
  const ColumnMatrix m = world_to_clip(view);
  const Ndc ndc(view, width, height);
  Sight s;
  s.perspective = is_perspective(view);
  if (s.perspective) {
    const Vec3 w = direction_of(m, 3);
    const double scale = length(w);
    const Affine3 to_world = inverse_of(direction_of(m, 0), direction_of(m, 1), w);
    s.position = to_world.vector({-offset_of(m, 0), -offset_of(m, 1), -offset_of(m, 3)});
    s.forward = normalized(w);
    s.corner = scale * to_world.vector({ndc.x, ndc.y, 1});
    s.across = scale * to_world.vector({ndc.x_per_pixel, 0, 0});
    s.down = scale * to_world.vector({0, ndc.y_per_pixel, 0});
    for (const auto& [i, j] : {std::array{0, 0}, {width, 0}, {0, height}, {width, height}})
      if (!(length(s.corner + (i * s.across + j * s.down)) < widest))
        fail(Code::invalid_argument, "view: the matrices span an angle too wide for a picture");
    s.middle = s.corner + (0.5 * (width - 1) * s.across + 0.5 * (height - 1) * s.down);
    return s;
  }
  const double w = offset_of(m, 3);
  s.middle = s.forward = parallel_direction(view, m);
  s.position = eye_of(view);
  s.in_front = true;
  const Affine3 to_world = inverse_of(direction_of(m, 0), direction_of(m, 1), s.forward);
  s.corner = to_world.vector({w * ndc.x - at(m, 0, s.position), w * ndc.y - at(m, 1, s.position), 0});
  s.across = to_world.vector({w * ndc.x_per_pixel, 0, 0});
  s.down = to_world.vector({0, w * ndc.y_per_pixel, 0});
  return s;
}

DeviceDepth device_depth(const MatrixView& view) {
  const ColumnMatrix m = world_to_clip(view);
  DeviceDepth d;
  d.perspective = is_perspective(view);
  const Vec3 z = direction_of(m, 2);
  Vec3 beside; // what of z does not run along the view
  if (d.perspective) {
    const Vec3 w = direction_of(m, 3);
    const double scale = length(w);
    const Vec3 eye = sight_of(view, 1, 1).position;
    d.constant = dot(z, w) / (scale * scale), d.factor = at(m, 2, eye) / scale;
    beside = z - d.constant * w;
    if (d.factor == 0) fail(Code::invalid_argument, "view: depth does not change along the rays");
  } else {
    const Vec3 forward = parallel_direction(view, m);
    const double w = offset_of(m, 3);
    d.constant = at(m, 2, eye_of(view)) / w, d.factor = dot(z, forward) / w;
    beside = z - dot(z, forward) * forward;
  }
  if (!(length(beside) <= matrix_rounding * length(z)) &&
      length(beside) > matrix_rounding * std::fabs(d.factor))
    fail(Code::invalid_argument, "view: planes of equal device depth are aslant to the view; give distances");
  if (view.minus_one_one) d.constant = (d.constant + 1) / 2, d.factor /= 2;
  return d;
}

MatrixView camera_matrices(const WorldCamera& camera, double height_over_width, double near, double far,
                           const MatrixView& like) {
  MatrixView v = like;
  const Vec3 back = -1.0 * camera.forward;
  const std::array<Vec3, 3> axes{camera.right, camera.up, back};
  v.world_to_view = {}, v.projection = {};
  for (size_t r = 0; r < 3; ++r) {
    for (size_t c = 0; c < 3; ++c) v.world_to_view[4 * r + c] = axes[r][c];
    v.world_to_view[4 * r + 3] = -dot(axes[r], camera.position);
  }
  v.world_to_view[15] = 1;
  // NDC depth at both ends.
  const double low = like.minus_one_one ? -1 : 0;
  const double at_near = like.reversed ? 1 : low, at_far = like.reversed ? low : 1;
  ColumnMatrix& p = v.projection;
  p[0] = 2 * height_over_width / camera.height, p[5] = (like.y_down ? -2 : 2) / camera.height;
  if (camera.perspective) {
    // -z / distance = constant + factor / distance
    const double factor = (at_near - at_far) / (1 / near - 1 / far), constant = at_near - factor / near;
    p[10] = -constant, p[11] = factor, p[14] = -1;
  } else {
    const double factor = (at_far - at_near) / (far - near);
    p[10] = -factor, p[11] = at_near - factor * near, p[15] = 1;
  }
  return v;
}

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Cameras: resolved to axes, as matrices for other programs, and fitted to boxes and slices.
#include "view/camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/error.h"

namespace bccsplat {
namespace {

constexpr double half_turn = 180; // degrees
// The sine of the angle between up and the view direction, below which nothing tells right from left.
constexpr double least_sine = 1e-12;
constexpr double degree = std::numbers::pi / half_turn;
constexpr double margin = 0.04; // of a fitted picture, on either side
constexpr int turns = 72;       // about the vertical, for each of which a box is to fit

// About the vertical, so that the camera goes to the right, and then up.
ViewSide turn(const ViewSide& side, double rotate_x_degrees, double rotate_y_degrees) {
  const double sx = std::sin(rotate_x_degrees * degree), cx = std::cos(rotate_x_degrees * degree);
  const double sy = std::sin(rotate_y_degrees * degree), cy = std::cos(rotate_y_degrees * degree);
  const Vec3 level = cy * side.back + sy * side.right; // before the camera rises
  return {cy * side.right - sy * side.back, cx * side.up - sx * level, cx * level + sx * side.up};
}

} // namespace

WorldCamera resolve_camera(const Camera& camera) {
  const auto finite = [](const Vec3& v) {
    return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
  };
  if (!finite(camera.position) || !finite(camera.target) || !finite(camera.up))
    fail(Code::invalid_argument, "camera: position, target and up must be finite");
  const Vec3 view = camera.target - camera.position;
  if (!(length(view) > 0)) fail(Code::invalid_argument, "camera: position and target are the same point");
  WorldCamera w;
  w.perspective = camera.perspective;
  w.position = camera.position;
  w.forward = normalized(view);
  const Vec3 right = cross(w.forward, camera.up);
  if (!(length(right) > least_sine * length(camera.up)))
    fail(Code::invalid_argument, "camera: up is zero or parallel to the view direction");
  w.right = normalized(right);
  w.up = cross(w.right, w.forward);
  if (camera.perspective) {
    if (!(camera.fovy_degrees > 0 && camera.fovy_degrees < half_turn))
      fail(Code::invalid_argument, "camera: fovy ", camera.fovy_degrees, " degrees is outside (0, 180)");
    w.height = 2 * std::tan(camera.fovy_degrees * std::numbers::pi / (2 * half_turn));
  } else {
    if (!(camera.ortho_height > 0 && std::isfinite(camera.ortho_height)))
      fail(Code::invalid_argument, "camera: ortho_height must be positive and finite");
    w.height = camera.ortho_height;
  }
  return w;
}

PictureMatrices picture_matrices(const WorldCamera& camera, int width, int height) {
  PictureMatrices m;
  const std::array<Vec3, 3> axes{camera.right, camera.up, camera.forward};
  for (size_t c = 0; c < 3; ++c) {
    for (size_t r = 0; r < 3; ++r) m.world_to_camera[4 * r + c] = axes[c][r];
    m.world_to_camera[4 * 3 + c] = -dot(axes[c], camera.position);
  }
  m.world_to_camera.back() = 1;
  // In each row x and y are scaled to the picture and moved to its corner, in perspective before the division
  // by z.
  const double sx = height / (camera.height * width), sy = -1 / camera.height;
  for (size_t r = 0; r < 4; ++r) {
    const double* in = &m.world_to_camera[4 * r];
    const double divisor = camera.perspective ? in[2] : in[3];
    double* out = &m.world_to_ndc[4 * r];
    out[0] = sx * in[0] + 0.5 * divisor;
    out[1] = sy * in[1] + 0.5 * divisor;
    out[2] = camera.perspective ? -in[3] : in[2];
    out[3] = divisor;
  }
  return m;
}

Camera fit_box(const WorldBox& box, const ViewSide& side, bool perspective, double rotate_x_degrees,
               double rotate_y_degrees, uint32_t width, uint32_t height) {
  const Vec3 centre = 0.5 * (box.low + box.high);
  Vec3 half = 0.5 * (box.high - box.low);
  if (!(length(half) > 0)) half = {0.5, 0.5, 0.5};
  Camera c;
  c.perspective = perspective;
  c.target = centre;
  const double aspect = static_cast<double>(width) / height, filled = 1 - 2 * margin;
  const double slope = std::tan(c.fovy_degrees * degree / 2) * filled;
  double tall = 0, distance = 0; // half the picture's height; of a camera that has each corner just in view
  for (int n = 0; n < turns; ++n) {
    const ViewSide turned = turn(side, rotate_x_degrees, n * 2 * half_turn / turns);
    for (const Vec3& corner : box_corners(-1.0 * half, half)) {
      const double right = std::fabs(dot(corner, turned.right)), up = std::fabs(dot(corner, turned.up));
      const double across = std::max(right / aspect, up);
      tall = std::max(tall, across / filled);
      distance = std::max(distance, across / slope + dot(corner, turned.back));
    }
  }
  const ViewSide turned = turn(side, rotate_x_degrees, rotate_y_degrees);
  c.up = turned.up;
  c.ortho_height = 2 * tall;
  c.position = centre + (perspective ? distance : 2 * length(half)) * turned.back;
  return c;
}

Camera fit_camera(const Slice& slice, bool perspective, double rotate_x_degrees, double rotate_y_degrees,
                  uint32_t width, uint32_t height) {
  return fit_camera(world_corners(slice, drawn_box(slice)), perspective, rotate_x_degrees, rotate_y_degrees,
                    width, height);
}

Camera fit_camera(std::span<const Vec3> points, bool perspective, double rotate_x_degrees,
                  double rotate_y_degrees, uint32_t width, uint32_t height) {
  const WorldBox box = box_around(points);
  const Vec3 centre = 0.5 * (box.low + box.high);
  double radius = 0;
  for (const Vec3& p : points) radius = std::max(radius, length(p - centre));

  const ViewSide turned = turn(back_side, rotate_x_degrees, rotate_y_degrees);
  const double smaller = std::min<double>(width, height) / height; // of the image's height
  Camera c;
  c.perspective = perspective;
  c.target = centre;
  c.up = turned.up;
  c.ortho_height = 2 * radius / smaller;
  double distance = 2 * radius;
  if (perspective) distance = radius / std::sin(std::atan(std::tan(c.fovy_degrees * degree / 2) * smaller));
  c.position = centre + distance * turned.back;
  return c;
}

} // namespace bccsplat

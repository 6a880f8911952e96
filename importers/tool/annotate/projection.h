// SPDX-License-Identifier: Apache-2.0
// Where points of the world stand in a picture.
#pragma once

#include <array>
#include <optional>

#include "bccsplat.h"
#include "tool/annotate/canvas.h"
#include "tool/view/vectors.h"

namespace bcc4 {

class Projection {
 public:
  Projection(const bccsplat_camera& camera, double width, double height);

  // The part of a line in front of the camera, none where all of it is behind.
  [[nodiscard]] std::optional<std::array<Point, 2>> line(const Vector& from, const Vector& to) const;
  // World lengths per pixel at a point's distance; 0 behind the camera.
  [[nodiscard]] double world_per_pixel(const Vector& at) const;
  // Returns a direction as the camera sees it: to the right, up and away from the eye.
  [[nodiscard]] Vector turned(const Vector& direction) const;
  // Returns whether a surface there with that normal faces the camera.
  [[nodiscard]] bool faces(const Vector& at, const Vector& normal) const;

 private:
  [[nodiscard]] Vector seen(const Vector& at) const; // right, up, depth
  [[nodiscard]] Point pixel(const Vector& seen) const;

  bool perspective_;
  double width_, height_, pixel_; // world length of a pixel, in perspective at distance 1
  double nearest_ = 0;            // depth of what is drawn
  Vector position_{}, forward_{}, right_{}, up_{};
};

} // namespace bcc4

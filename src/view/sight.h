// SPDX-License-Identifier: Apache-2.0
// What a picture sees of the world: the rays of its pixels, by a camera or by a host's matrices, and what
// cuts them.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "base/vec.h"

namespace bccsplat {

// The camera in the world that a view is made from; right, up and forward are orthonormal.
struct WorldCamera {
  bool perspective = false;
  Vec3 position{}, right{}, up{}, forward{};
  double height = 0; // of the image plane: orthographic in world units, perspective at distance 1
};

// Planar distances from the camera, world units, a row of `row` floats after the other, at which the rays of
// pixels end; infinity where nothing ends them.
struct RayEnds {
  const float* distance = nullptr; // null: none
  size_t row = 0;

  bool operator==(const RayEnds&) const = default;
  [[nodiscard]] float at(int i, int j) const { return distance[static_cast<size_t>(j) * row + i]; }
};

// The ray of pixel (i, j), whose centre has whole numbers:
//   orthographic: position + corner + i across + j down, in the direction forward
//   perspective:  from position in the direction corner + i across + j down, which has 1 along forward
struct Sight {
  bool perspective = false;
  Vec3 position{}, forward{}; // forward has unit length
  Vec3 corner{}, across{}, down{};
  std::vector<HalfSpace> clip;     // of the world: what is outside any is not seen
  bool in_front = false;           // orthographic: what lies behind the position is not seen
  std::optional<Vec3> sheets_meet; // a point that sheet 0 passes through; none: the centre of the domain
  // The ray through the middle of the whole picture, of which this may be a part; scaled as rays are.
  Vec3 middle{};
  RayEnds ends;

  bool operator==(const Sight&) const = default;
  // Returns the point at a planar distance on the ray of pixel (i, j).
  [[nodiscard]] Vec3 point(double i, double j, double distance) const;
  // Returns pixel coordinates and planar distance of a point. In perspective one beside or behind the camera
  // has no pixel: NaN.
  [[nodiscard]] Vec3 project(const Vec3& world) const;
  // Returns the same sight of a part of the picture, whose pixel (0, 0) is pixel (x, y) of this one.
  [[nodiscard]] Sight region(int x, int y) const;
};

[[nodiscard]] Sight make_sight(const WorldCamera& camera, int width, int height);

// A 4x4 matrix for columns, row-major: clip = m (x, y, z, 1).
using ColumnMatrix = std::array<double, size_t{4} * 4>;
[[nodiscard]] ColumnMatrix multiply(const ColumnMatrix& a, const ColumnMatrix& b);

// How far from the camera a device depth is. It is (near_form + far_form / distance) in perspective and
// near_form + far_form distance else.
struct DeviceDepth {
  bool perspective = false;
  double constant = 0, factor = 0;
  [[nodiscard]] double distance(double depth) const; // infinity at and beyond the far end
  [[nodiscard]] double depth(double distance) const;
};

// What a host's matrices say.
struct MatrixView {
  ColumnMatrix world_to_view{}, projection{};
  bool y_down = false;        // NDC +1 is the bottom of the picture (Vulkan)
  bool minus_one_one = false; // NDC depth runs from -1; a depth buffer holds it halved and moved to 0 .. 1
  bool reversed = false;      // device depth falls with distance
};
// Throws invalid_argument: matrices that are no camera.
[[nodiscard]] Sight sight_of(const MatrixView& view, int width, int height);
// Throws invalid_argument where planes of equal depth do not face the camera.
[[nodiscard]] DeviceDepth device_depth(const MatrixView& view);

// Returns the matrices of a camera: view space with x right, y up, looking along -z; depth from `near` to
// `far` by the convention that `like` states. height: of the picture over its width.
[[nodiscard]] MatrixView camera_matrices(const WorldCamera& camera, double height_over_width, double near,
                                         double far, const MatrixView& like);

} // namespace bccsplat

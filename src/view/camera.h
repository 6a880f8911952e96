// SPDX-License-Identifier: Apache-2.0
// The camera of a picture, in world space.
#pragma once

#include <array>

#include "field/slice.h"
#include "view/view.h"

namespace bccsplat {

// The angle that a host's or a file's perspective camera spans unless it says so, degrees.
inline constexpr double default_fovy = 30;

struct Camera {
  bool perspective = false;
  Vec3 position{}, target{}, up{};
  double fovy_degrees = default_fovy; // perspective: the angle the image's height spans, in (0, 180)
  double ortho_height = 1;            // orthographic: the image's height, world units
};

// Throws invalid_argument when position meets target, up is parallel to the view, or a size is senseless.
[[nodiscard]] WorldCamera resolve_camera(const Camera& camera);

[[nodiscard]] inline Sight make_sight(const Camera& camera, int width, int height) {
  return make_sight(resolve_camera(camera), width, height);
}

// Matrices from the world to a picture, for row vectors: x' = x M, and M[r][c] is entry 4 r + c.
using Matrix4 = std::array<double, size_t{4} * 4>;
struct PictureMatrices {
  // x to the right, y up, z along the view direction (left-handed), origin at the camera.
  Matrix4 world_to_camera{};
  // After division by the fourth part: (0, 0) the upper left, (1, 1) the lower right corner of the picture.
  // z rises with the distance d from the camera: d, in perspective -1 / d.
  Matrix4 world_to_ndc{};
};
[[nodiscard]] PictureMatrices picture_matrices(const WorldCamera& camera, int width, int height);

// What a fitted view has to its right, above it and behind it before it is turned: unit vectors along axes of
// the world, right-handed.
struct ViewSide {
  Vec3 right{}, up{}, back{};
};
// Along +z, x to the left; and as maps have it, x to the right and y up.
inline constexpr ViewSide back_side{{-1, 0, 0}, {0, 1, 0}, {0, 0, -1}},
    front_side{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
// A patient's face, head up, in a world of right, anterior, superior, and in one of left, posterior,
// superior.
inline constexpr ViewSide anterior_of_ras{{-1, 0, 0}, {0, 0, 1}, {0, 1, 0}},
    anterior_of_lps{{1, 0, 0}, {0, 0, 1}, {0, -1, 0}};

// Returns a view that the box fills but for a margin, from that side, turned about the centre of the box as
// fit_camera() does. It is of one size for all turns about the vertical. A single point gets a box of edge 1.
[[nodiscard]] Camera fit_box(const WorldBox& box, const ViewSide& side, bool perspective,
                             double rotate_x_degrees, double rotate_y_degrees, uint32_t width,
                             uint32_t height);

// Returns a view of all that is drawn of a slice. It starts along +z of world space with +y up and is turned
// about the centre of the slice's box: by rotate_y about the vertical (right-handed: the view direction +z
// turns towards +x), then by rotate_x about the camera's horizontal axis (positive: the camera rises and
// looks down; the vertical stays upright in the picture). The bounding sphere of the box fits into the
// smaller side of the image; a view in perspective spans 30 degrees.
[[nodiscard]] Camera fit_camera(const Slice& slice, bool perspective, double rotate_x_degrees,
                                double rotate_y_degrees, uint32_t width, uint32_t height);
// The same of points, such as the corners of several boxes, with the sphere about the middle of the box
// around them.
[[nodiscard]] Camera fit_camera(std::span<const Vec3> points, bool perspective, double rotate_x_degrees,
                                double rotate_y_degrees, uint32_t width, uint32_t height);

} // namespace bccsplat

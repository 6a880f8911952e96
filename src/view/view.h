// SPDX-License-Identifier: Apache-2.0
// Where the samples of a picture are: sheets perpendicular to the view direction, seen through pixel centres.
//
// Sheets are `step` lattice units apart, measured in lattice space along the normal of the sheets, where the
// kernel is a sphere: the accuracy of a sheet distance does not depend on direction or anisotropy, and a
// kernel of radius R always reaches over 2 R / step sheets. For cubic voxels that is the same number of T.
// Sheet 0 passes through the centre of the domain, so that a camera that moves along its view direction does
// not make sheets swim.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/vec.h"
#include "field/slice.h"
#include "view/sight.h"

namespace bccsplat {

// Sample (i, j) of sheet k in lattice units, i and j pixel indices (column, row from the top):
//   orthographic: eye + i ex + j ey + k ez
//   perspective:  eye + (k + depth) (ez + i ex + j ey)
struct SheetView {
  int width = 0, height = 0; // pixels
  bool perspective = false;
  Vec3 eye{}, ex{}, ey{}, ez{};
  double depth = 0;      // sheet steps from the eye (orthographic: the camera position) to sheet 0
  double step = 0;       // lattice units between sheets
  double step_world = 0; // world length between sheets along the view direction
  Affine3 lattice_to_world;
  Vec3 middle{}; // of the ray of the middle of the whole picture, a sheet step
  Vec3 normal{}; // of the sheets in lattice space: unit length, pointing away from the eye
  // Dual to ex, ey within a sheet: gx.ex = gy.ey = 1, gx.ey = gx.normal = gy.ex = gy.normal = 0.
  Vec3 gx{}, gy{};
  // What cuts the rays beside the domain: half-spaces in lattice units, the plane of the eye (always in
  // perspective), and where each ends.
  std::vector<HalfSpace> clip;
  bool in_front = false;
  RayEnds ends;

  bool operator==(const SheetView&) const = default;
  // The lengths of ex and ey on sheet k, relative to the vectors above.
  [[nodiscard]] double scale(double k) const { return perspective ? k + depth : 1.0; }
  [[nodiscard]] Vec3 sample(double i, double j, double k) const {
    return perspective ? eye + (k + depth) * (ez + (i * ex + j * ey)) : eye + (i * ex + (j * ey + k * ez));
  }
  // Lattice vector of one sheet step along the ray of pixel (i, j).
  [[nodiscard]] Vec3 ray(double i, double j) const { return perspective ? ez + (i * ex + j * ey) : ez; }
  // Sheet number of a point, fractional.
  [[nodiscard]] double sheet(const Vec3& p) const {
    const double d = dot(normal, p - eye) / step;
    return perspective ? d - depth : d;
  }
  // The first sheet in front of the eye, at least a quarter of a step away; its segment takes in all that is
  // nearer, too.
  [[nodiscard]] int64_t first_sheet() const;
  // Sheet number at a planar distance from the eye, world units.
  [[nodiscard]] double sheet_at(double distance) const { return distance / step_world - depth; }
  // Returns whether rays are cut by more than the domain and the eye of a view in perspective.
  [[nodiscard]] bool cut() const { return in_front || ends.distance || !clip.empty(); }
};

// A slice seen by a camera, before the distance of the sheets is chosen.
class SliceView {
 public:
  // Throws invalid_argument when the slice has no volume in the world.
  SliceView(const Slice& slice, const Sight& sight, int width, int height);
  SliceView(const Slice& slice, const WorldCamera& camera, int width, int height)
      : SliceView(slice, make_sight(camera, width, height), width, height) {}
  // Returns the view with sheets `step` lattice units apart. Throws invalid_argument when the camera is too
  // far away for them.
  [[nodiscard]] SheetView sheets(double step) const;
  // Length along the view direction of a lattice unit along the normal.
  [[nodiscard]] double world_per_unit() const { return world_per_unit_; }
  // The normal of the sheets in lattice space, as SheetView::normal.
  [[nodiscard]] const Vec3& normal() const { return normal_; }

 private:
  Sight sight_;
  int width_, height_;
  Affine3 lattice_to_world_, to_lattice_;
  Vec3 normal_{};
  double world_per_unit_ = 0;
  double distance_ = 0; // from the camera to sheet 0, along the view direction
};

[[nodiscard]] inline SheetView make_view(const Slice& slice, const Sight& sight, int width, int height,
                                         double sheet_step) {
  return SliceView(slice, sight, width, height).sheets(sheet_step);
}
[[nodiscard]] inline SheetView make_view(const Slice& slice, const WorldCamera& camera, int width, int height,
                                         double sheet_step) {
  return SliceView(slice, camera, width, height).sheets(sheet_step);
}

// Returns the same sheets and pixels for another slice that shares slice space and world up to a move along
// the normal of its hyperplane.
[[nodiscard]] SheetView move_view(const SheetView& view, const Slice& from, const Slice& to);

// The box of lattice units that is drawn: the domain, and along an axis of a single source sample, where that
// is a plane without thickness, half a sample's distance to either side.
struct DrawnBox {
  Vec3 begin{}, end{};
};
[[nodiscard]] DrawnBox drawn_box(const Slice& slice);
// The corners of a box of the slice's lattice units in the world.
[[nodiscard]] std::array<Vec3, 8> world_corners(const Slice& slice, const DrawnBox& box);

// Returns the sheet numbers [first, last] between which the ray of pixel (i, j) runs inside the domain and in
// front of the eye; first > last when it misses.
[[nodiscard]] std::array<double, 2> ray_interval(const Slice& slice, const SheetView& view, double i,
                                                 double j);

// Returns the sheets that may hold samples: those whose segment [k - 1/2, k + 1/2] meets the domain; first >
// last when there are none.
[[nodiscard]] std::array<int64_t, 2> sheet_range(const Slice& slice, const SheetView& view);

// Opposite corners of a box along the axes of the world.
struct WorldBox {
  Vec3 low{}, high{};
};
// Returns the box around one or more points.
[[nodiscard]] WorldBox box_around(std::span<const Vec3> points);

[[nodiscard]] inline std::array<Vec3, 8> box_corners(const Vec3& low, const Vec3& high) {
  std::array<Vec3, 8> c;
  for (size_t n = 0; n < 8; ++n)
    c[n] = {n & 1 ? high[0] : low[0], n & 2 ? high[1] : low[1], n & 4 ? high[2] : low[2]};
  return c;
}

} // namespace bccsplat

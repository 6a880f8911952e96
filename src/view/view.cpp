// SPDX-License-Identifier: Apache-2.0
// Makes the view of a picture from its camera and slice, and cuts rays and sheets by the domain.
#include "view/view.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"

namespace bccsplat {

namespace {

void set_duals(SheetView& v) {
  const Vec3 nx = cross(v.ey, v.normal), ny = cross(v.normal, v.ex);
  v.gx = (1 / dot(v.ex, nx)) * nx;
  v.gy = (1 / dot(v.ey, ny)) * ny;
}

} // namespace

int64_t SheetView::first_sheet() const {
  return perspective ? static_cast<int64_t>(std::ceil(0.25 - depth))
                     : std::numeric_limits<int64_t>::min() / 2;
}

SliceView::SliceView(const Slice& slice, const WorldCamera& camera, int width, int height)
    : camera_(camera), width_(width), height_(height),
      lattice_to_world_(slice.slice_to_world.after(slice.lattice_to_slice)) {
  if (!(std::fabs(lattice_to_world_.determinant()) > 0) || !std::isfinite(lattice_to_world_.determinant()))
    fail(Code::invalid_argument, "render: the slice has no volume in the world (its affine is singular)");
  to_lattice_ = lattice_to_world_.inverse();
  // forward . (L p) is the depth of p, so L^T forward is the sheets' covector in lattice space.
  const Vec3 covector = lattice_to_world_.transposed(camera.forward);
  normal_ = normalized(covector);
  world_per_unit_ = length(covector);
  distance_ = dot(camera.forward, lattice_to_world_.point(slice.centre()) - camera.position);
}

SheetView SliceView::sheets(double step) const {
  SheetView v;
  v.width = width_, v.height = height_;
  v.perspective = camera_.perspective;
  v.lattice_to_world = lattice_to_world_;
  v.normal = normal_;
  v.step = step;
  v.step_world = step * world_per_unit_;
  v.depth = distance_ / v.step_world;
  if (!(std::fabs(v.depth) < 1e9))
    fail(Code::invalid_argument, "render: the camera is too far from the volume");
  const double pixel = camera_.height / height_;
  // Pixel (0, 0) is the centre of the top left pixel.
  const Vec3 corner =
      (-0.5 * (width_ - 1) * pixel) * camera_.right + (0.5 * (height_ - 1) * pixel) * camera_.up;
  if (v.perspective) {
    v.eye = to_lattice_.point(camera_.position);
    v.ex = to_lattice_.vector((v.step_world * pixel) * camera_.right);
    v.ey = to_lattice_.vector((-v.step_world * pixel) * camera_.up);
    v.ez = to_lattice_.vector(v.step_world * (camera_.forward + corner));
  } else {
    v.eye = to_lattice_.point(camera_.position + (distance_ * camera_.forward + corner));
    v.ex = to_lattice_.vector(pixel * camera_.right);
    v.ey = to_lattice_.vector(-pixel * camera_.up);
    v.ez = to_lattice_.vector(v.step_world * camera_.forward);
  }
  set_duals(v);
  return v;
}

SheetView move_view(const SheetView& view, const Slice& from, const Slice& to) {
  const Affine3 move = to.lattice_to_slice.inverse().after(from.lattice_to_slice);
  SheetView v = view;
  v.eye = move.point(view.eye);
  v.ex = move.vector(view.ex), v.ey = move.vector(view.ey), v.ez = move.vector(view.ez);
  // Sheet numbers rise by this covector per lattice unit.
  const Vec3 covector = move.inverse().transposed((1 / view.step) * view.normal);
  v.step = 1 / length(covector);
  v.normal = v.step * covector;
  v.lattice_to_world = to.slice_to_world.after(to.lattice_to_slice);
  set_duals(v);
  return v;
}

DrawnBox drawn_box(const Slice& slice) {
  DrawnBox box{slice.domain_begin, slice.domain_end};
  for (size_t a = 0; a < 3; ++a) {
    if (box.end[a] != box.begin[a]) continue;
    const Affine3& m = slice.lattice_to_slice;
    const double half = 0.5 / length(Vec3{m.linear[0][a], m.linear[1][a], m.linear[2][a]});
    box.begin[a] -= half, box.end[a] += half;
  }
  return box;
}

std::array<double, 2> ray_interval(const Slice& slice, const SheetView& view, double i, double j) {
  // Along the ray every coordinate is that of origin + k * direction.
  const Vec3 direction = view.ray(i, j);
  const Vec3 origin = view.perspective ? view.eye + view.depth * direction : view.sample(i, j, 0);
  double first = view.perspective ? -view.depth : -std::numeric_limits<double>::infinity();
  double last = std::numeric_limits<double>::infinity();
  const auto cut = [&](double slope, double offset) { // slope k + offset >= 0
    if (slope > 0)
      first = std::max(first, -offset / slope);
    else if (slope < 0)
      last = std::min(last, -offset / slope);
    else if (offset < 0)
      last = -std::numeric_limits<double>::infinity();
  };
  const DrawnBox box = drawn_box(slice);
  for (size_t a = 0; a < 3; ++a) {
    cut(direction[a], origin[a] - box.begin[a]);
    cut(-direction[a], box.end[a] - origin[a]);
  }
  for (const HalfSpace& h : slice.clip) cut(dot(h.normal, direction), dot(h.normal, origin) + h.offset);
  return {first, last};
}

std::array<int64_t, 2> sheet_range(const Slice& slice, const SheetView& view) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  const DrawnBox box = drawn_box(slice);
  for (const Vec3& c : box_corners(box.begin, box.end)) {
    low = std::min(low, view.sheet(c));
    high = std::max(high, view.sheet(c));
  }
  if (!(high - low < 1e8)) fail(Code::invalid_argument, "render: more than 1e8 sheets; raise sheet_step");
  return {std::max(view.first_sheet(), static_cast<int64_t>(std::ceil(low - 0.5))),
          static_cast<int64_t>(std::floor(high + 0.5))};
}

} // namespace bccsplat

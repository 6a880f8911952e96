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

SliceView::SliceView(const Slice& slice, const Sight& sight, int width, int height)
    : sight_(sight), width_(width), height_(height),
      lattice_to_world_(slice.slice_to_world.after(slice.lattice_to_slice)) {
  if (!(std::fabs(lattice_to_world_.determinant()) > 0) || !std::isfinite(lattice_to_world_.determinant()))
    fail(Code::invalid_argument, "render: the slice has no volume in the world (its affine is singular)");
  to_lattice_ = lattice_to_world_.inverse();
  // forward . (L p) is the depth of p, so L^T forward is the sheets' covector in lattice space.
  const Vec3 covector = lattice_to_world_.transposed(sight.forward);
  normal_ = normalized(covector);
  world_per_unit_ = length(covector);
  const Vec3 middle = sight.sheets_meet ? *sight.sheets_meet : lattice_to_world_.point(slice.centre());
  distance_ = dot(sight.forward, middle - sight.position);
}

SheetView SliceView::sheets(double step) const {
  SheetView v;
  v.width = width_, v.height = height_;
  v.perspective = sight_.perspective;
  v.lattice_to_world = lattice_to_world_;
  v.normal = normal_;
  v.step = step;
  v.step_world = step * world_per_unit_;
  v.depth = distance_ / v.step_world;
  if (!(std::fabs(v.depth) < 1e9))
    fail(Code::invalid_argument, "render: the camera is too far from the volume");
  if (v.perspective) {
    v.eye = to_lattice_.point(sight_.position);
    v.ex = to_lattice_.vector(v.step_world * sight_.across);
    v.ey = to_lattice_.vector(v.step_world * sight_.down);
    v.ez = to_lattice_.vector(v.step_world * sight_.corner);
  } else {
    v.eye = to_lattice_.point(sight_.position + (distance_ * sight_.forward + sight_.corner));
    v.ex = to_lattice_.vector(sight_.across);
    v.ey = to_lattice_.vector(sight_.down);
    v.ez = to_lattice_.vector(v.step_world * sight_.forward);
  }
  v.middle = to_lattice_.vector(v.step_world * sight_.middle);
  set_duals(v);
  for (const HalfSpace& h : sight_.clip) v.clip.push_back(h.seen_through(lattice_to_world_));
  v.in_front = sight_.in_front, v.ends = sight_.ends;
  return v;
}

SheetView move_view(const SheetView& view, const Slice& from, const Slice& to) {
  const Affine3 move = to.lattice_to_slice.inverse().after(from.lattice_to_slice);
  SheetView v = view;
  v.eye = move.point(view.eye);
  v.ex = move.vector(view.ex), v.ey = move.vector(view.ey), v.ez = move.vector(view.ez);
  v.middle = move.vector(view.middle);
  // Sheet numbers rise by this covector per lattice unit.
  const Vec3 covector = move.inverse().transposed((1 / view.step) * view.normal);
  v.step = 1 / length(covector);
  v.normal = v.step * covector;
  v.lattice_to_world = to.slice_to_world.after(to.lattice_to_slice);
  for (HalfSpace& h : v.clip) h = h.seen_through(move.inverse());
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

std::array<Vec3, 8> world_corners(const Slice& slice, const DrawnBox& box) {
  const Affine3 to_world = slice.slice_to_world.after(slice.lattice_to_slice);
  std::array<Vec3, 8> corners = box_corners(box.begin, box.end);
  for (Vec3& c : corners) c = to_world.point(c);
  return corners;
}

WorldBox box_around(std::span<const Vec3> points) {
  WorldBox box{points.front(), points.front()};
  for (const Vec3& p : points)
    for (size_t a = 0; a < 3; ++a)
      box.low[a] = std::min(box.low[a], p[a]), box.high[a] = std::max(box.high[a], p[a]);
  return box;
}

std::array<double, 2> ray_interval(const Slice& slice, const SheetView& view, double i, double j) {
  // Along the ray every coordinate is that of origin + k * direction.
  const Vec3 direction = view.ray(i, j);
  const Vec3 origin = view.perspective ? view.eye + view.depth * direction : view.sample(i, j, 0);
  double first = view.perspective || view.in_front ? -view.depth : -std::numeric_limits<double>::infinity();
  double last = std::numeric_limits<double>::infinity();
  if (view.ends.distance) {
    const auto nearest = [](double x, int count) {
      return static_cast<int>(std::clamp(std::nearbyint(x), 0.0, count - 1.0));
    };
    last = view.sheet_at(view.ends.at(nearest(i, view.width), nearest(j, view.height)));
  }
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
  for (const auto* const clips : {&slice.clip, &view.clip})
    for (const HalfSpace& h : *clips) cut(dot(h.normal, direction), dot(h.normal, origin) + h.offset);
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

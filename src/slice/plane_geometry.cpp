// SPDX-License-Identifier: Apache-2.0
// Linear algebra of hyperplanes: bases by Gram-Schmidt, the axis one is normal to, its part of the domain.
#include "slice/plane_geometry.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace bccsplat {
namespace {

// Takes the parts along the directions before it from v and brings it to unit length; returns the length that
// it had left.
double orthonormalise(Vec4& v, const Vec4* before, size_t count) {
  double left = 0;
  for (int pass = 0; pass < 2; ++pass) { // the second pass removes what rounding left of the first
    for (size_t k = 0; k < count; ++k) {
      const double part = dot4(v, before[k]);
      for (size_t i = 0; i < 4; ++i) v[i] -= part * before[k][i];
    }
    const double length = std::sqrt(dot4(v, v));
    if (pass == 0) left = length;
    for (double& c : v) c /= length;
  }
  return left;
}

} // namespace

PlaneAxes plane_axes(const Hyperplane& h) {
  PlaneAxes axes;
  const Vec4 normal = h.normal();
  for (size_t i = 0; i < 4; ++i) axes.origin[i] = -h[4] * normal[i];
  size_t left_out = 0;
  for (size_t a = 1; a < 4; ++a)
    if (std::fabs(normal[a]) > std::fabs(normal[left_out])) left_out = a;
  std::array<Vec4, 4> directions{normal};
  size_t count = 1;
  for (size_t a = 0; a < 4; ++a) {
    if (a == left_out) continue;
    Vec4 v{};
    v[a] = 1;
    (void)orthonormalise(v, directions.data(), count); // never short: `a` is not the normal's main axis
    directions[count++] = v;
  }
  std::copy(directions.begin() + 1, directions.end(), axes.basis.begin());
  return axes;
}

PlaneAxes plane_axes(const Vec4& point, const std::array<Vec4, 3>& directions) {
  PlaneAxes axes{point, directions};
  for (size_t k = 0; k < 3; ++k) {
    Vec4& v = axes.basis[k];
    double largest = 0;
    for (size_t i = 0; i < 4; ++i) {
      if (!std::isfinite(v[i]) || !std::isfinite(point[i]))
        fail(Code::invalid_argument, "hyperplane: point and basis must be finite");
      largest = std::max(largest, std::fabs(v[i]));
    }
    if (largest > 0)
      for (double& c : v) c /= largest;
    if (largest == 0 || !(orthonormalise(v, axes.basis.data(), k) > 1e-9))
      fail(Code::invalid_argument, "hyperplane: direction ", k, " of the basis depends on those before it");
  }
  return axes;
}

Hyperplane hyperplane_of(const PlaneAxes& axes) {
  // The normal is what is left of the coordinate axis furthest from the basis, so that its largest component
  // is positive.
  const auto& basis = axes.basis;
  size_t axis = 0;
  double best = 2;
  for (size_t a = 0; a < 4; ++a) {
    const double inside = basis[0][a] * basis[0][a] + basis[1][a] * basis[1][a] + basis[2][a] * basis[2][a];
    if (inside < best) best = inside, axis = a;
  }
  Vec4 normal{};
  normal[axis] = 1;
  (void)orthonormalise(normal, basis.data(), 3);
  return Hyperplane::through(axes.origin, normal);
}

std::optional<AxisCut> axis_cut(const Hyperplane& h, const std::array<uint32_t, 4>& dims) {
  size_t axis = 0;
  for (size_t a = 1; a < 4; ++a)
    if (std::fabs(h[a]) > std::fabs(h[axis])) axis = a;
  double tilt = 0, centre = -h[4] / h[axis];
  for (size_t a = 0; a < 4; ++a) {
    if (a == axis) continue;
    const double extent = dims[a] - 1.0;
    tilt += std::fabs(h[a] / h[axis]) * extent;
    centre -= h[a] / h[axis] * extent / 2;
  }
  if (tilt >= 1e-6) return std::nullopt;
  // Adding 0 turns -0, which prints badly, into 0.
  return AxisCut{axis, centre + 0.0};
}

PlaneExtent plane_extent(const Lattice4& lattice, const Hyperplane& h, const PlaneAxes& axes) {
  PlaneExtent e;
  const auto include = [&](const Vec4& p) {
    Vec4 d;
    for (size_t i = 0; i < 4; ++i) d[i] = p[i] - axes.origin[i];
    for (size_t k = 0; k < 3; ++k) {
      const double u = dot4(d, axes.basis[k]);
      e.low[k] = e.empty ? u : std::min(e.low[k], u);
      e.high[k] = e.empty ? u : std::max(e.high[k], u);
    }
    for (size_t i = 0; i < 4; ++i) {
      e.box_low[i] = e.empty ? p[i] : std::min(e.box_low[i], p[i]);
      e.box_high[i] = e.empty ? p[i] : std::max(e.box_high[i], p[i]);
    }
    e.empty = false;
  };
  // The extent is that of the points where edges of the domain cross the hyperplane, and of the corners on
  // it.
  for (unsigned corner = 0; corner < 16; ++corner)
    for (size_t axis = 0; axis < 4; ++axis) {
      if (corner >> axis & 1) continue;
      Vec4 p{};
      for (size_t i = 0; i < 4; ++i) p[i] = (corner >> i & 1) ? lattice.domain_end(i) : 0;
      Vec4 q = p;
      q[axis] = lattice.domain_end(axis);
      const double from = height(h, p), to = height(h, q);
      const double slack = 1e-9;
      if (std::fabs(from) <= slack) include(p);
      if (std::fabs(to) <= slack) include(q);
      if ((from < -slack && to > slack) || (from > slack && to < -slack)) {
        p[axis] = q[axis] * (from / (from - to));
        include(p);
      }
    }
  return e;
}

double lattice_density(const Lattice4& lattice, const Vec4& direction) {
  const LatticeScales scales = lattice.nominal_scales();
  double square = 0;
  for (size_t i = 0; i < 4; ++i)
    if (scales[i] > 0) square += direction[i] / scales[i] * (direction[i] / scales[i]);
  // A unit vector's is 1 but for rounding.
  return std::fabs(square - 1) < 1e-12 ? 1 : std::sqrt(square);
}

Affine3 world_affine(const PlaneAxes& axes, const Affine3& index_to_world, double time_length) {
  const auto in_world = [&](const Vec4& v, const Vec3& space) {
    return Vec4{space[0], space[1], space[2], time_length * v[3]};
  };
  const auto in_space = [](const Vec4& v) { return Vec3{v[0], v[1], v[2]}; };
  PlaneAxes world{in_world(axes.origin, index_to_world.point(in_space(axes.origin))), {}};
  for (size_t k = 0; k < 3; ++k)
    world.basis[k] = in_world(axes.basis[k], index_to_world.vector(in_space(axes.basis[k])));
  std::array<Vec4, 3> unit = world.basis;
  for (size_t k = 0; k < 3; ++k) (void)orthonormalise(unit[k], unit.data(), k);
  const std::array<Vec4, 3> shown = plane_axes(hyperplane_of({world.origin, unit})).basis;
  Affine3 a;
  for (size_t row = 0; row < 3; ++row) {
    for (size_t column = 0; column < 3; ++column)
      a.linear[row][column] = dot4(shown[row], world.basis[column]) + 0.0; // no -0
    a.offset[row] = dot4(shown[row], world.origin) + 0.0;
  }
  return a;
}

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Hyperplanes of index space: bases, axes they are normal to, and their part of the domain.
#pragma once

#include <array>
#include <optional>

#include "base/vec.h"
#include "field/hyperplane.h"
#include "lattice/lattice.h"

namespace bccsplat {

// The place of slice space in index space: its origin and orthonormal directions of u, v, w.
struct PlaneAxes {
  Vec4 origin{};
  std::array<Vec4, 3> basis{};
};

[[nodiscard]] inline double dot4(const Vec4& a, const Vec4& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
}

// Returns the usual axes: the origin is the foot of the index origin, the basis the coordinate axes without
// the one closest to the normal, projected and orthonormalised in order.
[[nodiscard]] PlaneAxes plane_axes(const Hyperplane& h);
// Returns axes through `point` along three directions, which are orthonormalised in order; throws
// invalid_argument when they are not finite or nearly dependent. The normal is their cross product.
[[nodiscard]] PlaneAxes plane_axes(const Vec4& point, const std::array<Vec4, 3>& directions);
[[nodiscard]] Hyperplane hyperplane_of(const PlaneAxes& axes);

// An axis (0 to 3) of index space that the hyperplane is normal to, tilted by less than 1e-6 index units over
// the domain, and where it cuts it.
struct AxisCut {
  size_t axis;
  double position;
};
[[nodiscard]] std::optional<AxisCut> axis_cut(const Hyperplane& h, const std::array<uint32_t, 4>& dims);

// The part of the domain in a hyperplane: bounds in slice space and in index space.
struct PlaneExtent {
  Vec3 low{}, high{};
  Vec4 box_low{}, box_high{};
  bool empty = true;
};
[[nodiscard]] PlaneExtent plane_extent(const Lattice4& lattice, const Hyperplane& h, const PlaneAxes& axes);

// Returns how many lattice units a step of length 1 in index units takes: as many times the Nyquist frequency
// of the source's samples a wave in the lattice's ball may reach along `direction`. A lattice asked for at
// distance 1 has 1.
[[nodiscard]] double lattice_density(const Lattice4& lattice, const Vec4& direction);

// Returns slice space -> the volume's world, where a fourth, orthogonal axis of `time_length` world units per
// frame stands for time. The axis of the world nearest to the hyperplane's normal is left out. The others, in
// order, are projected into the hyperplane and orthonormalised: at t = constant the place is that of
// index_to_world, at x = constant it is (y, z, t) of the world.
[[nodiscard]] Affine3 world_affine(const PlaneAxes& axes, const Affine3& index_to_world, double time_length);

} // namespace bccsplat

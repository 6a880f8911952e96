// SPDX-License-Identifier: Apache-2.0
// How close the sites of a slice stand that is resampled on a lattice in its hyperplane.
#pragma once

#include "field/slice.h"
#include "slice/plane_slice.h"

namespace bccsplat {

// Returns how much finer a lattice has to be along a direction of slice space that runs along uneven axes.
[[nodiscard]] double plane_refinement(const UnevenAxes& axes, const Vec4& direction);

// Returns the distances of the slice's lattice along its axes, in slice space.
[[nodiscard]] Vec3 plane_spacings(const Lattice4& lattice, const HypersliceOptions& options,
                                  const PlaneAxes& axes);

// Returns how far beyond the ends of the domain, in index units, sites are filled in, for the slice's filter
// and kernel. unit: the largest of its distances.
[[nodiscard]] double slice_margin(const Slice& slice, double unit);

} // namespace bccsplat

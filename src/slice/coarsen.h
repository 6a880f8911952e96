// SPDX-License-Identifier: Apache-2.0
// A slice at half the resolution per axis, for pictures whose pixels are larger than its lattice distance.
#pragma once

#include "base/context.h"
#include "field/slice.h"

namespace bccsplat {

// Returns the field low-passed and sampled on the lattice of twice the distance, an eighth of the points,
// with the same domain, world and kernel. The low pass is the cubic B-spline over the sites of each coset
// (pitch sqrt2; response 0.42 at the Nyquist rate of the new lattice, 0.02 at twice that; on Cartesian slices
// the linear one over 4 sites, 0.41 and 0), so that the mean of the field stays and nothing rings. Distances
// that are no whole number of the old ones, where a lattice has an odd number of planes, are served by the
// spline's own phase. Coefficients below 1/4096 of the largest are dropped. A site is a hole where the old
// site nearest to it is.
[[nodiscard]] Slice coarsen(const Slice& slice, const Context& context);

} // namespace bccsplat

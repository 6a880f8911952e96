// SPDX-License-Identifier: Apache-2.0
// Slices of volumes whose samples are unevenly spaced, resampled so that slice space is even: its units are
// even positions (points/uneven_axes.h), which an affine takes to the world. Pictures need that.
#pragma once

#include <memory>

#include "base/context.h"
#include "field/slice.h"
#include "points/uneven_axes.h"
#include "slice/part.h"

namespace bccsplat {

// A lattice of more planes along an axis than so many times those of the slice is not made, nor one that
// takes more than half of the memory budget, or 4 GiB: what is lacking, the slice tells.
inline constexpr double most_refined = 32;
// What is further than this from the domain (lattice units) matters to nothing in it.
inline constexpr double looked_beyond = 8;
// Returns how many planes such a lattice has for one of an even axis, as fine as is wanted.
[[nodiscard]] double wanted_refinement(const UnevenAxes& axes, size_t axis);

// The field of a slice, on a lattice that is finer along uneven axes: the planes stand as close as the
// closest samples ask for, so that between two of these it is the slice's to what its own kernel loses. Along
// even axes the planes are those of the slice. Masks are exact. Corrections are in its points, and no longer
// beside them. The slice is one of time, or of an axis: others throw unsupported. Without uneven axes it
// comes back as it is.
[[nodiscard]] Slice even_slice(const Slice& slice, const std::shared_ptr<const UnevenAxes>& axes,
                               const Context& context);

// Returns a box of even positions as one of indices.
[[nodiscard]] IndexBox index_box(const IndexBox& even, const UnevenAxes& axes);

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Gives slices of a volume the masks of its missing samples: a point of a slice has no value where the volume
// has none, at the resolution of the source.
#pragma once

#include <array>

#include "field/coefficients/coefficients.h"
#include "field/slice.h"

namespace bccsplat {

// The frame nearest to a time slice decides what is missing; with an interval or a thickness it is the frame
// nearest to the slice's own instant.
void mask_time_slice(Slice& slice, const Coefficients& coefficients);
// The frames that any other slice meets decide what is missing. Its origin and basis must be set.
void mask_slice(Slice& slice, const Coefficients& coefficients);

// The first and the last moment (frames) at which points of a slice's box stand, whose masks mask_slice
// reads.
[[nodiscard]] std::array<double, 2> moments_of(const Slice& slice);

} // namespace bccsplat

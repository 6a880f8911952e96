// SPDX-License-Identifier: Apache-2.0
// A part of a time slice: a box of it, made of no more than what the field in there depends on.
#pragma once

#include "base/vec.h"
#include "field/slice.h"
#include "lattice/lattice.h"
#include "points/sample_source.h"

namespace bccsplat {

// Source index units; begin <= end per axis.
struct IndexBox {
  Vec3 begin{}, end{};
};

// Returns what of the box lies between the first and the last sample of each axis. Throws out_of_domain where
// nothing does.
[[nodiscard]] IndexBox clip_to_samples(const IndexBox& box, const Lattice4& lattice);

// Who looks at coefficients beyond the box.
enum class BeyondBox : uint8_t {
  field,    // its kernel, and the low-pass of the first coarser slice
  prefilter // one that makes coefficients of what the field is at its sites, too
};

// The bricks whose coefficients a slice in the box needs.
[[nodiscard]] BrickBox bricks_around(const IndexBox& box, const Lattice4& lattice, BeyondBox beyond);

// Makes the box the domain of a time slice.
void cut_to_box(Slice& slice, const IndexBox& box);

} // namespace bccsplat

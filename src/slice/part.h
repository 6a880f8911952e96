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

// How many sites of a coset, on either side of it, a point's value and gradient depend on.
[[nodiscard]] int sites_in_reach(const Lattice4& lattice, const Kernel& kernel);
// The bricks that hold so many sites on either side of the box, too.
[[nodiscard]] BrickBox bricks_around(const IndexBox& box, const Lattice4& lattice, int sites);

// Makes the box the domain of a time slice.
void cut_to_box(Slice& slice, const IndexBox& box);

} // namespace bccsplat

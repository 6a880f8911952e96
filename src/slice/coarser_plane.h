// SPDX-License-Identifier: Apache-2.0
// Resampled slices that are coarser than their volume: when a slice is one, and its samples, those of a slice
// at the volume's own spacing, low-passed.
#pragma once

#include <vector>

#include "slice/plane_slice.h"

namespace bccsplat {

// Returns whether the slice's lattice holds less than what it is cut from.
[[nodiscard]] bool coarser_plane(const Lattice4& lattice, const HypersliceOptions& options,
                                 const PlaneAxes& axes);

// Returns the samples of `slice`, by coset, and gives it base and air: of `fine`, whose cosets hold samples
// at the volume's own spacing, relative to the base.
[[nodiscard]] std::vector<BrickLayer> lowpassed_plane(Slice& slice, const Slice& fine,
                                                      const Lattice4& lattice,
                                                      const HypersliceOptions& options,
                                                      const Context& context);

} // namespace bccsplat

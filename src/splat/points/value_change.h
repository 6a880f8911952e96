// SPDX-License-Identifier: Apache-2.0
// How fast the values of a slice change.
#pragma once

#include "splat/points/points.h"

namespace bccsplat {

// Returns how much values change along one lattice unit where they change fast: the 95th percentile of the
// gradient's length at points of the slice, some hundred of them, the same in every picture.
[[nodiscard]] double change_per_unit(const Slice& slice, const SplatPoints& points);

} // namespace bccsplat

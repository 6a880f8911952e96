// SPDX-License-Identifier: Apache-2.0
// How far the field of a slice on BCC may be from what its values at the corners of a small cube say.
#pragma once

#include <optional>

#include "kernel/kernel.h"

namespace bccsplat {

// For a cube of the plane grid (edge 1/sqrt2), or one of the parts^3 cubes that it is cut into, and c the
// coefficients in reach of it:
//   |field - trilinear of its corners| <= of_range (max c - min c) / 2 + of_middle |max c + min c| / 2
struct CellBound {
  double of_range = 0, of_middle = 0;
};

// Edges of a cell are cut into so many where its field is bounded: of all cells, and of those that are looked
// at again.
inline constexpr int cell_parts = 2, refined_parts = 4;

// The bound for one of these of the kernels whose radius is at most 2; none of others.
[[nodiscard]] std::optional<CellBound> cell_bound(const Kernel& kernel, int parts = cell_parts);

} // namespace bccsplat

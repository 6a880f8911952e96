// SPDX-License-Identifier: Apache-2.0
// How far the field of a slice on BCC may be from what its values at the corners of a small cube say.
#pragma once

#include "kernel/kernel.h"

namespace bccsplat::bench {

// For a cube of the plane grid (edge 1/sqrt2), or one of the parts^3 cubes that it is cut into, and c the
// coefficients in reach of it:
//   |field - trilinear of its corners| <= of_range (max c - min c) / 2 + of_middle |max c + min c| / 2
struct CellBound {
  double of_range = 0, of_middle = 0;
};

// Proven: largest sums on a fine grid, and what sums between its points may have more.
[[nodiscard]] CellBound cell_bound(const RadialKernel& kernel, int parts);

} // namespace bccsplat::bench

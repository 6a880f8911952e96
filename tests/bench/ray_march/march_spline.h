// SPDX-License-Identifier: Apache-2.0
// Cubic B-splines through the samples of a grid: what is made once, before any picture.
#pragma once

#include <array>

#include "tests/bench/ray_march/ray_march.h"

namespace bccsplat::bench {

// Turns samples into the coefficients of the splines that interpolate them, the samples mirrored at every
// end.
void make_spline_coefficients(MarchGrid& grid);

// The least and the largest control value of the cubic pieces in a macro cell, which their values stay
// between.
[[nodiscard]] std::array<float, 2> spline_bounds(const MarchGrid& grid, const Int3& cell);

} // namespace bccsplat::bench

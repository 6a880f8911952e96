// SPDX-License-Identifier: Apache-2.0
// The fields that predictions are made for, and the least squares that make them: waves whose frequencies
// fill balls, most of them far below Nyquist.
#pragma once

#include <vector>

namespace bccsplat {

// Correlation of the values at two points `distance` apart, in units of the sample distance: 1 at 0.
// dimensions: of the balls, 3 or 4.
[[nodiscard]] double field_correlation(int dimensions, double distance);

// Solves n linear equations, the rows of `a` with the right side as the last of n + 1 columns, by
// Gauss-Jordan elimination with partial pivoting.
[[nodiscard]] std::vector<double> solve(std::vector<std::vector<double>> a);

} // namespace bccsplat

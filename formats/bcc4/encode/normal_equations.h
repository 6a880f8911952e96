// SPDX-License-Identifier: Apache-2.0
// Sums of products for least squares over the neighbours of sites, many at once.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "formats/bcc4/coding/predict_walk.h"

namespace bccsplat {

// The sums of v[i] v[j] over all samples for j <= i <= n, where v[0] .. v[n - 1] are the coefficients of the
// unknowns and v[n] is the value they should give.
struct NormalEquations {
  static constexpr size_t rows = (max_taps + 1 + 3) / 4 * 4, columns = 32;
  alignas(64) std::array<std::array<double, columns>, rows> sum{};
};

// `samples` are rows of NormalEquations::columns doubles, 0 behind v[n]. Each sum is made in the order of the
// samples and without fused operations, so that every target gets the same bits.
void add_samples(NormalEquations& equations, std::span<const double> samples, size_t n);

// Equations a w = b, of which a is symmetric and its lower half is given.
struct LeastSquares {
  std::array<std::array<double, max_taps>, max_taps> a{};
  std::array<double, max_taps> b{};
};
// The first n unknowns, in units of 1/4096, a little pulled to 0; their magnitudes sum to at most INT16_MAX.
[[nodiscard]] Weights solve(LeastSquares equations, size_t n);

} // namespace bccsplat

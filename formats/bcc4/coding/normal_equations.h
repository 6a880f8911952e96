// Least squares over the neighbours of sites: sums of products, many at once.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "formats/bcc4/coding/predict_walk.h"

namespace bccsplat {

// Of the unknowns' coefficients v[0] .. v[n - 1] and the value v[n] they should give: sums of v[i] v[j] over
// all samples, for j <= i <= n.
struct NormalEquations {
  static constexpr size_t rows = (max_taps + 1 + 3) / 4 * 4, columns = 32;
  alignas(64) std::array<std::array<double, columns>, rows> sum{};
};

// `samples`: rows of NormalEquations::columns doubles, 0 behind v[n]. Each sum is made in the order of the
// samples, without fused operations: every target gets the same bits.
void add_samples(NormalEquations& equations, std::span<const double> samples, size_t n);

} // namespace bccsplat

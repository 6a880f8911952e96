// SPDX-License-Identifier: Apache-2.0
// One-dimensional resampling: source samples at 0 .. n-1 -> values at given positions.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace bccsplat {

// Position p takes samples first[p] .. first[p] + taps - 1 with weight[p * taps ..]; indices outside 0 .. n-1
// mean the mirror image (mirror_index). The weights of a position sum to 1.
struct FilterTable {
  int taps = 1;
  std::vector<int64_t> first;
  std::vector<float> weight;
};

// The Kaiser window on -1 .. 1: 1 in the middle.
[[nodiscard]] double kaiser_window(double u, double beta);
// A value depends on samples less than this far from its position. `widening` >= 1 stretches the filter, so
// that it passes only what a lattice coarser than the source by that factor can hold.
[[nodiscard]] int filter_reach(double widening);
// positions: in source samples; one that is a sample to within 1e-9 takes that sample as it is (unless
// widened).
[[nodiscard]] FilterTable filter_table(double widening, std::span<const double> positions);
// Returns where mirroring puts index i of an axis of n samples: -i -> i, n-1+i -> n-1-i, as often as needed.
[[nodiscard]] int64_t mirror_index(int64_t i, int64_t n);
// The same of an axis that may be periodic, whose sample n is sample 0 again.
[[nodiscard]] inline int64_t end_index(int64_t i, int64_t n, bool turns) {
  return turns ? ((i % n) + n) % n : mirror_index(i, n);
}

} // namespace bccsplat

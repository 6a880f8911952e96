// SPDX-License-Identifier: Apache-2.0
// The lifting steps of the wavelets 9/7 on many lines at once, in vectors. Targets agree to the bit: each
// operation is rounded, in one order.
#pragma once

#include <cstddef>
#include <vector>

namespace bccsplat {

// Lines of a box that are lifted together. Between the samples of a line lie `stride` floats, between lines
// one (across) or `stride` (along: their samples follow each other).
struct LineBlock {
  float* first = nullptr;
  size_t stride = 0;
  int count = 0, lines = 0; // samples of a line, at least 2
};

// Halves lines in place, the coarse half first, or puts them together again.
void lift_across(const LineBlock& block, bool inverse, std::vector<float>& scratch);
void lift_along(const LineBlock& block, bool inverse, std::vector<float>& scratch);

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// The coefficients of a slice on BCC as one dense array, its axes in any order, with the mirror images beyond
// the ends, so that stencils read rows without a question.
#pragma once

#include <array>
#include <cstddef>

#include "base/aligned.h"
#include "field/slice.h"

namespace bccsplat::bench {

struct SiteArray {
  std::array<size_t, 3> axes{0, 1, 2};   // of the lattice: along a row, from row to row, from layer to layer
  std::ptrdiff_t row = 0, layer = 0;     // floats from one to the next, the same for both cosets
  std::array<std::ptrdiff_t, 2> first{}; // per coset: its site (0, 0, 0)
  AlignedArray<float> values;            // relative to the base
  size_t floats = 0;

  [[nodiscard]] std::ptrdiff_t at(int coset, int u, int v, int w) const {
    return first[coset] + w * layer + v * row + u;
  }
};

// margin: planes beyond the ends that are there.
[[nodiscard]] SiteArray make_site_array(const Slice& slice, const std::array<size_t, 3>& axes, int margin);

} // namespace bccsplat::bench

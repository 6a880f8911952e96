// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/stencils/site_array.h"

#include <algorithm>
#include <vector>

namespace bccsplat::bench {
namespace {

// Vectors of the last blocks of a row may be read so far beyond it.
constexpr int spare = 80;

} // namespace

SiteArray make_site_array(const Slice& slice, const std::array<size_t, 3>& axes, int margin) {
  const Lattice3& lattice = slice.lattice;
  SiteArray a;
  a.axes = axes;
  const int before = margin / 2 + 1;
  const Int3 dims = lattice.dims(0);
  std::array<int, 3> size;
  for (size_t n = 0; n < 3; ++n) size[n] = dims[axes[n]] + 2 * before;
  a.row = (size[0] + spare + 15) / 16 * 16;
  a.layer = a.row * size[1];
  const std::ptrdiff_t coset = a.layer * size[2];
  a.floats = 2 * coset + a.row;
  a.values.reserve(a.floats);
  std::fill_n(a.values.data(), a.floats, 0.0f);
  for (int c = 0; c < 2; ++c) {
    const std::vector<float> dense = layer_to_dense(slice.coset[c]);
    const Int3 sites = lattice.dims(c);
    const std::array<std::ptrdiff_t, 3> stride{1, sites[0], std::ptrdiff_t{sites[0]} * sites[1]};
    std::array<std::vector<std::ptrdiff_t>, 3> from; // by place along each axis of the array
    for (size_t n = 0; n < 3; ++n)
      for (int i = 0; i < size[n]; ++i)
        from[n].push_back(stride[axes[n]] * lattice.mirror(axes[n], c, i - before));
    a.first[c] = c * coset + before * (a.layer + a.row + 1);
    float* to = a.values.data() + c * coset;
    for (const std::ptrdiff_t w : from[2])
      for (const std::ptrdiff_t v : from[1]) {
        const float* const line = dense.data() + w + v;
        for (size_t u = 0; u < from[0].size(); ++u) to[u] = line[from[0][u]];
        to += a.row;
      }
  }
  return a;
}

} // namespace bccsplat::bench

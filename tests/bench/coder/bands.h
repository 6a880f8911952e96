// SPDX-License-Identifier: Apache-2.0
// Where the coefficients of a slab are: bands of the chain, cut into chunks that are decoded alone.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "tests/bench/coder/wavelet.h"

namespace bccsplat::bench {

// The coefficients of one level and direction within a chunk: a box of the frame.
struct BandBox {
  int level = 0;     // 1: the finest; the coarse rest has the number of levels
  int direction = 0; // bit a: fine along axis a; 0: the coarse rest
  std::array<int, 3> begin{}, size{};
  [[nodiscard]] bool empty() const { return size[0] <= 0 || size[1] <= 0 || size[2] <= 0; }
};

inline constexpr int chunk_levels =
    2; // the finest, which are cut into chunks; all coarser ones are one chunk

// What all chunks of a slab need: the coarse rest, and the coarser levels down to those that are cut.
[[nodiscard]] std::vector<BandBox> coarse_bands(const Chain& chain);
// The chunk at a position, edge samples of the source wide, from its coarsest band to its finest.
[[nodiscard]] std::vector<BandBox> chunk_bands(const Chain& chain, const std::array<int, 3>& position,
                                               int edge);
[[nodiscard]] std::array<int, 3> chunk_counts(const Chain& chain, int edge);

// Magnitudes of a band of all layers of a chunk, with a rim of zeros for those that ask for neighbours.
class BandMagnitudes {
 public:
  BandMagnitudes() = default;
  BandMagnitudes(const BandBox& box, int layers);
  // The row at y, z of layer k, each from -2 to one (k: none) past the end.
  [[nodiscard]] uint16_t* row(int k, int z, int y) {
    return values_.data() + 2 + ((size_t(k + 2) * depth_ + z + 2) * height_ + y + 2) * width_;
  }
  [[nodiscard]] bool absent() const { return values_.empty(); }

 private:
  size_t width_ = 0, height_ = 0, depth_ = 0;
  std::vector<uint16_t> values_;
};

} // namespace bccsplat::bench

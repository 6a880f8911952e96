// SPDX-License-Identifier: Apache-2.0
// Where the coefficients of each level and direction are, and the magnitudes of those that are known.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "formats/bcc4/wavelet/halvings.h"

namespace bccsplat {

// The coefficients of one level and direction: a box of every layer.
struct BandBox {
  int level = 0;     // 1: the finest; the coarse rest has the number of levels
  int direction = 0; // bit a: fine along axis a; 0: the coarse rest
  std::array<int, 3> begin{}, size{};
  [[nodiscard]] bool empty() const { return size[0] <= 0 || size[1] <= 0 || size[2] <= 0; }
};

// The bands, in the order in which they are coded: the coarse rest, then from the coarsest level to the
// finest, directions 1 to 7.
[[nodiscard]] std::vector<BandBox> bands_of(const Halvings& shape);

// Magnitudes of a band in all layers, with a rim of zeros for those that ask for neighbours.
class BandMagnitudes {
 public:
  BandMagnitudes() = default;
  BandMagnitudes(const BandBox& box, int layers);
  // The row at y, z of layer k, each from -2 to one (k: none) past the end.
  [[nodiscard]] uint16_t* row(int k, int z, int y) {
    return values_.data() + rim + row_number(k, z, y) * width_;
  }
  // Whether anything of that row may be other than 0.
  [[nodiscard]] uint8_t& filled(int k, int z, int y) { return filled_[row_number(k, z, y)]; }

 private:
  static constexpr int rim = 2;
  [[nodiscard]] size_t row_number(int k, int z, int y) const {
    return (static_cast<size_t>(k + rim) * depth_ + z + rim) * height_ + y + rim;
  }
  size_t width_ = 0, height_ = 0, depth_ = 0;
  std::vector<uint16_t> values_;
  std::vector<uint8_t> filled_;
};

} // namespace bccsplat

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

// Memory for the magnitudes of a box, which the next one uses again: a walk leaves it all 0.
struct WalkRoom {
  std::vector<uint16_t> values;
  std::vector<uint8_t> filled;
};

// Magnitudes of a band in all layers, with a rim of zeros for those that ask for neighbours, and which rows
// and planes may have anything other than 0.
class BandMagnitudes {
 public:
  BandMagnitudes(const BandBox& box, int layers);
  // What it takes of a room, and where it begins there.
  [[nodiscard]] size_t values() const { return width_ * height_ * depth_ * layers_ + 2 * width_; }
  [[nodiscard]] size_t flags() const { return (height_ + 1) * depth_ * layers_; }
  void place(uint16_t* values, uint8_t* flags);

  // The row at y, z of layer k, each from -2 to one (k: none) past the end.
  [[nodiscard]] uint16_t* row(int k, int z, int y) const {
    return values_ + rim + (plane_number(k, z) * height_ + y + rim) * width_;
  }
  [[nodiscard]] uint8_t filled(int k, int z, int y) const {
    return rows_[plane_number(k, z) * height_ + y + rim];
  }
  [[nodiscard]] uint8_t filled(int k, int z) const { return planes_[plane_number(k, z)]; }
  void fill(int k, int z, int y) {
    const size_t plane = plane_number(k, z);
    rows_[plane * height_ + y + rim] = planes_[plane] = 1;
  }
  // All is 0 again.
  void clear();

 private:
  static constexpr int rim = 2;
  [[nodiscard]] size_t plane_number(int k, int z) const {
    return static_cast<size_t>(k + rim) * depth_ + z + rim;
  }
  size_t width_, height_, depth_, layers_;
  uint16_t* values_ = nullptr;
  uint8_t *rows_ = nullptr, *planes_ = nullptr;
};

} // namespace bccsplat

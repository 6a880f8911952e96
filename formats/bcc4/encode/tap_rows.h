// SPDX-License-Identifier: Apache-2.0
// Sites and their neighbours for least squares, a row for each neighbour, so that products of many sites are
// summed at once.
#pragma once

#include <array>
#include <cstddef>
#include <memory>

#include "formats/bcc4/encode/normal_equations.h"

namespace bccsplat {

// Sums over cells that are whole numbers of at most two bytes: every sum is exact, the same on every target.
class TapRows {
 public:
  // n: neighbours of a site. small: all cells are from -255 to 255.
  TapRows(size_t n, bool small);

  // Adds the sites of a row whose bits are set; the cells of its first site and of that site's neighbours.
  void add(const std::array<const float*, max_taps>& taps, const float* own, unsigned chosen);
  [[nodiscard]] size_t count() const { return count_; } // of sites
  // The sums over all sites so far, as add_samples makes them.
  [[nodiscard]] const NormalEquations& sums();

 private:
  // One lane holds so many products of single bytes: where there is only one lane, it takes them all.
  static constexpr size_t most = 256, stride = most + 16;
  void sum_up();

  size_t n_;
  bool small_;
  NormalEquations equations_;
  std::unique_ptr<float[]> cells_; // NormalEquations::rows rows
  size_t held_ = 0, count_ = 0;
};

} // namespace bccsplat

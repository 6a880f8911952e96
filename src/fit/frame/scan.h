// SPDX-License-Identifier: Apache-2.0
// One pass over a frame before it is resampled: where it is not air, its range, and what is not finite.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "base/context.h"
#include "fit/frame/frame.h"

namespace bccsplat {

// Ranges of the samples, relative to air, in cells of 16 x 8 x 8 samples.
class CellRanges {
 public:
  static constexpr std::array<int64_t, 3> edge{16, 8, 8};
  struct Cell {
    float low = std::numeric_limits<float>::infinity(), high = -low; // of the finite samples
    bool broken = false;                                             // not all samples are finite
    [[nodiscard]] bool air() const { return !broken && low == 0 && high == 0; }
  };
  CellRanges() = default;
  explicit CellRanges(const std::array<int64_t, 3>& dims);

  [[nodiscard]] const std::array<int64_t, 3>& count() const { return count_; }
  [[nodiscard]] size_t index(int64_t x, int64_t y, int64_t z) const {
    return (z * count_[1] + y) * count_[0] + x;
  }
  // Bounds of the samples in a region: of the cells it touches.
  [[nodiscard]] Cell range(const Region& region) const;
  std::vector<Cell> cell; // by index()

 private:
  std::array<int64_t, 3> count_{};
};

// Returns a region widened to whole cells of a frame of n samples.
[[nodiscard]] Region whole_cells(const Region& region, const std::array<int64_t, 3>& n);

struct FrameScan {
  CellRanges cells;
  uint64_t relevant = 0; // finite samples further than the threshold from air (0: other than air)
  uint64_t nonfinite = 0;
  uint64_t finite = 0;                      // uncovered air included
  double low = 0, high = 0;                 // absolute range of the finite samples; 0..0 when there are none
  std::array<int64_t, 3> first_nonfinite{}; // in the order of the array
  Region nonfinite_region;                  // bounding box of those that are given; empty: none
  Reservation memory;                       // of the cells
};

// counted: the samples that are counted, and whose range is told; null: all that are given.
[[nodiscard]] FrameScan scan_frame(const Frame& frame, float threshold, const Context& context,
                                   const Region* counted = nullptr);

} // namespace bccsplat

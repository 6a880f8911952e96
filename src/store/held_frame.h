// SPDX-License-Identifier: Apache-2.0
// A source frame kept for comparison, in the precision in which it came.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/memory.h"
#include "fit/frame/frame.h"

namespace bccsplat {

// Samples whose indices `every` divides, from number `begin` of these on along each axis.
struct HeldGrid {
  std::array<int64_t, 3> begin{}, dims{};
  int64_t every = 1;
  // The index in the frame of one of them, counted from `begin`.
  [[nodiscard]] std::array<uint64_t, 3> sample(const std::array<int64_t, 3>& i) const {
    std::array<uint64_t, 3> at{};
    for (size_t a = 0; a < 3; ++a) at[a] = (begin[a] + i[a]) * every;
    return at;
  }
};
// Returns the grid of a region.
[[nodiscard]] HeldGrid held_grid(const Region& region, int64_t every);

class HeldFrame {
 public:
  // Copies the samples of the grid. air: what no box covers.
  HeldFrame(std::span<const FrameBox> boxes, double air, MemoryBudget& memory, const HeldGrid& grid);

  [[nodiscard]] const HeldGrid& grid() const { return grid_; }
  // Absolute values of plane z of the grid, x fastest; NaN and infinities as they are.
  void plane(int64_t z, double* out) const;

 private:
  struct Box {
    SourceType type;
    std::array<int64_t, 3> begin, dims;
    std::vector<std::byte> data; // packed
  };
  HeldGrid grid_;
  std::vector<Box> boxes_;
  double air_;
  Reservation memory_;
};

} // namespace bccsplat

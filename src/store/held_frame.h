// SPDX-License-Identifier: Apache-2.0
// A source frame kept for comparison, in the precision in which it came.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "base/memory.h"
#include "fit/frame.h"

namespace bccsplat {

class HeldFrame {
 public:
  // Copies the samples, or those whose indices `every` divides. air: what no box covers.
  HeldFrame(std::span<const FrameBox> boxes, double air, MemoryBudget& memory, int64_t every = 1);

  // Absolute values of plane z of the samples held, `nx` x `ny` of them, x fastest; NaN and infinities as
  // they are.
  void plane(int64_t z, int64_t nx, int64_t ny, double* out) const;

 private:
  struct Box {
    SourceType type;
    std::array<int64_t, 3> begin, dims;
    std::vector<std::byte> data; // packed
  };
  std::vector<Box> boxes_;
  double air_;
  Reservation memory_;
};

} // namespace bccsplat

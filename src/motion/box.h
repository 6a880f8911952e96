// SPDX-License-Identifier: Apache-2.0
// A frame as dense samples, and coarser copies of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/vec.h"

namespace bccsplat::motion {

struct Box {
  Int3 dims{};
  std::vector<float> values; // x fastest

  [[nodiscard]] size_t index(int32_t x, int32_t y, int32_t z) const {
    return (static_cast<size_t>(z) * dims[1] + y) * dims[0] + x;
  }
};

// Every second sample along an axis, after a smoothing by 1 4 6 4 1: sample i lies where 2 i did.
[[nodiscard]] Box halved(const Box& box, size_t axis);

// A coarser copy of a frame.
struct Level {
  Box box;
  Int3 factor{1, 1, 1}; // samples of the frame from one of the level to the next
};
// The finest first: a quarter of the resolution along each axis that is long enough, then halves of it.
[[nodiscard]] std::vector<Level> make_pyramid(const Box& frame);

} // namespace bccsplat::motion

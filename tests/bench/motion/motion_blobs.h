// SPDX-License-Identifier: Apache-2.0
// Round blobs that move as they are told.
#pragma once

#include <cstdint>
#include <string>

#include "tests/bench/motion/motion_set.h"

namespace bccsplat::bench {

enum class BlobWays : uint8_t {
  apart,    // straight, each in its own lane, every second one backwards
  growing,  // as these, and twice as wide at the end as at the beginning
  crossing, // two in each lane, through each other
  circles   // two on each circle, one each way round
};
inline constexpr int blob_ways = 4;
[[nodiscard]] std::string name_of(BlobWays ways);

// Frames of edge^3 voxels in which blobs move by `speed` voxels from each to the next; moments halfway are
// left out.
[[nodiscard]] MotionSet moving_blobs(BlobWays ways, double speed, uint32_t edge);

} // namespace bccsplat::bench

// SPDX-License-Identifier: Apache-2.0
// Passes over frames: ranges, how much of a series is air, and what is missing.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "series/frame_reader.h"

namespace bccsplat::series {

struct ChannelScan {
  double min = std::numeric_limits<double>::infinity(); // of finite values, air included where it occurs
  double max = -std::numeric_limits<double>::infinity();
  uint64_t samples = 0;
  uint64_t relevant = 0;    // further than the threshold from air, non-finite ones included
  uint64_t nonfinite = 0;   // as 32-bit floats, which is what the library reads values as
  uint64_t beyond = 0;      // of these: finite doubles
  uint64_t first_frame = 0; // of the first non-finite value
  std::array<uint64_t, 3> first_voxel{};
  std::vector<uint64_t> missing; // frames without any finite value
  [[nodiscard]] bool empty() const { return min > max; }
};

// Adds a frame. Values that no box covers count as air.
void scan_frame(const Frame& frame, uint64_t number, const std::array<uint64_t, 4>& dims, double air,
                double air_threshold, ChannelScan& scan);
// The same of a frame that does not fit the memory.
void scan_large_frame(FrameReader& reader, uint64_t number, size_t channel, double air, double air_threshold,
                      ChannelScan& scan);

// Values of a frame that are not finite as 32-bit floats.
[[nodiscard]] uint64_t count_nonfinite(const Frame& frame);

} // namespace bccsplat::series

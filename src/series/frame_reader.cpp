// SPDX-License-Identifier: Apache-2.0
#include "series/frame_reader.h"

#include <algorithm>

namespace bccsplat::series {

void gather_plane(const Frame& frame, const std::array<uint64_t, 4>& dims, uint64_t z, double air,
                  double* plane) {
  std::fill(plane, plane + dims[0] * dims[1], air);
  for (const Box& box : frame.boxes) {
    if (z < box.begin[2] || z - box.begin[2] >= box.dims[2]) continue;
    visit_type(box.type, [&](auto zero) {
      for (uint64_t j = 0; j < box.dims[1]; ++j) {
        const std::byte* from = box.data + j * box.stride_bytes[1] + (z - box.begin[2]) * box.stride_bytes[2];
        double* to = plane + (box.begin[1] + j) * dims[0] + box.begin[0];
        for (uint64_t i = 0; i < box.dims[0]; ++i)
          to[i] = load_as<decltype(zero)>(from + i * box.stride_bytes[0]);
      }
    });
  }
}

bool is_scattered(const SeriesDescription& series) {
  constexpr double large = 0x1p30, next_to_nothing = 1.0 / 256; // samples of a frame, and their share
  const double samples = static_cast<double>(series.dims[0]) * static_cast<double>(series.dims[1]) *
                         static_cast<double>(series.dims[2]);
  uint64_t most = 0;
  for (const Channel& channel : series.channels) {
    if (channel.active.empty()) return false;
    most = std::max(most, *std::max_element(channel.active.begin(), channel.active.end()));
  }
  return samples > large && static_cast<double>(most) < next_to_nothing * samples;
}

} // namespace bccsplat::series

// SPDX-License-Identifier: Apache-2.0
#include "series/scan.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

namespace bccsplat::series {
namespace {

// Scans a row of integers, which are all finite.
template<class T>
void scan_integers(const std::byte* row, uint64_t count, int64_t stride, double air, double air_threshold,
                   ChannelScan& scan) {
  T low = std::numeric_limits<T>::max(), high = std::numeric_limits<T>::lowest();
  uint64_t relevant = 0;
  for (uint64_t i = 0; i < count; ++i) {
    T v;
    std::memcpy(&v, row + static_cast<int64_t>(i) * stride, sizeof v);
    low = std::min(low, v), high = std::max(high, v);
    relevant += std::abs(static_cast<double>(v) - air) > air_threshold;
  }
  if (count == 0) return;
  scan.min = std::min(scan.min, static_cast<double>(low));
  scan.max = std::max(scan.max, static_cast<double>(high));
  scan.relevant += relevant;
}

} // namespace

void scan_frame(const Frame& frame, uint64_t number, const std::array<uint64_t, 4>& dims, double air,
                double air_threshold, ChannelScan& scan) {
  const uint64_t samples = dims[0] * dims[1] * dims[2];
  uint64_t covered = 0;
  const uint64_t nonfinite = scan.nonfinite;
  for (const Box& box : frame.boxes) {
    covered += box.samples();
    visit_type(box.type, [&](auto zero) {
      for (uint64_t k = 0; k < box.dims[2]; ++k)
        for (uint64_t j = 0; j < box.dims[1]; ++j) {
          const std::byte* row = box.data + j * box.stride_bytes[1] + k * box.stride_bytes[2];
          if constexpr (std::is_integral_v<decltype(zero)>) {
            scan_integers<decltype(zero)>(row, box.dims[0], box.stride_bytes[0], air, air_threshold, scan);
            continue;
          }
          for (uint64_t i = 0; i < box.dims[0]; ++i) {
            const double v = load_as<decltype(zero)>(row + i * box.stride_bytes[0]);
            if (std::isfinite(static_cast<float>(v))) {
              scan.min = std::min(scan.min, v);
              scan.max = std::max(scan.max, v);
              scan.relevant += std::abs(v - air) > air_threshold;
            } else {
              if (scan.nonfinite++ == 0) {
                scan.first_frame = number;
                scan.first_voxel = {box.begin[0] + i, box.begin[1] + j, box.begin[2] + k};
              }
              scan.beyond += std::isfinite(v);
              ++scan.relevant;
            }
          }
        }
    });
  }
  scan.samples += samples;
  if (scan.nonfinite - nonfinite == samples) scan.missing.push_back(number);
  if (covered < samples && std::isfinite(air)) {
    scan.min = std::min(scan.min, air);
    scan.max = std::max(scan.max, air);
  }
}

void scan_large_frame(FrameReader& reader, uint64_t number, size_t channel, double air, double air_threshold,
                      ChannelScan& scan) {
  constexpr uint64_t bytes_at_once = 16 << 20;
  const SeriesDescription& s = reader.description();
  const uint64_t plane = frame_bytes(s, channel) / s.dims[2], samples = s.dims[0] * s.dims[1] * s.dims[2];
  const uint64_t planes = std::clamp<uint64_t>(bytes_at_once / plane, 1, s.dims[2]);
  const std::vector<uint64_t> missing = scan.missing; // of whole frames
  const uint64_t nonfinite = scan.nonfinite;
  for (uint64_t z = 0; z < s.dims[2]; z += planes) {
    const SampleBox box{{0, 0, z}, {s.dims[0], s.dims[1], std::min(planes, s.dims[2] - z)}};
    scan_frame(reader.read_box(number, channel, box), number, {s.dims[0], s.dims[1], box.dims[2], 1}, air,
               air_threshold, scan);
  }
  scan.missing = missing;
  if (scan.nonfinite - nonfinite == samples) scan.missing.push_back(number);
}

uint64_t count_nonfinite(const Frame& frame) {
  uint64_t count = 0;
  for (const Box& box : frame.boxes) {
    if (!is_float(box.type)) continue;
    visit_type(box.type, [&](auto zero) {
      for (uint64_t k = 0; k < box.dims[2]; ++k)
        for (uint64_t j = 0; j < box.dims[1]; ++j) {
          const std::byte* row = box.data + j * box.stride_bytes[1] + k * box.stride_bytes[2];
          for (uint64_t i = 0; i < box.dims[0]; ++i)
            count +=
                !std::isfinite(static_cast<float>(load_as<decltype(zero)>(row + i * box.stride_bytes[0])));
        }
    });
  }
  return count;
}

} // namespace bccsplat::series

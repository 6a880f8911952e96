#include "readers/scan.h"

#include <algorithm>
#include <cmath>

namespace bcc4 {

void scan_frame(const Frame& frame, uint64_t number, const std::array<uint64_t, 4>& dims, double air,
                double air_threshold, ChannelScan& scan) {
  const uint64_t samples = dims[0] * dims[1] * dims[2];
  uint64_t covered = 0;
  const uint64_t nonfinite = scan.nonfinite;
  for (const Box& box : frame.boxes) {
    covered += static_cast<uint64_t>(box.dims[0] * box.dims[1] * box.dims[2]);
    visit_type(box.type, [&](auto zero) {
      for (int64_t k = 0; k < box.dims[2]; ++k)
        for (int64_t j = 0; j < box.dims[1]; ++j) {
          const std::byte* row = box.data + j * box.stride_bytes[1] + k * box.stride_bytes[2];
          for (int64_t i = 0; i < box.dims[0]; ++i) {
            const double v = load_as<decltype(zero)>(row + i * box.stride_bytes[0]);
            if (std::isfinite(v)) {
              scan.min = std::min(scan.min, v);
              scan.max = std::max(scan.max, v);
              scan.relevant += std::abs(v - air) > air_threshold;
            } else {
              if (scan.nonfinite++ == 0) {
                scan.first_frame = number;
                for (size_t a = 0; a < 3; ++a)
                  scan.first_voxel[a] = static_cast<uint64_t>(box.begin[a] + (a == 0 ? i : a == 1 ? j : k));
              }
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

} // namespace bcc4

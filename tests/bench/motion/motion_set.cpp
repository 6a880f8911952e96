// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/motion/motion_set.h"

#include <algorithm>
#include <numeric>

#include "base/text.h"
#include "motion/shares.h"

namespace bccsplat::bench {

double MotionSet::index(double time) const {
  const size_t i = motion::interval_of(times, time);
  return static_cast<double>(i) + (time - times[i]) / (times[i + 1] - times[i]);
}

std::vector<double> even_times(uint32_t frames) {
  std::vector<double> times(frames);
  std::iota(times.begin(), times.end(), 0.0);
  return times;
}

MotionSet every(const FitSource& source, uint32_t step, const std::vector<double>& times, double wanted,
                double longest) {
  MotionSet set{
      {concat(source.name, ", 1 frame of ", step), source.dims, source.type, {}}, {}, {}, 0, wanted};
  const uint32_t intervals = (source.dims[3] - 1) / step;
  set.kept.dims[3] = intervals + 1;
  float low = INFINITY, high = -INFINITY;
  for (uint32_t t = 0; t <= intervals * step; ++t) {
    std::vector<float> frame = source.frame(t);
    const auto [l, h] = std::minmax_element(frame.begin(), frame.end());
    low = std::min(low, *l), high = std::max(high, *h);
    if (t % step == 0) {
      const auto bytes = source.bytes.begin() + static_cast<std::ptrdiff_t>(t * source.frame_bytes());
      const auto size = static_cast<std::ptrdiff_t>(source.frame_bytes());
      set.kept.bytes.insert(set.kept.bytes.end(), bytes, bytes + size);
      set.times.push_back(times[t]);
    } else if (const uint32_t before = t - t % step; times[before + step] - times[before] <= longest) {
      set.left_out.push_back({times[t], std::move(frame)});
    }
  }
  set.peak = double{high} - low;
  return set;
}

} // namespace bccsplat::bench

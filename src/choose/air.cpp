// SPDX-License-Identifier: Apache-2.0
#include "choose/air.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "series/frame_planes.h"
#include "series/text.h"

namespace bccsplat::series {
namespace {

constexpr double kShareOfAir = 1.0 / 256; // of the samples; with more of it, air is what is empty
// Standard deviations: a mean this near to air has it among the values already.
constexpr double kNearAir = 0.5;
// Standard deviation over mean: a channel with less is a constant, and what else will come is not known.
constexpr double kConstant = 1e-6;

// The share of samples that must hold the smallest value before it counts as empty space (CT: -1000).
constexpr double kShareOfSmallest = 1.0 / 4;

struct Moments {
  double count = 0, air = 0, sum = 0, squares = 0; // relative to air
  double smallest = std::numeric_limits<double>::infinity(), of_smallest = 0;
};

Moments moments_of(FramePlanes planes, const std::array<uint64_t, 4>& dims, double air, Watch& watch) {
  Moments m;
  std::vector<double> plane(dims[0] * dims[1]);
  for (uint64_t z = 0; z < dims[2]; ++z) {
    watch.go_on();
    planes.gather(z, air, plane.data());
    for (const double v : plane) {
      if (!std::isfinite(v)) continue;
      const double d = v - air;
      m.count += 1, m.air += d == 0 ? 1 : 0, m.sum += d, m.squares += d * d;
      if (v < m.smallest) m.smallest = v, m.of_smallest = 0;
      m.of_smallest += v == m.smallest ? 1 : 0;
    }
  }
  return m;
}

} // namespace

std::map<std::string, double> dense_air(FrameReader& reader, const WriterSettings& settings,
                                        const std::set<std::string>& said, Watch& watch) {
  const SeriesDescription& s = reader.description();
  std::map<std::string, double> air;
  // Who says what air is, or how near to it is empty, is believed.
  if (settings.air || settings.air_threshold > 0) return air;
  for (size_t c = 0; c < s.channels.size(); ++c) {
    const Channel& channel = s.channels[c];
    if (!is_float(channel.type) || said.contains(channel.name)) continue;
    const double empty = air_of(channel, settings);
    const Moments m = moments_of(FramePlanes(reader, 0, c), s.dims, empty, watch);
    if (m.count == 0 || m.air > kShareOfAir * m.count) continue;
    const double mean = m.sum / m.count, variance = m.squares / m.count - mean * mean;
    const double deviation = std::sqrt(std::max(variance, 0.0));
    if (!std::isfinite(m.squares) || !(deviation > kConstant * std::fabs(mean))) continue;
    if (m.of_smallest >= kShareOfSmallest * m.count) {
      air[channel.name] = m.smallest;
      continue;
    }
    if (!(std::fabs(mean) > kNearAir * deviation)) continue;
    const double step = std::pow(10, std::floor(std::log10(deviation))); // a number to be read
    air[channel.name] = std::round((empty + mean) / step) * step;
  }
  return air;
}

} // namespace bccsplat::series

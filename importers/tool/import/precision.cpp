// SPDX-License-Identifier: Apache-2.0
#include "tool/import/precision.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "readers/text.h"
#include "series/frame_planes.h"

namespace bcc4 {
namespace {

constexpr double kSeen = 1.0 / 512; // of the range of the values: half a step of 8 bits

struct Rounding {
  double low = HUGE_VAL, high = -HUGE_VAL;
  double most = 0; // |value - float|
};

Rounding rounding_of(FramePlanes planes, const std::array<uint64_t, 4>& dims, Watch& watch) {
  Rounding r;
  std::vector<double> plane(dims[0] * dims[1]);
  for (uint64_t z = 0; z < dims[2]; ++z) {
    watch.go_on();
    planes.gather(z, std::numeric_limits<double>::quiet_NaN(), plane.data());
    for (const double v : plane) {
      const double rounded = static_cast<float>(v);
      if (!std::isfinite(rounded)) continue;
      r.low = std::min(r.low, v), r.high = std::max(r.high, v);
      r.most = std::max(r.most, std::abs(rounded - v));
    }
  }
  return r;
}

} // namespace

std::vector<std::string> precision_warnings(FrameReader& reader, Watch& watch) {
  const SeriesDescription& s = reader.description();
  std::vector<std::string> warnings;
  for (size_t c = 0; c < s.channels.size(); ++c) {
    const Channel& channel = s.channels[c];
    const bool whole = has_wide_integers(channel);
    if (!whole && channel.type != Type::f64) continue;
    const Rounding r = rounding_of(FramePlanes(reader, 0, c), s.dims, watch);
    if (!(r.most > (whole ? 0 : kSeen * (r.high - r.low)))) continue;
    warnings.push_back(concat(
        "channel '", channel.name, "': its values, ", r.low, " to ", r.high,
        ", are stored as 32-bit floats, which is off by up to ", short_number(r.most, 3),
        whole ? ": whole numbers are exact up to 16777216" : ": subtract what they have in common first"));
  }
  return warnings;
}

} // namespace bcc4

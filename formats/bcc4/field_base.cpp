// SPDX-License-Identifier: Apache-2.0
#include "formats/bcc4/field_base.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bccsplat {

namespace {

// How much further down or up all values are; 0 where some are on either side.
double distance(float air, const Range& values) {
  const auto at = static_cast<double>(air);
  return std::max({values.low - at, at - values.high, 0.0});
}

bool has_no_air(const VolumeInfo& info, const ChannelInfo& channel) {
  if (channel.sites_kept == static_cast<uint64_t>(info.lattice.sites())) return true;
  // Of a part what other parts hold is left out as well.
  return channel.sites_kept > 0 && !channel.masks.empty() && !info.part &&
         is_far(channel.air, channel.source_range) &&
         distance(channel.air, channel.source_range) > static_cast<double>(channel.threshold);
}

} // namespace

bool is_far(float air, const Range& values) {
  const bool floats = std::max(std::fabs(values.low), std::fabs(values.high)) <=
                      static_cast<double>(std::numeric_limits<float>::max()); // not so in a damaged file
  return floats && distance(air, values) > values.high - values.low;
}

float middle(const Range& values) { return static_cast<float>(values.low / 2 + values.high / 2); }

float field_base(const VolumeInfo& info, const ChannelInfo& channel) {
  const bool corrected = channel.residuals.any() || channel.residuals.bound > 0;
  return !corrected && is_far(channel.air, channel.kept_range) && has_no_air(info, channel)
             ? middle(channel.kept_range)
             : channel.air;
}

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
#include "formats/bcc4/field_base.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace bccsplat {

namespace {

float middle(const Range& values) { return static_cast<float>(values.low / 2 + values.high / 2); }

// Returns how much further down or up all values are; 0 where some are on either side.
double distance(float air, const Range& values) {
  const double at = air;
  return std::max({values.low - at, at - values.high, 0.0});
}

// Returns whether air is further from all values of a range than `times` their distance from each other.
bool is_far(float air, const Range& values, double times) {
  const bool floats = std::max(std::fabs(values.low), std::fabs(values.high)) <=
                      std::numeric_limits<float>::max(); // not so in a damaged file
  return floats && distance(air, values) > times * (values.high - values.low);
}

// Returns whether sites that are left out are missing data.
bool leaves_out_missing(const VolumeInfo& info, const ChannelInfo& channel) {
  // What other parts of the series hold is left out of a part as well.
  return channel.sites_kept > 0 && !channel.masks.empty() && !info.part &&
         is_far(channel.air, channel.source_range, 1) &&
         distance(channel.air, channel.source_range) > channel.threshold;
}

// A file may tell nothing but their range.
StoredValues values_of(const ChannelInfo& channel) {
  StoredValues values{channel.kept_range, channel.kept_range, middle(channel.kept_range)};
  std::array<std::optional<double>, most_percent.size()> at;
  for (size_t i = 0; i < at.size(); ++i)
    for (const Percentile& p : channel.percentiles)
      if (p.percent == most_percent[i]) at[i] = p.value;
  if (at[0] && at[1] && at[2]) values.most = {*at[0], *at[2]}, values.median = static_cast<float>(*at[1]);
  return values;
}

} // namespace

bool is_far(float air, const StoredValues& values) {
  return is_far(air, values.all, 1) || is_far(air, values.most, 8);
}

bool nearly_all(uint64_t kept, uint64_t sites) { return kept > 0 && kept >= sites - sites / 16; }

FieldBase field_base(const VolumeInfo& info, const ChannelInfo& channel) {
  if (channel.residuals.base) return {*channel.residuals.base, true};
  const bool corrected = channel.residuals.any() || channel.residuals.bound > 0;
  const StoredValues values = values_of(channel);
  if (corrected || info.part || !is_far(channel.air, values)) return {channel.air};
  if (leaves_out_missing(info, channel)) return {values.median};
  return nearly_all(channel.sites_kept, info.lattice.sites()) ? FieldBase{values.median, true}
                                                              : FieldBase{channel.air};
}

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// The value that the field of a channel is built up from.
//
// A kernel's sum over the sites ripples about 1, and so does a constant, by a share of its distance from the
// base of the field: base + sum of (c - base) K. The sum is linear: where no site is left out any base gives
// the same field but for that ripple, and a base among the values does away with it. Where many sites are
// left out, the base is air, and they are exactly that. Where few are, the sum takes them like stored values
// of air.
#pragma once

#include <array>
#include <cstdint>

#include "formats/bcc4/info.h"

namespace bccsplat {

// The percentiles of the stored samples between which nine tenths of them lie, and the median, which samples
// beside a gap do not move.
inline constexpr std::array<double, 3> most_percent{5, 50, 95};
struct StoredValues {
  Range all, most; // most: nine tenths
  float median = 0;
};
// Returns whether air is further from all values than these are apart, or eight times as far from most.
[[nodiscard]] bool is_far(float air, const StoredValues& values);

// Returns whether nearly all sites are stored: then a base among them is worth more than exact air.
[[nodiscard]] bool nearly_all(uint64_t kept, uint64_t sites);

struct FieldBase {
  float value = 0;
  // What a site that is not stored counts for: air where some are air beside another base, else the base.
  bool absent_is_air = false;
};

// Returns air, or the median where air is far from most samples and hardly any site is air: where all sites
// are stored, or all but a few, which stay air, or all but missing data, which masks tell while no source
// sample is near air. Corrections are differences from the field above the base that is stored with them,
// else above air; then that is the base.
[[nodiscard]] FieldBase field_base(const VolumeInfo& info, const ChannelInfo& channel);

} // namespace bccsplat

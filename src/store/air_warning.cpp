// SPDX-License-Identifier: Apache-2.0
#include "store/air_warning.h"

#include <algorithm>
#include <cmath>

#include "base/text.h"

namespace bccsplat {
namespace {

// Largest error of a constant 1 with the default kernel (`bccsplat_bench kernels --constants`).
constexpr double ripple = 0.0024;
// Ranges of the values: further away the ripple is more than 2 % of what they differ by.
constexpr double too_far = 8;
// Steps coarser than this share of the range of the values are seen.
constexpr double too_coarse = 1.0 / 256;

// Returns the step from one float of the type to the next, at a magnitude.
double float_step(ValueType type, double magnitude) {
  const int digits = type == ValueType::f16 ? 10 : 23;
  return std::ldexp(1, std::ilogb(magnitude) - digits);
}

} // namespace

std::string air_warning(const ChannelInfo& channel, const FitChannelReport& counted) {
  if (!counted.any_finite || counted.sites_kept < counted.sites_total) return {};
  const Range& values = counted.source_range;
  const double air = channel.air;
  const double distance = std::max(std::fabs(values.low - air), std::fabs(values.high - air)),
               range = values.high - values.low;
  if (!(distance > too_far * range)) return {};
  const auto warn = [&](const auto&... of_what) {
    return concat("channel '", channel.name, "': its values, ", values.low, " to ", values.high,
                  ", are far from its air, ", air, ": ", of_what..., "; an air among them does away with it");
  };
  if (channel.residuals.local && !channel.residuals.base)
    return warn("the default kernel brings them back with a ripple of up to ",
                static_cast<float>(ripple * distance),
                ", which corrections take back at source samples only");
  const double step = float_step(channel.type, distance);
  if (is_float(channel.type) && step > too_coarse * range && range > 0)
    return warn("they are stored relative to it, as floats in steps of ", static_cast<float>(step));
  return {};
}

} // namespace bccsplat

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

} // namespace

std::string air_warning(const ChannelInfo& channel, const FitChannelReport& counted) {
  if (!counted.any_finite || counted.sites_kept < counted.sites_total) return {};
  const Range& values = counted.source_range;
  const auto air = static_cast<double>(channel.air);
  const double distance = std::max(std::fabs(values.low - air), std::fabs(values.high - air));
  if (!(distance > too_far * (values.high - values.low))) return {};
  return concat("channel '", channel.name, "': its values, ", values.low, " to ", values.high,
                ", are far from its air, ", air,
                ": the default kernel brings them back with a ripple of up to ",
                static_cast<float>(ripple * distance), "; an air among them does away with it");
}

} // namespace bccsplat

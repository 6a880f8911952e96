// SPDX-License-Identifier: Apache-2.0
#include "formats/bcc4/level_error.h"

#include <algorithm>
#include <cmath>

namespace bccsplat {

const MeasuredError* find_error(const VolumeInfo& info, uint32_t channel, uint32_t level,
                                MeasuredError::Kind kind) {
  const auto e = std::find_if(info.errors.begin(), info.errors.end(), [&](const MeasuredError& each) {
    return each.channel == channel && each.level == level && each.kind == kind;
  });
  return e != info.errors.end() && e->samples > 0 && e->range > 0 ? &*e : nullptr;
}

std::optional<LevelError> level_error(const VolumeInfo& info, uint32_t channel, uint32_t level) {
  const MeasuredError* const e = find_error(info, channel, level);
  if (!e) return std::nullopt;
  const MeasuredError* finest = find_error(info, channel, 0, MeasuredError::corrected);
  if (!finest) finest = find_error(info, channel, 0);
  const double own = finest ? finest->rmse : 0;
  double square = std::max(0.0, e->rmse * e->rmse - own * own);
  // Where nothing is kept there is no error.
  if (const uint64_t kept = info.channels[channel].sites_kept)
    square *= static_cast<double>(info.lattice.sites()) / static_cast<double>(kept);
  return LevelError{std::sqrt(square) / e->range, e->largest / e->range};
}

} // namespace bccsplat

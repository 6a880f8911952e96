// SPDX-License-Identifier: Apache-2.0
#include "tool/view/exposure.h"

#include <algorithm>
#include <cstddef>

#include "readers/error.h"
#include "tool/view/time_slice.h"

namespace bcc4 {

double seconds_per_unit(std::string_view unit) {
  struct Unit {
    double seconds;
    std::array<std::string_view, 5> names;
  };
  // The names are those of UDUNITS and NIfTI.
  constexpr std::array<Unit, 6> units{{{1e-6, {"us", "usec", "microsecond", "microseconds"}},
                                       {1e-3, {"ms", "msec", "millisecond", "milliseconds"}},
                                       {1, {"s", "sec", "second", "seconds", "secs"}},
                                       {60, {"min", "mins", "minute", "minutes"}},
                                       {3600, {"h", "hr", "hrs", "hour", "hours"}},
                                       {86400, {"d", "day", "days"}}}};
  for (const Unit& u : units)
    if (!unit.empty() && std::find(u.names.begin(), u.names.end(), unit) != u.names.end()) return u.seconds;
  return 0;
}

double exposure_seconds(const Volume& volume, const Cut& where, const std::array<double, 2>& trail_frames) {
  const bccsplat_volume_info info = volume_info(volume);
  const double unit = seconds_per_unit(info.time_unit);
  if (!where.is_time_slice || unit == 0) return 0;
  const double last = last_index(info);
  const auto time = [&](double offset) {
    double t = 0;
    check(bccsplat_volume_index_to_time(volume.get(), std::clamp(where.index + offset, 0.0, last), &t),
          "exposure");
    return t;
  };
  const double begin = std::min(trail_frames[0], -where.thickness / 2);
  const double end = std::max(trail_frames[1], where.thickness / 2);
  return begin < end ? unit * (time(end) - time(begin)) : 0;
}

} // namespace bcc4

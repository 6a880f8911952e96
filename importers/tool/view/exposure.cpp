// SPDX-License-Identifier: Apache-2.0
#include "tool/view/exposure.h"

#include <algorithm>
#include <cstddef>

#include "readers/calendar.h"
#include "readers/error.h"
#include "tool/view/time_slice.h"

namespace bcc4 {

double exposure_seconds(const Volume& volume, const Cut& where, const std::array<double, 2>& trail_frames) {
  const bccsplat_volume_info info = volume_info(volume);
  const auto unit = seconds_in(info.time_unit);
  if (!where.is_time_slice || !unit) return 0;
  const double last = last_index(info);
  const auto time = [&](double offset) {
    double t = 0;
    check(bccsplat_volume_index_to_time(volume.get(), std::clamp(where.index + offset, 0.0, last), &t),
          "exposure");
    return t;
  };
  const double begin = std::min(trail_frames[0], -where.thickness / 2);
  const double end = std::max(trail_frames[1], where.thickness / 2);
  return begin < end ? *unit * (time(end) - time(begin)) : 0;
}

} // namespace bcc4

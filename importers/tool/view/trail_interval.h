// SPDX-License-Identifier: Apache-2.0
// What span of time a trail shows, as it is asked for and in frames of the volume that leaves it.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "tool/view/slice_choice.h"

namespace bcc4 {

// The trail's interval relative to the slice: in the unit of --time or in frames, past negative.
struct TrailInterval {
  double from = 0, to = 0;
  bool frames = false;
  uint32_t intervals = 0; // 0: one
};

// "DT[f]" or "A:B[f]".
[[nodiscard]] TrailInterval parse_trail_span(const std::string& option, const std::string& text);

// Beginning and end of the trail of a cut, as bccsplat_trail takes them. index: moments are told by frames.
[[nodiscard]] std::array<double, 2> trail_interval(const TrailInterval& trail, bool index,
                                                   const Volume& volume, const Cut& where);
// The same in frames of another volume that is seen with a time slice of the first. clock: how the first
// one's times become the other's.
[[nodiscard]] std::array<double, 2> trail_interval_beside(const TrailInterval& trail, bool index,
                                                          const Volume& volume, const Cut& where,
                                                          const Volume& other, const ClockChange& clock);

} // namespace bcc4

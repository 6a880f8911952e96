// SPDX-License-Identifier: Apache-2.0
// How long the pictures of a sequence gather light, for programs that read them.
#pragma once

#include <array>

#include "tool/view/slice_choice.h"

namespace bcc4 {

// Seconds that a time slice with a trail over these frames relative to it (both 0: none) and its own
// thickness covers, clipped to the series; 0 for an instant, other hyperplanes and unknown units.
[[nodiscard]] double exposure_seconds(const Volume& volume, const Cut& where,
                                      const std::array<double, 2>& trail_frames);

} // namespace bcc4

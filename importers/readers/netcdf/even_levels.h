// SPDX-License-Identifier: Apache-2.0
// Makes samples evenly spaced along z of levels at uneven places.
#pragma once

#include <memory>
#include <vector>

#include "readers/frame_reader.h"

namespace bcc4 {

// Even samples are taken at begin + k step, k below count. Their distance is that of the closest levels,
// unless that makes more than four times as many.
struct EvenLevels {
  std::vector<double> levels; // of the source; rising or falling strictly
  double begin = 0, step = 1;
  uint64_t count = 0;
};
[[nodiscard]] bool strictly_monotonic(const std::vector<double>& levels);
[[nodiscard]] EvenLevels even_levels(const std::vector<double>& levels);

// Returns the series with its z axis sampled at even levels, linearly between those of the source, as floats.
[[nodiscard]] std::unique_ptr<FrameReader> resample_levels(std::unique_ptr<FrameReader> source,
                                                           const EvenLevels& even);

} // namespace bcc4

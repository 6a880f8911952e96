// SPDX-License-Identifier: Apache-2.0
// A series of which some frames are kept, and those between them known.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/bench/fit/fit_source.h"

namespace bccsplat::bench {

struct LeftOut {
  double time = 0;
  std::vector<float> frame;
};

struct MotionSet {
  FitSource kept;
  std::vector<double> times; // of the kept frames
  std::vector<LeftOut> left_out;
  double peak = 0;   // the range of all values
  double wanted = 0; // dB more than the library's own moment

  // A time as the library counts: whole numbers at kept frames, straight between them.
  [[nodiscard]] double index(double time) const;
};

// What nothing may lose, dB.
inline constexpr double most_lost = .3;

// Every `step`-th frame of a series is kept, and those between them left out; times: of all frames. Left out
// for good are those in intervals that are longer than `longest`.
[[nodiscard]] MotionSet every(const FitSource& source, uint32_t step, const std::vector<double>& times,
                              double wanted = -most_lost, double longest = 1e9);
// 0, 1, 2 ...
[[nodiscard]] std::vector<double> even_times(uint32_t frames);

} // namespace bccsplat::bench

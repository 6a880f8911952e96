// SPDX-License-Identifier: Apache-2.0
// Times the stages of drawing, one after the other.
#pragma once

#include <chrono>

namespace bccsplat {

using StageClock = std::chrono::steady_clock;
[[nodiscard]] inline double ms_since(StageClock::time_point from) {
  return std::chrono::duration<double, std::milli>(StageClock::now() - from).count();
}
// Adds the milliseconds since `from` to `sum` and starts the next stage.
inline void add_lap(StageClock::time_point& from, double& sum) {
  const auto now = StageClock::now();
  sum += std::chrono::duration<double, std::milli>(now - from).count();
  from = now;
}

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// What bounds the sheets and pixels that planned things may touch.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

namespace bccsplat {

// Pixels farther than this from the picture are outside of it whatever the window; sums of a few such numbers
// fit an int.
inline constexpr double farthest_pixel = 1e8;

[[nodiscard]] inline int pixel_number(double p) {
  return static_cast<int>(std::clamp(p, -farthest_pixel, farthest_pixel));
}

// An interval that holds what was included, by default nothing.
struct Bounds {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  void include(double v) { low = std::min(low, v), high = std::max(high, v); }
};

} // namespace bccsplat

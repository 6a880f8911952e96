// SPDX-License-Identifier: Apache-2.0
// A rectangle of pixels.
#pragma once

#include <algorithm>
#include <climits>

namespace bccsplat {

struct PixelRect {
  int x0 = INT_MAX, y0 = INT_MAX, x1 = INT_MIN, y1 = INT_MIN; // half open; by default empty

  [[nodiscard]] bool empty() const { return x0 >= x1 || y0 >= y1; }
  void include(const PixelRect& other) {
    x0 = std::min(x0, other.x0), y0 = std::min(y0, other.y0);
    x1 = std::max(x1, other.x1), y1 = std::max(y1, other.y1);
  }
  // The part inside [0, width) x [0, height).
  [[nodiscard]] PixelRect within(int width, int height) const {
    return {std::max(x0, 0), std::max(y0, 0), std::min(x1, width), std::min(y1, height)};
  }
};
inline constexpr PixelRect all_pixels{0, 0, INT_MAX, INT_MAX};

} // namespace bccsplat

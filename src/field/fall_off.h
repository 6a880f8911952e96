// SPDX-License-Identifier: Apache-2.0
// How a correction falls off along an axis: a polynomial of what is left to the next sample (bcc4.md,
// section 10).
#pragma once

#include <algorithm>
#include <cmath>

#include "points/correction_source.h"

namespace bccsplat {

// s(d) = u (a + u (b + u c)) with u = max(0, 1 - |d|): 1 at d = 0, and s(d) + s(1 - d) = 1.
struct FallOff {
  float a = 1, b = 0, c = 0;

  explicit FallOff(CorrectionShape shape) {
    if (shape == CorrectionShape::smooth) a = 0, b = 3, c = -2;
  }
  template<class T> [[nodiscard]] T value(T d) const {
    const T u = std::max(T{0}, 1 - std::fabs(d));
    return u * (static_cast<T>(a) + u * (static_cast<T>(b) + u * static_cast<T>(c)));
  }
  // Where a tent bends, that of the side of larger d.
  [[nodiscard]] double slope(double d) const {
    if (d < -1 || d >= 1) return 0;
    const double u = 1 - std::fabs(d), rise = a + u * (2 * static_cast<double>(b) + u * 3 * c);
    return d >= 0 ? -rise : rise;
  }
  // The integral of s between two distances, from <= to.
  [[nodiscard]] double integral(double from, double to) const {
    const auto below = [&](double d) { // from -1 on
      const double u = std::max(0.0, 1 - std::fabs(d));
      const double part = u * u * (static_cast<double>(a) / 2 + u * (static_cast<double>(b) / 3 + u * c / 4));
      return d <= 0 ? part : 1 - part;
    };
    return below(std::min(to, 1.0)) - below(std::max(from, -1.0));
  }
};

} // namespace bccsplat

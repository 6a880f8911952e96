// SPDX-License-Identifier: Apache-2.0
// Colours over the range of values, linear RGB.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace viewer {

inline constexpr const char* palette_names[] = {"fire", "ice", "grey"};

// Returns the colour at `at` in [0, 1].
[[nodiscard]] inline std::array<double, 3> palette_color(int palette, double at) {
  static constexpr double points[3][4][3] = {
      {{0.10, 0.02, 0.15}, {0.55, 0.06, 0.10}, {1.0, 0.38, 0.04}, {1.0, 0.92, 0.55}},
      {{0.02, 0.04, 0.20}, {0.04, 0.20, 0.55}, {0.20, 0.65, 0.85}, {0.90, 1.0, 1.0}},
      {{0.05, 0.05, 0.05}, {0.30, 0.30, 0.30}, {0.60, 0.60, 0.60}, {1.0, 1.0, 1.0}}};
  const auto& row = points[std::clamp(palette, 0, 2)];
  const double x = std::clamp(at, 0.0, 1.0) * 3;
  const auto i = std::min(static_cast<size_t>(x), size_t{2});
  const double f = x - static_cast<double>(i);
  std::array<double, 3> rgb{};
  for (size_t c = 0; c < 3; ++c) rgb[c] = (1 - f) * row[i][c] + f * row[i + 1][c];
  return rgb;
}

} // namespace viewer

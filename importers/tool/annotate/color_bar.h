// SPDX-License-Identifier: Apache-2.0
// The colours of values: a bar with ticks, or a square for the only value that has one.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "tool/annotate/canvas.h"

namespace bcc4 {

struct ColorBar {
  std::string heading;                       // name and unit
  std::vector<std::array<double, 4>> colors; // value, linear red, green and blue; values rise
  // The numbers beside the bar, and their texts; none: round ones.
  std::vector<double> ticks{};
  std::vector<std::string> texts{};
};

// Linear in between, the first and last beyond the ends.
[[nodiscard]] Color color_at(const std::vector<std::array<double, 4>>& colors, double value);

// Its upper right corner stands at `corner`, all of it within `height` pixels below and `width` to the left.
void draw_color_bar(Canvas& canvas, const ColorBar& bar, const Point& corner, double width, double height,
                    double em, const Ink& ink);

} // namespace bcc4

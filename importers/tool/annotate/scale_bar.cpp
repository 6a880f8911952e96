// SPDX-License-Identifier: Apache-2.0
#include "tool/annotate/scale_bar.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "tool/annotate/ticks.h"

namespace bcc4 {

std::string length_in_words(double length, std::string unit) {
  struct Larger {
    std::string_view from, to;
    double least, ratio; // least: of the smaller unit
  };
  constexpr std::array<Larger, 3> larger{Larger{"mm", "cm", 20, 10}, Larger{"cm", "m", 100, 100},
                                         Larger{"m", "km", 1000, 1000}};
  for (const Larger& l : larger)
    if (unit == l.from && length >= l.least) unit = l.to, length /= l.ratio;
  return tick_texts({length}).front() + (unit.empty() ? "" : " " + unit);
}

void draw_scale_bar(Canvas& canvas, double world_per_pixel, const std::string& unit, const Point& right,
                    double longest, double em, const Ink& ink) {
  const double world = round_below(longest * world_per_pixel), length = world / world_per_pixel;
  const double thickness = std::max(1.5, 0.12 * em), end = 0.3 * em;
  const Point left{right[0] - length, right[1]};
  const auto lines = [&](double more, const Color& color) {
    canvas.line(left, right, thickness + more, color, 1);
    for (const Point& p : {left, right})
      canvas.line({p[0], p[1] - end}, {p[0], p[1] + end}, thickness + more, color, 1);
  };
  lines(thickness + 1, ink.halo);
  lines(0, ink.color);
  canvas.text(length_in_words(world, unit), {right[0] - length / 2, right[1] - 0.6 * em}, em, Anchor::middle,
              ink);
}

} // namespace bcc4

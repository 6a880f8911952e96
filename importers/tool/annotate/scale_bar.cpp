// SPDX-License-Identifier: Apache-2.0
#include "tool/annotate/scale_bar.h"

#include <algorithm>

#include "tool/annotate/ticks.h"

namespace bcc4 {

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
  const std::string text = tick_texts({world}).front() + (unit.empty() ? "" : " " + unit);
  canvas.text(text, {right[0] - length / 2, right[1] - 0.6 * em}, em, Anchor::middle, ink);
}

} // namespace bcc4

// SPDX-License-Identifier: Apache-2.0
// A bar of a round length in the world's unit.
#pragma once

#include <string>

#include "tool/annotate/canvas.h"

namespace bcc4 {

// "5 cm" for 50 mm, "100 km" for 100000 m; other units stay.
[[nodiscard]] std::string length_in_words(double length, std::string unit);

// Ends at `right`, the bar's right end; nothing is longer than `longest` pixels. world_per_pixel is positive.
void draw_scale_bar(Canvas& canvas, double world_per_pixel, const std::string& unit, const Point& right,
                    double longest, double em, const Ink& ink);

} // namespace bcc4

// SPDX-License-Identifier: Apache-2.0
// The isosurfaces that the viewer shows, as they are given on its command line.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace viewer {

struct Surface {
  double value = 0, opacity = 1;
  bool colored = false;          // else the colour of the value
  std::array<double, 3> color{}; // linear
  bool operator==(const Surface&) const = default;
};

// "V[:OPACITY[:#RRGGBB]]", several with commas, as of bcc4 render --iso. Throws std::runtime_error.
[[nodiscard]] std::vector<Surface> parse_surfaces(const std::string& text);

// Moves all values by a hundredth of a range, up or down.
void move_surfaces(std::vector<Surface>& surfaces, const std::array<double, 2>& range, int steps);

} // namespace viewer

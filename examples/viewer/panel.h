// SPDX-License-Identifier: Apache-2.0
// The controls beside the picture.
#pragma once

#include "viewer/worker.h"

namespace viewer {

constexpr float panel_width = 330; // pixels

struct Facts { // of the file, for labels and limits
  double last_frame = 0;
  double iso_value = 0; // of the surface that the library would show
  std::array<double, 2> range{};
  std::array<float, curve_points> opacity{}; // over the range, as the library would have it
  std::string name, unit, time_unit;
  double time_first = 0, time_last = 0;
  std::array<float, 256> histogram{}; // logarithmic
};

[[nodiscard]] Facts read_facts(const bccsplat_volume* volume);
struct Play {
  bool on = false, loop = true, record = false;
  double speed = 4; // frames a second
};

// Draws the panel at the left edge and changes the wish; `shown` is the picture on screen or null, `recorded`
// what the recorder has to say.
void panel(Wish& wish, Play& play, const Facts& facts, const Picture* shown, const Counts& counts,
           const std::string& recorded);

} // namespace viewer

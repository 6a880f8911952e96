// SPDX-License-Identifier: Apache-2.0
// Finds where things go from one stored frame to the next.
#pragma once

#include <vector>

#include "motion/box.h"
#include "motion/nodes.h"
#include "motion/spline.h"

namespace bccsplat::motion {

// What is needed of a frame to find the flow to and from it: made once, used for each neighbour.
struct Sketch {
  std::vector<Level> levels;
  Spline finest; // through levels[0]

  explicit Sketch(const Box& frame) : levels(make_pyramid(frame)), finest(levels[0].box) {}
};

struct FlowOptions {
  int32_t spacing = 16; // of nodes, samples of the frame
};

// Frames of the same dims. Where both are empty the flow is that of its surroundings; it is not said whether
// it is right anywhere: gate.h tells.
[[nodiscard]] Flow find_flow(const Sketch& first, const Sketch& second, const FlowOptions& options = {});

} // namespace bccsplat::motion

// SPDX-License-Identifier: Apache-2.0
// Block matching: where what is around the nodes of one frame is in another.
#pragma once

#include <span>
#include <vector>

#include "motion/box.h"
#include "motion/nodes.h"

namespace bccsplat::motion {

struct Matches {
  Nodes nodes;
  std::vector<Float3> moved; // samples of the frame, whole ones of the finest level
  std::vector<float> weight; // how much there is to see around a node that is found again
};

// Coarse to fine through two pyramids of the same kind; nodes of the finest level are `spacing` samples
// apart.
[[nodiscard]] Matches match(std::span<const Level> from, std::span<const Level> to, int32_t spacing);

} // namespace bccsplat::motion

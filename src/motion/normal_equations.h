// SPDX-License-Identifier: Apache-2.0
// The linear equations of a step that makes a flow better.
#pragma once

#include <array>
#include <vector>

#include "motion/nodes.h"

namespace bccsplat::motion {

// What a sample says: along its slope the velocity there should change by -difference.
struct Sight {
  Corners corners;
  Float3 slope;     // of the difference, by the velocity
  float difference; // of the two frames, as they are moved now
};

// The change of a flow that makes the squares of all sights least, together with the squares of differences
// of neighbours after it; by conjugate gradients.
[[nodiscard]] std::vector<Float3> better_by(const Flow& flow, const std::vector<Sight>& sights,
                                            float smoothness);

} // namespace bccsplat::motion

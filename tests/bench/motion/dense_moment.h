// SPDX-License-Identifier: Apache-2.0
// Moments that follow the motion, at every sample of dense frames: what the reader's are compared with.
#pragma once

#include <span>

#include "motion/box.h"
#include "motion/finder.h"
#include "motion/warped.h"

namespace bccsplat::motion {

// Where the mask (0 to 1 at nodes, straight between them; empty: 1) is 0 the moment is `still` as it is.
[[nodiscard]] Box sum_along(const Ways& ways, const Flow& flow, std::span<const float> mask,
                            const Box& still);

struct SumOptions {
  bool cubic = true; // four frames, else two
  bool gated = true; // by the mask, else everywhere
};
// A moment of frames that were all given. still: the moment without motion, on their samples.
[[nodiscard]] Box dense_moment(Finder& finder, double time, const Box& still, const SumOptions& options = {});

} // namespace bccsplat::motion

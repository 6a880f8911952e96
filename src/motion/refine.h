// SPDX-License-Identifier: Apache-2.0
// Makes a flow fit two frames as well as its nodes can.
#pragma once

#include "motion/nodes.h"
#include "motion/spline.h"

namespace bccsplat::motion {

struct RefineOptions {
  int32_t steps = 4;       // of Gauss and Newton
  float smoothness = .02f; // what neighbours' differences weigh beside what the frames say
};

// first and second: the same level of both frames, which has every `factor`-th of their samples.
void refine(Flow& flow, const Spline& first, const Spline& second, const Int3& factor,
            const RefineOptions& options = {});

} // namespace bccsplat::motion

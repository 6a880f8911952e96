// SPDX-License-Identifier: Apache-2.0
// Blocks are matched from both frames, the matches joined halfway, and the flow refined there.
#include "motion/flow.h"

#include "motion/join.h"
#include "motion/match.h"
#include "motion/refine.h"

namespace bccsplat::motion {

Flow find_flow(const Sketch& first, const Sketch& second, const FlowOptions& options) {
  Flow flow = join(match(first.levels, second.levels, options.spacing),
                   match(second.levels, first.levels, options.spacing));
  refine(flow, first.finest, second.finest, first.levels[0].factor);
  return flow;
}

} // namespace bccsplat::motion

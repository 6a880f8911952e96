// SPDX-License-Identifier: Apache-2.0
// Which bricks of a slice's points a picture needs, and where their points fall.
#pragma once

#include "splat/plan/plan.h"

namespace bccsplat {

// Sets plan.bricks, plan.inside and plan.longest. ring: the scene as the samples of the plan's sheets see it;
// copies: as make_plan's.
void plan_bricks(const SplatScene& scene, const SplatScene& ring, const SplatOptions& options,
                 const Context& context, MemoryBudget* copies, SplatPlan& plan, DrawStats& stats);

} // namespace bccsplat

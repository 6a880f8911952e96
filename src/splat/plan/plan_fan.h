// SPDX-License-Identifier: Apache-2.0
// Whether a view in perspective is raised from a fan (raise_fan.h), and where its bricks are then.
#pragma once

#include "splat/plan/plan.h"

namespace bccsplat {

// Turns a view in perspective into that of a fan's samples, where that is cheaper and tiles need not be much
// larger than what they show at once.
[[nodiscard]] bool plan_fan(const RaiseFilter& filter, SplatPlan& plan, SheetView& v);

// Turns a brick's rectangle of samples into one of the pixels that may look at them.
void fan_rect(const SplatPlan& plan, PlannedBrick& b);

} // namespace bccsplat

// Which points of its bricks a picture needs, by cells of 2^3 planes.
#pragma once

#include "splat/plan/plan.h"
#include "splat/plan/plan_cells.h"

namespace bccsplat {

// Leaves out the points of plan.bricks farther than two kernel radii and `look` from every point whose
// coefficient alone could make a sample visible, and bricks that lose all of them: no sample that they change
// is visible or looked at by a visible one. Of pictures at the pixels; those that are raised look further.
// least: the code of the smallest such coefficients, from least_code().
void pick_points(const SplatScene& scene, double look, int least, Tasks& tasks, SplatPlan& plan,
                 SplatStats& stats);
// Room for pick_points(); false: a picture has better use for the budget.
[[nodiscard]] bool reserve_copies(const SplatPoints& points, MemoryBudget& budget, PickedPoints& picked);
// 0: points of any size may, or the picture looks too far around.
[[nodiscard]] int least_code(const SplatScene& scene, const SplatOptions& options,
                             const WeightBounds& weights, double look, const SplatPlan& plan);

} // namespace bccsplat

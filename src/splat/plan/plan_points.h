// SPDX-License-Identifier: Apache-2.0
// Which points of its bricks a picture needs, by cells of 2^3 planes.
#pragma once

#include <algorithm>

#include "splat/plan/plan.h"
#include "splat/plan/plan_cells.h"

namespace bccsplat {

// Bricks that a thread takes at once: one alone is less work than handing it out.
inline constexpr size_t bricks_per_task = 64;

// Calls body(n) for n in [0, count) from several threads.
template<class Body> void each_brick(const Context& context, size_t count, const Body& body) {
  context.tasks.parallel_for((count + bricks_per_task - 1) / bricks_per_task, [&](uint64_t part) {
    context.progress.check();
    for (size_t n = part * bricks_per_task; n < std::min(count, (part + 1) * bricks_per_task); ++n) body(n);
  });
}

// Leaves out the points of plan.bricks farther than two kernel radii and `look` from every point whose
// coefficient alone could make a sample visible, and bricks that lose all of them: no sample that they change
// is visible or looked at by a visible one. It serves pictures that are sampled at their pixels; those that
// are raised look further. `least` is the code of the smallest such coefficients, from least_code().
void pick_points(const SplatScene& scene, double look, int least, const Context& context, SplatPlan& plan,
                 DrawStats& stats);
// Reserves room for pick_points(); returns false when the budget has better use for it.
[[nodiscard]] bool reserve_copies(const SplatPoints& points, MemoryBudget& budget, PickedPoints& picked);
// Returns the code of the smallest coefficients that alone could make a sample visible; 0 when points of any
// size could, or the picture looks too far around for pick_points().
[[nodiscard]] int least_code(const SplatScene& scene, const SplatOptions& options,
                             const WeightBounds& weights, double look, const SplatPlan& plan);

} // namespace bccsplat

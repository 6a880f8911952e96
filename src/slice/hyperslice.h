// SPDX-License-Identifier: Apache-2.0
// Any hyperplane a x + b y + c z + d t + e = 0, by the best way there is for it: merged layers for
// hyperplanes normal to an axis, resampling for all others and wherever a lattice of its own is asked for.
#pragma once

#include <functional>

#include "field/slice.h"
#include "slice/cut_plan.h"

namespace bccsplat {

// Cuts a slice and mends it, by whatever way it was cut with the same in the same order: the file's masks,
// its corrections, the box, even axes. The largest value of some instants is that of mended ones, at each
// site, interpolated between them; it is nowhere less than the mean at a site but for rounding. A hyperplane
// that misses the domain gives an empty slice. follow: changes a moment before it is mended.
using FollowMoment = std::function<void(Slice& moment, const Context& context)>;
[[nodiscard]] Slice make_slice(const CutPlan& plan, const Affine3& index_to_world, const Context& context,
                               const FollowMoment& follow = {});

[[nodiscard]] inline Slice hyperslice(const Coefficients& coefficients, const Hyperplane& hyperplane,
                                      const HypersliceOptions& options, const Affine3& index_to_world,
                                      const Context& context) {
  return make_slice(plan_cut(coefficients, hyperplane, options), index_to_world, context);
}

} // namespace bccsplat

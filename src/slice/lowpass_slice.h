// SPDX-License-Identifier: Apache-2.0
// What a slice coarser than its volume holds of it: without a low pass, what is beyond its lattice's band
// would come back as something else.
#pragma once

#include <functional>
#include <vector>

#include "base/context.h"
#include "field/slice.h"

namespace bccsplat {

// The low pass, over distances r in units of the coarser lattice: the ideal one of a ball of frequencies of
// radius 0.45 under a Kaiser window of radius 4 and beta 6. It passes 0.98 at half the Nyquist rate of the
// coarser lattice, 0.24 at the rate itself and less than 0.01 from 1.3 times on.
[[nodiscard]] double lowpass_weight(double r);
inline constexpr double lowpass_reach = 4;

// Returns the samples of `coarse`, relative to the base, by coset: those of `fine`, whose cosets hold samples
// relative to the base, weighted around each site, distances along each axis in its `unit` of slice space.
// Both are of one hyperplane. Only sites that `near` says are made, from slice space.
[[nodiscard]] std::vector<BrickLayer> lowpassed_samples(const Slice& fine, const Slice& coarse,
                                                        const Vec3& unit,
                                                        const std::function<bool(const Vec3&)>& near,
                                                        const Context& context);

} // namespace bccsplat

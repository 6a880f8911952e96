// SPDX-License-Identifier: Apache-2.0
// What one core of this machine can do at most: the figures that splat rates are fractions of.
#pragma once

namespace bccsplat::bench {

// Multiply-adds of one float per second, in registers.
[[nodiscard]] double fma_peak();

// Floats per second added to in a ring that stays in the first-level cache, footprints of `width` x `width`
// pixels x 4 sheets at random places: what a splat loop without weights could reach.
[[nodiscard]] double update_peak(int width);

} // namespace bccsplat::bench

// SPDX-License-Identifier: Apache-2.0
// A slice as arrays: at points and boxes of slice space, and as the list of its lattice points.
#pragma once

#include <cstdint>
#include <span>

#include "base/context.h"
#include "field/slice.h"

namespace bccsplat {

// Sample (i, j, k) at origin + step * (i, j, k), slice space.
struct Grid {
  Vec3 origin{}, step{1, 1, 1};
  Int3 dims{1, 1, 1};
};

// Does what evaluate() does, at points of slice space and over all threads.
EvaluateMisses sample_points(const Slice& slice, std::span<const Vec3> points, std::span<float> values,
                             std::span<std::array<float, 3>> gradients, const Context& context);

// Makes values at points of slice space that the slice's mask says are missing NaN; returns how many these
// are.
uint64_t hide_missing(const Slice& slice, std::span<const Vec3> points, std::span<float> values);

// Fills values (x fastest); NaN outside the domain and in holes.
void sample_grid(const Slice& slice, const Grid& grid, float* values, const Context& context);

// Writes positions (slice space, 3 floats each) and coefficients of the first `capacity` kept points in brick
// order; either may be null. Returns how many points there are.
uint64_t list_points(const Slice& slice, uint64_t capacity, float* positions, float* coefficients,
                     Progress& progress);

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Boxes of sites of any size, mirrored beyond the ends, and what the field in a box can be at most.
#pragma once

#include <array>
#include <vector>

#include "field/footprint/dense_sites.h"
#include "volume/open_slice.h"

namespace bccsplat {

// Copies a box of a layer, x fastest.
void gather_sites(const BrickLayer& layer, const SiteBox& box, float* out, std::vector<float>& scratch);

// Returns the smallest and the largest coefficient of the sites first .. last, and 0.
[[nodiscard]] std::array<float, 2>
coefficient_range(const BrickLayer& layer, const std::array<Int3, 2>& sites, std::vector<float>& scratch);

// Returns bounds of the values in a box of slice space; both are the base of the field where it is nothing
// else there. Missing values count for nothing.
[[nodiscard]] std::array<float, 2> value_bounds(const OpenSlice& slice, const std::array<Vec3, 2>& box,
                                                std::vector<float>& scratch);

} // namespace bccsplat

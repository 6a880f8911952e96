// SPDX-License-Identifier: Apache-2.0
// How a marcher of a 3D texture samples: in place of the shader's gather of sites, in one line of GLSL each
// (it stands in a #define). Index space is world space; texels are those of a MarchGrid with its border.
#pragma once

#include <string>

#include "field/slice.h"
#include "tests/bench/ray_march/ray_march.h"

namespace bccsplat::bench {

// slice: on BCC, of the same field. Trilinear by the texture unit, gradients by central differences of six
// more samples; or cubic B-splines of eight trilinear samples (Sigg & Hadwiger 2005), gradients by the
// derivatives of the weights, eight each.
[[nodiscard]] std::string texture_gather(const MarchGrid& grid, const Slice& slice);

} // namespace bccsplat::bench

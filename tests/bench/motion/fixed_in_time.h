// SPDX-License-Identifier: Apache-2.0
// Moments by weights of the frames alone, the same at every place.
#pragma once

#include <array>
#include <vector>

#include "motion/box.h"

namespace bccsplat::bench {

// Weights of frames 0 .. n-1 for the moment at `index`, frames being one unit apart.
[[nodiscard]] std::vector<double> blend_weights(double index, size_t n);
// Cubics: Catmull and Rom's, continued straight beyond the ends; Lagrange's, of the four frames that are
// nearest; the natural spline through all.
inline constexpr size_t time_cubics = 3;
[[nodiscard]] std::array<std::vector<double>, time_cubics> cubic_weights(double index, size_t n);

[[nodiscard]] motion::Box weighted(const std::vector<motion::Box>& frames,
                                   const std::vector<double>& weights);

} // namespace bccsplat::bench

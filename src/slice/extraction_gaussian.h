// SPDX-License-Identifier: Apache-2.0
// The paper's Gaussian, exp(-2 r^2), and the cells that extracted points are kept in.
#pragma once

namespace bccsplat {

inline constexpr double paper_gaussian = 2; // per T^2
inline constexpr double paper_reach = 2;    // T: e^-8 of the peak
inline constexpr float extraction_cell = 2; // T

} // namespace bccsplat

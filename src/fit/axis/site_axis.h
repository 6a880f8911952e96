// SPDX-License-Identifier: Apache-2.0
// Positions of the sites of a coset along one axis, in source samples.
#pragma once

#include <cstdint>
#include <vector>

#include "lattice/lattice.h"

namespace bccsplat {

// They are not plane * space_step, so that a plane falls on the last sample exactly, and on all samples of a
// periodic axis where there are as many.
[[nodiscard]] std::vector<double> site_positions(const Lattice4& lattice, int coset, size_t axis);
// The source sample nearest to a position on an axis of n samples; the later one of two at equal distance.
[[nodiscard]] int64_t nearest_sample(double position, int64_t n);

} // namespace bccsplat

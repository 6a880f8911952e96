// SPDX-License-Identifier: Apache-2.0
// The steps from samples on a lattice to the coefficients of a kernel.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "field/coefficients/prefilter.h"
#include "kernel/kernel.h"

namespace bccsplat {

struct PrefilterOfKernel {
  Kernel kernel; // in its form for the lattice
  std::vector<PrefilterStep> steps;
  size_t in_space = 0; // on Cartesian lattices, how many come before those in time
};
[[nodiscard]] PrefilterOfKernel prefilter_of(const Lattice4& lattice, Kernel kernel);

// The steps in time of a Cartesian lattice as one: weights of the layers around a layer, which has the middle
// one.
[[nodiscard]] std::vector<double> weights_in_time(std::span<const PrefilterStep> steps);

} // namespace bccsplat

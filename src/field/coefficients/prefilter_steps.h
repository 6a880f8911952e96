// SPDX-License-Identifier: Apache-2.0
// The steps from samples on a lattice to the coefficients of a kernel.
#pragma once

#include <vector>

#include "field/coefficients/prefilter.h"
#include "kernel/kernel.h"

namespace bccsplat {

struct PrefilterOfKernel {
  Kernel kernel; // in its form for the lattice
  std::vector<PrefilterStep> steps;
};
[[nodiscard]] PrefilterOfKernel prefilter_of(const Lattice4& lattice, Kernel kernel);

} // namespace bccsplat

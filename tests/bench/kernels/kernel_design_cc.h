// SPDX-License-Identifier: Apache-2.0
// Designs the prefilters of kernels on the Cartesian lattice (kernel/cc_kernel.h): least squares in the
// coefficients of polynomials of neighbour sums, weighted by the inverse of the least possible error.
#pragma once

#include <array>
#include <ostream>
#include <vector>

#include "kernel/cc_kernel.h"

namespace bccsplat::bench {

struct CcDesign {
  std::vector<PrefilterStage> stages;
  std::array<double, 4> snr{};    // dB at rho 0.3 0.5 0.7 0.9 with these stages
  std::array<double, 4> best{};   // with the best of all prefilters
  double gain = 0;                // sum of |taps|
  double lowest = 0, highest = 0; // response at the sites over all frequencies
};

// `phi` has integral 1. stages: passes, each reaching one site further.
[[nodiscard]] CcDesign design_cc_space(const RadialKernel& phi, int stages);
// A B-spline of this order at unit pitch.
[[nodiscard]] CcDesign design_cc_time(int order, int stages);

// Prints what src/kernel/cc_tables.inc holds.
void print_cc_designs(std::ostream& out);

} // namespace bccsplat::bench

// SPDX-License-Identifier: Apache-2.0
// Time slices phase by phase: the error of plane waves at one distance from the layers, and the bends of a
// temporal spline (kernel/kernel.h) for which it is least.
#pragma once

#include <array>
#include <vector>

#include "kernel/kernel.h"

namespace bccsplat::bench {

// Mean-square errors of waves uniform in the ball of radius rho / 2, their power being 1, at `phases`
// instants from a layer to halfway to the next one of the other coset: all there are but for mirror images
// and exchanged cosets.
[[nodiscard]] std::vector<double> phase_errors(const Kernel& kernel, double rho, int phases, size_t waves);

// The bends, given the prefilter of the kernel, that minimise the mean over design_rhos of the error in dB,
// the louder phases counting more.
[[nodiscard]] std::array<double, 2> design_bend(const Kernel& kernel);

} // namespace bccsplat::bench

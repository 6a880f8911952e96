// SPDX-License-Identifier: Apache-2.0
// Figures of a kernel that need no signal.
#pragma once

#include "kernel/kernel.h"

namespace bccsplat::bench {

// Largest deviation from 1 of a reconstructed constant on D4* (dimensions 4) or BCC (3), in dB, before any
// division by the lattice sum.
[[nodiscard]] double dc_ripple_db(const Kernel& kernel, int dimensions);

// Sites in the support, in the mean.
[[nodiscard]] double mean_taps(const Kernel& kernel, int dimensions);

// What white noise of variance 1 in the samples becomes: the variance of the values, averaged over positions.
[[nodiscard]] double noise_gain(const Kernel& kernel, int dimensions);

} // namespace bccsplat::bench

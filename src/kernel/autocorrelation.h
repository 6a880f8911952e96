// SPDX-License-Identifier: Apache-2.0
// How much of a kernel overlaps with itself somewhere else, which says how errors of two coefficients add up
// in the field.
#pragma once

#include "kernel/kernel.h"

namespace bccsplat {

// The integral over space of phi(|x|) phi(|x + d|), |d| = distance, by the midpoint rule.
[[nodiscard]] double autocorrelation(const RadialKernel& phi, double distance);
// The integral over time of beta(t) beta(t + dt), by the midpoint rule.
[[nodiscard]] double autocorrelation(const TemporalKernel& beta, double dt);

} // namespace bccsplat

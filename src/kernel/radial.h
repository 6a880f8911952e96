// SPDX-License-Identifier: Apache-2.0
// Integral and normalisation of the spatial kernels, and the Gaussian in polynomial form.
#pragma once

#include <numbers>

#include "kernel/kernel.h"

namespace bccsplat {

// Returns the integral of phi over space.
[[nodiscard]] double radial_integral(const RadialKernel& phi);

// Scales phi so that its sum over the sites of BCC is 1 in the mean: integral = cell volume = sqrt2.
void normalise_on_bcc(RadialKernel& phi);

// Returns exp(-g r^2) cut at radius, in polynomial form (error < 1e-7 phi(0) inside the radius), normalised
// on BCC.
[[nodiscard]] RadialKernel gaussian_kernel(double g, double radius);

} // namespace bccsplat

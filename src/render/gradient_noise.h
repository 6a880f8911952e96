// SPDX-License-Identifier: Apache-2.0
// How large the gradients are that the noise of a channel has, as far as its file tells.
#pragma once

#include "kernel/kernel.h"
#include "render/value_survey.h"
#include "splat/shade/light.h"

namespace bccsplat {

// Returns the gradient per lattice distance of what a kernel makes of a constant 1, at 99 of 100 places; 0 of
// kernels that divide by the lattice sum.
[[nodiscard]] double ripple_gradient(const Kernel& kernel, bool bcc);

// survey: of the channel, as it is. step: of the stored values and of the source's, 0: none; threshold:
// values this near to air were dropped; ripple: of the kernel. Returns values per voxel.
[[nodiscard]] GradientNoise gradient_noise(const ValueSurvey& survey, double step, double threshold,
                                           double ripple);

// The same per world length, where a voxel is that long.
[[nodiscard]] GradientNoise per_length(const GradientNoise& noise, double voxel);

} // namespace bccsplat

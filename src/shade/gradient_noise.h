// SPDX-License-Identifier: Apache-2.0
// How large the gradients are that the noise of a channel has, as far as its file tells.
#pragma once

#include "field/slice.h"
#include "kernel/drawn_kernel.h"
#include "shade/light.h"
#include "shade/mode.h"
#include "shade/value_survey.h"

namespace bccsplat {

// Returns the gradient per lattice distance of what a slice's kernel makes of a constant 1, at 99 of 100
// places; 0 of kernels that divide by the lattice sum.
[[nodiscard]] double ripple_gradient(const Slice& slice);
// Returns what differences between the samples of sheets half a lattice distance apart have of it, of the
// kernel's form that is drawn.
[[nodiscard]] double ripple_of_differences(const Slice& slice, KernelForm form);
// Returns what ripple leaves in the gradients that light a picture: by the mode and by the form of the kernel
// alone, so that all qualities are lit alike.
[[nodiscard]] double ripple_noise(const Slice& slice, RenderMode mode, KernelForm form, bool without_ripple);

// survey: of the channel, as it is. step: of the stored values and of the source's, 0: none; threshold:
// values this near to air were dropped. Returns the part that all values have, per voxel.
[[nodiscard]] GradientNoise gradient_noise(const ValueSurvey& survey, double step, double threshold);

// The same per world length, where a voxel is that long.
[[nodiscard]] GradientNoise per_length(const GradientNoise& noise, double voxel);

} // namespace bccsplat

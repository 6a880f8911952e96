// SPDX-License-Identifier: Apache-2.0
// How large the gradients are that the noise of a channel has, as far as its file tells.
#pragma once

#include "render/value_survey.h"
#include "splat/shade/light.h"

namespace bccsplat {

// survey: of the channel, as it is. step: of the stored values and of the source's, 0: none; threshold:
// values this near to air were dropped. Returns values per voxel.
[[nodiscard]] GradientNoise gradient_noise(const ValueSurvey& survey, double step, double threshold);

// The same per world length, where a voxel is that long.
[[nodiscard]] GradientNoise per_length(const GradientNoise& noise, double voxel);

} // namespace bccsplat

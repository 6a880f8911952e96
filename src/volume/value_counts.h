// SPDX-License-Identifier: Apache-2.0
// What a file says of a channel's values.
#pragma once

#include "shade/light.h"
#include "shade/value_survey.h"
#include "volume/open_volume.h"

namespace bccsplat {

// Returns the histogram and what is known beside it, for the transfer function that is made of them.
[[nodiscard]] ValueCounts value_counts(const OpenVolume& volume, uint32_t channel);

// Returns the noise of a channel's gradients per mean voxel.
[[nodiscard]] GradientNoise channel_noise(const OpenVolume& volume, uint32_t channel);

} // namespace bccsplat

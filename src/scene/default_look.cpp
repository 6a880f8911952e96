// SPDX-License-Identifier: Apache-2.0
#include "scene/default_look.h"

#include "shade/gradient_noise.h"

namespace bccsplat {

TransferFunction default_function(const OpenVolume& volume, uint32_t channel, const RenderOptions& options) {
  return look_function(survey_values(value_counts(volume, channel)), Look::automatic,
                       options.surfaces.size() > 1 ? RenderMode::composite : options.mode);
}

GradientNoise noise_of(const OpenVolume& volume, const OpenSlice& slice, const std::optional<double>& asked) {
  return per_length(asked ? GradientNoise{*asked, 0} : channel_noise(volume, slice.channel, slice.level),
                    mean_voxel(slice.slice));
}

} // namespace bccsplat

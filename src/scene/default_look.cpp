// SPDX-License-Identifier: Apache-2.0
#include "scene/default_look.h"

#include <algorithm>
#include <cmath>

#include "shade/gradient_noise.h"

namespace bccsplat {

TransferFunction default_function(const OpenVolume& volume, uint32_t channel, const Slice& slice,
                                  const RenderOptions& options) {
  TransferFunction f = look_function(survey_values(value_counts(volume, channel)), Look::automatic,
                                     options.surfaces.size() > 1 ? RenderMode::composite : options.mode);
  f.unit_distance = distance_of_look(volume, slice);
  return f;
}

double distance_of_look(const OpenVolume& volume, const Slice& slice) {
  if (slice.is_time_slice() && !one_sample_thick(slice)) return 0;
  const Vec3 samples = samples_across(slice);
  double frame = 1;
  for (size_t a = 0; a < 3; ++a) frame *= volume.info().lattice.dims[a];
  return mean_voxel(slice) * std::max(1.0, std::min({samples[0], samples[1], samples[2]})) / std::cbrt(frame);
}

GradientNoise noise_of(const OpenVolume& volume, const OpenSlice& slice, const std::optional<double>& asked) {
  return per_length(asked ? GradientNoise{*asked, 0} : channel_noise(volume, slice.channel, slice.level),
                    mean_voxel(slice.slice));
}

} // namespace bccsplat

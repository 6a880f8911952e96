// SPDX-License-Identifier: Apache-2.0
#include "draw/shot.h"

#include <algorithm>
#include <cmath>

#include "shade/gradient_noise.h"

namespace bccsplat {

constexpr double thinnest_lit = 1.5; // samples

double mean_voxel(const Slice& slice) { return std::cbrt(std::fabs(slice.slice_to_world.determinant())); }

Vec3 samples_across(const Slice& slice) {
  const Vec3 size = slice.domain_end - slice.domain_begin;
  Vec3 samples{};
  for (size_t a = 0; a < 3; ++a) {
    Vec3 side{};
    side[a] = size[a];
    samples[a] = length(slice.lattice_to_slice.vector(side));
  }
  return samples;
}

bool one_sample_thick(const Slice& slice) {
  const Vec3 samples = samples_across(slice);
  return std::min({samples[0], samples[1], samples[2]}) < thinnest_lit;
}

Lights lights_of(const Shot& shot, KernelForm form) {
  Lights lights = *shot.lights;
  if (shot.noise_of_ripple)
    lights.noise.of_value =
        ripple_noise(*shot.slice, shot.options.mode, form, shot.options.without_ripple) / shot.voxel;
  return lights;
}

KernelForm sample_form(const Shot& shot) {
  const QualitySettings quality = quality_settings(shot.quality);
  const double step = shot.view->step;
  if (shot.options.mode == RenderMode::composite && shot.options.shading && step >= quality.flat_kernel)
    return KernelForm::flat_form;
  // Unshaded pictures converge faster, so that what shading hides shows one step earlier.
  return step >= (shot.options.shading ? 1 : 2) * quality.short_kernel ? KernelForm::short_form
                                                                       : KernelForm::exact;
}

bool corrected(const Shot& shot) {
  if (shot.slice->corrections) return true;
  return shot.trail &&
         std::any_of(shot.trail->sources.begin(), shot.trail->sources.end(),
                     [](const ShotTrail::Source& s) { return s.slice->corrections != nullptr; });
}

} // namespace bccsplat

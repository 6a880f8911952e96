// SPDX-License-Identifier: Apache-2.0
#include "draw/shot.h"

#include <algorithm>
#include <cmath>

#include "shade/gradient_noise.h"

namespace bccsplat {

double mean_voxel(const Slice& slice) { return std::cbrt(std::fabs(slice.slice_to_world.determinant())); }

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

// SPDX-License-Identifier: Apache-2.0
// The default kernel ripples: it brings a constant back with gradients of up to 0.024 of its distance from
// the base, and one in a hundred above 0.02. Noise of a standard deviation has gradients, per voxel, of up to
// three times that, but for a few per mille. `bccsplat_bench pictures --plateaus` shows what is left of
// either.
#include "render/gradient_noise.h"

#include <algorithm>
#include <cmath>

namespace bccsplat {
namespace {

constexpr double ripple = 0.02, gradient_sigmas = 3;
// Voxels that an edge between the background and what is seen before it may have and still be a full surface.
constexpr double edge = 3;
constexpr double sigma_per_step = 0.2887; // of rounding: 1 / sqrt(12)

// The least difference of values that is to be seen as a surface.
double contrast(const ValueSurvey& s) {
  switch (s.kind) {
  case ValueKind::labels: {
    double least = s.labels.front() - s.background;
    for (size_t i = 1; i < s.labels.size(); ++i) least = std::min(least, s.labels[i] - s.labels[i - 1]);
    return least;
  }
  case ValueKind::solid:
  case ValueKind::constant:
    return std::fabs(s.object - s.background);
  default:
    return s.mean;
  }
}

} // namespace

GradientNoise gradient_noise(const ValueSurvey& survey, double step, double threshold) {
  const double sigma = std::hypot(survey.noise, sigma_per_step * step, sigma_per_step * threshold);
  const double most = contrast(survey) / (edge * surface_over_noise);
  return {std::min(gradient_sigmas * sigma, most), ripple};
}

GradientNoise per_length(const GradientNoise& noise, double voxel) {
  return {noise.constant / voxel, noise.of_value / voxel};
}

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Kernels ripple: they bring a constant back with gradients, which are a share of its distance from the base.
// Noise of a standard deviation has gradients of up to three times that, but for a few per mille.
// `bccsplat_bench pictures --plateaus` shows what is left of either.
#include "render/gradient_noise.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace bccsplat {
namespace {

constexpr double gradient_sigmas = 3;
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

// The gradient at p of the sum of a kernel over the sites of a coset, which stand `pitch` apart and one of
// them at (offset, offset, offset); p is in [0, pitch].
Vec3 sum_of_gradients(const RadialKernel& kernel, double pitch, double offset, const Vec3& p) {
  const int first = static_cast<int>(-kernel.radius / pitch) - 1, last = 1 - first;
  Vec3 sum{};
  for (int z = first; z <= last; ++z)
    for (int y = first; y <= last; ++y)
      for (int x = first; x <= last; ++x) {
        const Vec3 d = p - Vec3{pitch * x + offset, pitch * y + offset, pitch * z + offset};
        const double r2 = dot(d, d);
        if (r2 < kernel.radius * kernel.radius) sum = sum + (2 * kernel.slope(r2)) * d;
      }
  return sum;
}

} // namespace

double ripple_gradient(const Kernel& kernel, bool bcc) {
  if (kernel.normalised) return 0;
  // In an eighth of a cell, of which the others are mirror images, the largest at so many places along each
  // axis is that of 99 of 100 places within a fifth, for all kernels on BCC and CC.
  constexpr int n = 4;
  const double pitch = bcc ? std::numbers::sqrt2 : 1;
  double most = 0;
  for (int i = 0; i < n * n * n; ++i) {
    const auto at = [&](int places) { return (i / places % n + 0.5) / n * pitch / 2; };
    const Vec3 p{at(1), at(n), at(n * n)};
    Vec3 sum = sum_of_gradients(kernel.space, pitch, 0, p);
    if (bcc) sum = sum + sum_of_gradients(kernel.space, pitch, pitch / 2, p);
    most = std::max(most, length(sum));
  }
  return most;
}

GradientNoise gradient_noise(const ValueSurvey& survey, double step, double threshold, double ripple) {
  const double sigma = std::hypot(survey.noise, sigma_per_step * step, sigma_per_step * threshold);
  const double most = contrast(survey) / (edge * surface_over_noise);
  return {std::min(gradient_sigmas * sigma, most), ripple};
}

GradientNoise per_length(const GradientNoise& noise, double voxel) {
  return {noise.constant / voxel, noise.of_value / voxel};
}

} // namespace bccsplat

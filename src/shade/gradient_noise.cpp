// SPDX-License-Identifier: Apache-2.0
// Kernels ripple: they bring a constant back with gradients, which are a share of its distance from the base.
// Surfaces are without it (lattice_sums.h); differences between the samples of sheets see little of it.
// Noise of a standard deviation has gradients of up to three times that, but for a few per mille.
// `bccsplat_bench pictures --plateaus` shows what is left of either.
#include "shade/gradient_noise.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "field/lattice_sums.h"

namespace bccsplat {
namespace {

constexpr double gradient_sigmas = 3;
// Voxels that an edge between the background and what is seen before it may have and still be a full surface.
constexpr double edge_voxels = 3;
// Behind the edge of a solid the field rings: gradients up to this share of what the object is above the
// background, per voxel, are taken for that.
constexpr double ringing = 0.04;
constexpr double sigma_per_step = 0.2887; // of rounding: 1 / sqrt(12)
// Rounding makes terraces of slopes, which last for voxels: slopes of fewer steps per voxel have the light of
// their risers.
constexpr double steps_of_terraces = 2;
// Differences over a sample's distance, of values with a standard deviation of 1. Samples know of no waves
// but those that are longer than two of them; with less than this f32 data glitter in drafts.
constexpr double differences_per_ripple = 5;
// Lattice distances between samples: those of normal pictures, and of what the sheets of finer ones are
// raised from. Analytic gradients have less than this, as far as their ripple is taken off.
constexpr double samples_apart = 0.5;
// The share of the ripple that surfaces keep once it is taken off.
constexpr double left_of_ripple = 0.1;

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

// Returns what a kernel makes of a constant 1 at places all over an eighth of a cell, of which the others are
// mirror images.
std::vector<LatticeSum> sums_of_cell(const RadialKernel& kernel, bool bcc) {
  constexpr int n = 4;
  const double pitch = bcc ? std::numbers::sqrt2 : 1;
  std::vector<LatticeSum> sums;
  for (int i = 0; i < n * n * n; ++i) {
    const auto at = [&](int places) { return (i / places % n + 0.5) / n * pitch / 2; };
    sums.push_back(lattice_sum_at(kernel, bcc, {at(1), at(n), at(n * n)}));
  }
  return sums;
}

// The largest of so few places is that of 99 of 100 within a fifth, for all kernels on BCC and CC.
double largest_gradient(const std::vector<LatticeSum>& sums) {
  double most = 0;
  for (const LatticeSum& sum : sums) most = std::max(most, length(sum.gradient));
  return most;
}

} // namespace

double ripple_gradient(const Slice& slice) {
  if (slice.kernel.normalised) return 0;
  return largest_gradient(sums_of_cell(slice.kernel.space, slice.lattice.bcc));
}

double ripple_of_differences(const Slice& slice, KernelForm form) {
  if (slice.kernel.normalised) return 0;
  const std::vector<LatticeSum> sums =
      sums_of_cell(drawn_kernel(slice.kernel.space, form), slice.lattice.bcc);
  double mean = 0, square = 0;
  for (const LatticeSum& sum : sums) mean += sum.value / static_cast<double>(sums.size());
  for (const LatticeSum& sum : sums)
    square += (sum.value - mean) * (sum.value - mean) / static_cast<double>(sums.size());
  return std::min(largest_gradient(sums), differences_per_ripple * std::sqrt(square) / samples_apart);
}

double ripple_noise(const Slice& slice, RenderMode mode, KernelForm form, bool without_ripple) {
  if (mode == RenderMode::composite) return ripple_of_differences(slice, form);
  return (without_ripple ? left_of_ripple : 1) * ripple_gradient(slice);
}

GradientNoise gradient_noise(const ValueSurvey& survey, double step, double threshold) {
  const double sigma = std::hypot(survey.noise, sigma_per_step * threshold);
  const bool solid = survey.kind == ValueKind::solid || survey.kind == ValueKind::constant;
  const double rings = solid ? ringing * contrast(survey) : 0;
  const double most = contrast(survey) / (edge_voxels * surface_over_noise);
  return {std::min(std::max(std::hypot(gradient_sigmas * sigma, steps_of_terraces * step), rings), most), 0};
}

GradientNoise per_length(const GradientNoise& noise, double voxel) {
  return {noise.constant / voxel, noise.of_value / voxel};
}

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/kernels/kernels_cartesian_field.h"

#include <algorithm>
#include <cmath>

namespace bccsplat::bench {
namespace {

// Weights of the samples floor(x) - 1 .. + 2 at fraction f, and their slopes.
struct Weights {
  std::array<double, 4> value{}, slope{};
};

Weights weigh(CartesianKernel kernel, double f) {
  const double g = 1 - f;
  switch (kernel) {
  case CartesianKernel::linear:
    return {{0, g, f, 0}, {0, -1, 1, 0}};
  case CartesianKernel::catmull_rom:
    return {{-0.5 * f * g * g, 1 + f * f * (1.5 * f - 2.5), 1 + g * g * (1.5 * g - 2.5), -0.5 * g * f * f},
            {-0.5 * g * g + f * g, f * (4.5 * f - 5), -g * (4.5 * g - 5), 0.5 * f * f - f * g}};
  case CartesianKernel::cubic_interpolating:
    break;
  }
  return {{g * g * g / 6, 2.0 / 3 - f * f * (1 - f / 2), 2.0 / 3 - g * g * (1 - g / 2), f * f * f / 6},
          {-g * g / 2, f * (1.5 * f - 2), -g * (1.5 * g - 2), f * f / 2}};
}

size_t mirrored(int64_t i, int64_t n) {
  if (n == 1) return 0;
  const int64_t period = 2 * (n - 1);
  i = ((i % period) + period) % period;
  return i < n ? i : period - i;
}

} // namespace

void prefilter_cubic(double* line, size_t count, size_t stride) {
  if (count < 2) return;
  const double pole = std::sqrt(3.0) - 2;
  const auto at = [&](size_t i) -> double& { return line[i * stride]; };
  for (size_t i = 0; i < count; ++i) at(i) *= 6;
  // The causal start: the whole mirrored line, summed until the pole's powers are below rounding.
  double start = 0, power = 1;
  for (size_t i = 0; i < 60; ++i, power *= pole) start += power * at(mirrored(i, count));
  at(0) = start;
  for (size_t i = 1; i < count; ++i) at(i) += pole * at(i - 1);
  at(count - 1) = pole / (pole * pole - 1) * (at(count - 1) + pole * at(count - 2));
  for (size_t i = count - 1; i-- > 0;) at(i) = pole * (at(i + 1) - at(i));
}

CartesianField::CartesianField(const std::array<uint32_t, 4>& dims, std::vector<double> samples,
                               CartesianKernel kernel)
    : dims_(dims), values_(std::move(samples)), kernel_(kernel) {
  if (kernel != CartesianKernel::cubic_interpolating) return;
  size_t stride = 1;
  for (const uint32_t n : dims_) {
    for (size_t i = 0; i < values_.size(); ++i)
      if (i / stride % n == 0) prefilter_cubic(values_.data() + i, n, stride);
    stride *= n;
  }
}

double CartesianField::operator()(const Vec4& p, Vec4* gradient) const {
  std::array<Weights, 4> w;
  std::array<std::array<size_t, 4>, 4> at{};
  size_t stride = 1;
  for (size_t a = 0; a < 4; ++a) {
    const int64_t n = dims_[a];
    if (n == 1) {
      w[a] = {{1, 0, 0, 0}, {0, 0, 0, 0}};
      continue;
    }
    const double floor = std::clamp(std::floor(p[a]), 0.0, static_cast<double>(n - 2));
    w[a] = weigh(kernel_, p[a] - floor);
    for (size_t i = 0; i < 4; ++i)
      at[a][i] = stride * mirrored(static_cast<int64_t>(floor) - 1 + static_cast<int64_t>(i), n);
    stride *= dims_[a];
  }
  double value = 0;
  Vec4 slope{};
  for (size_t l = 0; l < 4; ++l)
    for (size_t k = 0; k < 4; ++k)
      for (size_t j = 0; j < 4; ++j) {
        double row = 0, steep = 0;
        for (size_t i = 0; i < 4; ++i) {
          const double v = values_[at[0][i] + at[1][j] + at[2][k] + at[3][l]];
          row += w[0].value[i] * v, steep += w[0].slope[i] * v;
        }
        const double y = w[1].value[j], z = w[2].value[k], t = w[3].value[l];
        value += y * z * t * row;
        slope[0] += y * z * t * steep;
        slope[1] += w[1].slope[j] * z * t * row;
        slope[2] += y * w[2].slope[k] * t * row;
        slope[3] += y * z * w[3].slope[l] * row;
      }
  if (gradient) *gradient = slope;
  return value;
}

} // namespace bccsplat::bench

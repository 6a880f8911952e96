// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <numbers>

#include "tests/bench/kernels/kernels.h"

namespace bccsplat::bench {
namespace {

constexpr double pi = std::numbers::pi;

// Fourier transforms for grid spacing 1.
double transform(CartesianKernel kernel, double xi) {
  const double x = pi * xi;
  const double sinc = std::abs(x) < 1e-6 ? 1 - x * x / 6 : std::sin(x) / x;
  switch (kernel) {
  case CartesianKernel::linear:
    return sinc * sinc;
  case CartesianKernel::catmull_rom:
    break;
  case CartesianKernel::cubic_interpolating:
    return sinc * sinc * sinc * sinc;
  }
  // Catmull-Rom is the interpolating cubic convolution with a = -1/2 (Keys 1981); Simpson's rule on its two
  // pieces.
  constexpr int n = 64;
  double sum = 0;
  for (int piece = 0; piece < 2; ++piece)
    for (int i = 0; i <= n; ++i) {
      const double t = piece + static_cast<double>(i) / n;
      const double value = piece == 0 ? (1.5 * t - 2.5) * t * t + 1 : ((-0.5 * t + 2.5) * t - 4) * t + 2;
      const double weight = i == 0 || i == n ? 1 : i & 1 ? 4 : 2;
      sum += weight * value * std::cos(2 * pi * xi * t);
    }
  return 2 * sum / (3 * n);
}

} // namespace

std::vector<WaveSample> cartesian_waves(CartesianKernel kernel, int dimensions, double rho, size_t count) {
  // The dual of Z^d is Z^d, so sums over it are products of sums along the axes.
  std::vector<WaveSample> waves;
  waves.reserve(count);
  for (const std::array<double, 4>& xi : ball_frequencies(dimensions, rho, count)) {
    WaveSample w;
    w.pass = w.symbol = 1;
    double total2 = 1;
    for (size_t a = 0; a < static_cast<size_t>(dimensions); ++a) {
      double sum = 0, sum2 = 0;
      for (int k = -20; k <= 20; ++k) {
        const double v = transform(kernel, xi[a] + k);
        sum += v;
        sum2 += v * v;
      }
      w.pass *= transform(kernel, xi[a]);
      w.symbol *= sum;
      total2 *= sum2;
    }
    w.alias2 = total2 - w.pass * w.pass;
    waves.push_back(w);
  }
  return waves;
}

} // namespace bccsplat::bench

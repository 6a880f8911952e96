// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "kernel/radial.h"

namespace bccsplat {

double RadialKernel::value(double r2) const {
  const double u = 1 - r2 / (radius * radius);
  if (u <= 0) return 0;
  double sum = 0;
  for (int j = terms - 1; j >= 0; --j) sum = sum * u + a[j];
  return sum;
}

double RadialKernel::slope(double r2) const {
  const double u = 1 - r2 / (radius * radius);
  if (u <= 0) return 0;
  double sum = 0;
  for (int j = terms - 1; j >= 1; --j) sum = sum * u + j * a[j];
  return -sum / (radius * radius);
}

double radial_integral(const RadialKernel& phi) {
  // The integral of u^j over the ball: 4 pi R^3 int_0^1 s^2 (1 - s^2)^j ds; the last factor is 1/3 for j = 0,
  // then times 2 j / (2 j + 3) per step.
  double sum = 0;
  double factor = 1.0 / 3;
  for (int j = 0; j < phi.terms; ++j) {
    if (j > 0) factor *= 2.0 * j / (2.0 * j + 3);
    sum += phi.a[j] * factor;
  }
  return 4 * std::numbers::pi * phi.radius * phi.radius * phi.radius * sum;
}

void normalise_on_bcc(RadialKernel& phi) {
  const double scale = std::numbers::sqrt2 / radial_integral(phi);
  for (double& a : phi.a) a *= scale;
}

RadialKernel gaussian_kernel(double g, double radius) {
  // exp(-g r^2) = exp(-a) exp(a u), a = g R^2. The Chebyshev series of exp(a u) on [0, 1],
  // exp(a/2) (I_0(a/2) + 2 sum_n I_n(a/2) T*_n(u)), needs half as many terms as Taylor's for the same error.
  constexpr double tolerance = 2e-8; // of phi(0); the terms left out sum to less than twice the first of them
  RadialKernel phi;
  phi.radius = radius;
  const double a = g * radius * radius;
  std::array<double, RadialKernel::max_terms> before{}; // T*_(n-1), T*_n as polynomials in u
  std::array<double, RadialKernel::max_terms> shifted{};
  shifted[0] = 1;
  for (int n = 0; n < RadialKernel::max_terms; ++n) {
    double term = 1; // (a/4)^(2k+n) / (k! (k+n)!): the series of I_n(a/2)
    for (int k = 1; k <= n; ++k) term *= a / 4 / k;
    double bessel = 0;
    for (int k = 0; term > 1e-20 * bessel; ++k) {
      bessel += term;
      term *= (a / 4) * (a / 4) / ((k + 1.0) * (k + 1.0 + n));
    }
    const double c = (n == 0 ? 1 : 2) * std::exp(-a / 2) * bessel;
    if (c < tolerance) break;
    phi.terms = n + 1;
    for (size_t j = 0; j < phi.a.size(); ++j) phi.a[j] += c * shifted[j];
    // T*_(n+1) = 2 (2u - 1) T*_n - T*_(n-1), and T*_1 = 2u - 1.
    const double twice = n == 0 ? 1 : 2;
    std::array<double, RadialKernel::max_terms> next{};
    for (size_t j = 0; j < next.size(); ++j)
      next[j] = twice * ((j > 0 ? 2 * shifted[j - 1] : 0.0) - shifted[j]) - before[j];
    before = shifted;
    shifted = next;
  }
  normalise_on_bcc(phi);
  return phi;
}

} // namespace bccsplat

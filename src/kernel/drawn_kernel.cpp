// SPDX-License-Identifier: Apache-2.0
#include "kernel/drawn_kernel.h"

#include <array>
#include <cmath>
#include <numbers>

namespace bccsplat {
namespace {

// int_0^1 s^2 (1 - s^2)^n ds: 1/3 for n = 0, then times 2 n / (2 n + 3) per step.
double ball_moment(int n) {
  double m = 1.0 / 3;
  for (int j = 1; j <= n; ++j) m *= 2.0 * j / (2.0 * j + 3);
  return m;
}

// int_0^1 s^2 (1 - s^2)^n sin(q s) / (q s) ds: the spectrum of u^n, by Simpson's rule.
double ball_wave(int n, double q) {
  constexpr int intervals = 256;
  double sum = 0;
  for (int i = 1; i < intervals; ++i) { // both ends vanish
    const double s = static_cast<double>(i) / intervals;
    sum += (i & 1 ? 4 : 2) * s * std::pow(1 - s * s, n) * std::sin(q * s) / q;
  }
  return sum / (3 * intervals);
}

} // namespace

bool is_square_8(const RadialKernel& phi) { return phi.terms == 8 && phi.a[0] == 0 && phi.a[1] == 0; }

std::optional<RadialKernel> short_kernel(const RadialKernel& phi) {
  if (!is_square_8(phi)) return std::nullopt;
  // Normal equations for the coefficients of u^2, u^4, u^5 and the multiplier of the integral.
  constexpr int power[3] = {2, 4, 5};
  double m[4][5] = {};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) m[i][j] = ball_moment(power[i] + power[j]);
    m[i][3] = m[3][i] = ball_moment(power[i]);
    for (int j = 2; j < phi.terms; ++j) m[i][4] += phi.a[j] * ball_moment(power[i] + j);
  }
  for (int j = 2; j < phi.terms; ++j) m[3][4] += phi.a[j] * ball_moment(j);
  // No pivot is searched for: the matrix of moments is definite, and the zero at the end of the diagonal is
  // filled by the rows above it before its turn comes.
  for (int i = 0; i < 4; ++i) {
    for (int r = 0; r < 4; ++r) {
      if (r == i) continue;
      const double f = m[r][i] / m[i][i];
      for (int c = i; c < 5; ++c) m[r][c] -= f * m[i][c];
    }
  }
  std::array<double, RadialKernel::max_terms> a{};
  for (int i = 0; i < 3; ++i) a[power[i]] = m[i][4] / m[i][i];
  // The form must be monotone, so that bounds of the field from its coefficients hold, and near enough to
  // phi.
  if (!(a[2] >= 0 && a[4] >= 0 && a[5] >= 0)) return std::nullopt;
  constexpr int samples = 64;
  for (int n = 0; n <= samples; ++n) {
    const double u = static_cast<double>(n) / samples, w = u * u;
    const double got = w * (a[2] + w * (a[4] + a[5] * u));
    if (std::fabs(got - phi.value((1 - u) * phi.radius * phi.radius)) > 0.002 * phi.value(0))
      return std::nullopt;
  }
  return RadialKernel{phi.radius, 6, a};
}

std::optional<RadialKernel> flat_kernel(const RadialKernel& phi) {
  if (!is_square_8(phi)) return std::nullopt;
  double integral = 0, top = 0;
  for (int j = 2; j < phi.terms; ++j) {
    integral += phi.a[j] * ball_moment(j);
    top += phi.a[j];
  }
  const double q = 2 * std::numbers::pi * phi.radius, wave = ball_wave(2, q) / ball_wave(4, q);
  std::array<double, RadialKernel::max_terms> a{};
  a[2] = integral / (ball_moment(2) - wave * ball_moment(4));
  a[4] = -wave * a[2];
  // The form must be monotone here, too, and about as high as phi.
  if (!(a[2] >= 0 && a[4] >= 0 && std::fabs(a[2] + a[4] - top) < 0.03 * top)) return std::nullopt;
  return RadialKernel{phi.radius, 5, a};
}

RadialKernel drawn_kernel(const RadialKernel& phi, KernelForm form) {
  std::optional<RadialKernel> drawn;
  if (form == KernelForm::short_form) drawn = short_kernel(phi);
  if (form == KernelForm::flat_form) drawn = flat_kernel(phi);
  RadialKernel kernel = drawn.value_or(phi);
  for (double& a : kernel.a) a = static_cast<float>(a);
  return kernel;
}

} // namespace bccsplat

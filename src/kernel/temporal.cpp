// SPDX-License-Identifier: Apache-2.0
// Values, slopes and integrals of the temporal kernels: B-splines in closed form, their bends (kernel.h), and
// cut Gaussians.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "kernel/kernel.h"

namespace bccsplat {
namespace {

constexpr double pitch = std::numbers::sqrt2; // of the layers of one coset

// sum_k (-1)^k C(p, k) (p/2 - x - k)_+^n / n! for x >= 0: the centred B-spline of order p for n = p - 1, its
// integral from x to infinity for n = p, minus its slope for n = p - 2. Near the end of the support only the
// first term is left, so the value is never negative.
double spline_sum(int p, int n, double x) {
  double sum = 0;
  double binomial = 1;
  for (int k = 0; k <= p; ++k) {
    const double y = 0.5 * p - x - k;
    if (y <= 0) break;
    double power = binomial;
    for (int i = 1; i <= n; ++i) power *= y / i;
    sum += power;
    binomial *= -static_cast<double>(p - k) / (k + 1);
  }
  return sum;
}

// What is asked of the bends at x = |dt| / pitch (kernel.h): their value, slope, or integral from x to
// infinity.
enum class Of : uint8_t { value, slope, tail };

// Returns the gain of the outer layers of order 3 and 4, at h from the end of the support.
double outer_bend(const TemporalKernel& beta, Of what, double h) {
  const auto [first, second] = beta.bend;
  const double h2 = h * h, h3 = h2 * h;
  if (beta.order == 3) {
    if (what == Of::value) return h2 * (1 - h) * (first * (2 * h - 1) + second);
    if (what == Of::slope) return -first * h * (2 + h * (-9 + 8 * h)) + second * h * (2 - 3 * h);
    return first * h3 * (-1.0 / 3 + h * (0.75 - 0.4 * h)) + second * h3 * (1.0 / 3 - 0.25 * h);
  }
  if (what == Of::value) return first * h2 * (1 - h) * (1 - h);
  if (what == Of::slope) return first * 2 * h * (1 - h) * (1 - 2 * h);
  return first * h3 * (1.0 / 3 + h * (-0.5 + 0.2 * h));
}

// Returns the factor of bend[1], at x < 1.
double middle_bend(int m, Of what, double x) {
  const double y = 1 - 2 * x, z = 1 - y * y;
  const double power = m == 1 ? 1 : z; // z^(m - 1)
  if (what == Of::value) return y * power * z;
  if (what == Of::slope) return -2 * power * (z - 2 * m * y * y);
  return -power * z * z / (4 * (m + 1)); // y dy = -dz / 2 and dx = -dy / 2
}

double bend_sum(const TemporalKernel& beta, Of what, double x) {
  const double h = 0.5 * beta.order - x;
  const double turn = what == Of::slope ? -1 : 1; // d/dx of a function of h
  if (h <= 0) return 0;
  if (beta.order == 3) {
    if (x >= 0.5) return turn * outer_bend(beta, what, h);
    // The middle layer gives what the layers a pitch before and behind it take, at x - 1 and x + 1.
    const double after = turn * outer_bend(beta, what, 0.5 + x),
                 before = turn * outer_bend(beta, what, 0.5 - x);
    return what == Of::value ? -after - before : after - before;
  }
  double sum = 0;
  if (beta.order == 4 && x >= 1) sum = turn * outer_bend(beta, what, h);
  if (beta.order == 4 && x < 1) // h^2 (1 - h)^2 is the same for 1 - h
    sum = (what == Of::tail ? 1 : -1) * outer_bend(beta, what, x);
  return x < 1 ? sum + beta.bend[1] * middle_bend(beta.order / 2, what, x) : sum;
}

// Returns the integral of a centred B-spline of order p from x to infinity.
double spline_tail(int p, double x) { return x < 0 ? 1 - spline_sum(p, p, -x) : spline_sum(p, p, x); }

// Returns the same for a spline with its bends, which add nothing to the whole.
double tail(const TemporalKernel& beta, double x) {
  const double bent = bend_sum(beta, Of::tail, std::abs(x));
  return spline_tail(beta.order, x) + (x < 0 ? -bent : bent);
}

} // namespace

double TemporalKernel::value(double dt) const {
  const double d = std::abs(dt);
  if (d >= half_width) return 0;
  if (shape == Shape::gaussian) return scale * std::exp(-gaussian * dt * dt);
  return spline_sum(order, order - 1, d / pitch) + bend_sum(*this, Of::value, d / pitch);
}

double TemporalKernel::slope(double dt) const {
  const double d = std::abs(dt);
  if (d >= half_width || d == 0) return 0;
  if (shape == Shape::gaussian) return -2 * gaussian * dt * scale * std::exp(-gaussian * dt * dt);
  const double s = (bend_sum(*this, Of::slope, d / pitch) - spline_sum(order, order - 2, d / pitch)) / pitch;
  return dt > 0 ? s : -s;
}

double TemporalKernel::integral(double begin, double end) const {
  const double b = std::clamp(begin, -half_width, half_width);
  const double e = std::clamp(end, -half_width, half_width);
  if (shape == Shape::gaussian) {
    const double root = std::sqrt(gaussian);
    return scale * std::sqrt(std::numbers::pi) / (2 * root) * (std::erf(root * e) - std::erf(root * b));
  }
  return pitch * (tail(*this, b / pitch) - tail(*this, e / pitch));
}

} // namespace bccsplat

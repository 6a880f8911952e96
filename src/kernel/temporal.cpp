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

// Integral of a centred B-spline of order p from x to infinity.
double spline_tail(int p, double x) { return x < 0 ? 1 - spline_sum(p, p, -x) : spline_sum(p, p, x); }

} // namespace

double TemporalKernel::value(double dt) const {
  const double d = std::abs(dt);
  if (d >= half_width) return 0;
  if (shape == Shape::gaussian) return scale * std::exp(-gaussian * dt * dt);
  return spline_sum(order, order - 1, d / pitch);
}

double TemporalKernel::slope(double dt) const {
  const double d = std::abs(dt);
  if (d >= half_width || d == 0) return 0;
  if (shape == Shape::gaussian) return -2 * gaussian * dt * scale * std::exp(-gaussian * dt * dt);
  const double s = spline_sum(order, order - 2, d / pitch) / pitch;
  return dt > 0 ? -s : s;
}

double TemporalKernel::integral(double begin, double end) const {
  const double b = std::clamp(begin, -half_width, half_width);
  const double e = std::clamp(end, -half_width, half_width);
  if (shape == Shape::gaussian) {
    const double root = std::sqrt(gaussian);
    return scale * std::sqrt(std::numbers::pi) / (2 * root) * (std::erf(root * e) - std::erf(root * b));
  }
  return pitch * (spline_tail(order, b / pitch) - spline_tail(order, e / pitch));
}

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
#include "fit/beyond/field_model.h"

#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace bccsplat {
namespace {

// Power of the waves whose frequencies fill the ball of radius rho times Nyquist.
struct Ball {
  double rho, power;
};
// Chosen by hand: slow waves are predicted well, fast ones and noise are not made much worse.
constexpr std::array<Ball, 5> field{{{0.2, 1}, {0.3, 0.3}, {0.5, 0.1}, {0.7, 0.02}, {0.9, 0.003}}};

// Bessel function of order 2, x > 0, by Miller's recurrence: downwards from an order far above x it runs into
// the values themselves, but for a factor that their sum tells (J_0 + 2 J_2 + 2 J_4 + .. = 1). Sums and
// products alone, it has all digits in any rounding mode, unlike std::cyl_bessel_j.
double bessel_j2(double x) {
  double above = 0, here = 1e-200, second = 0, sum = 0; // J_(order + 1), J_order
  for (int order = 2 * static_cast<int>(0.6 * x) + 40; order > 0; --order) {
    if (order == 2) second = here;
    if (order % 2 == 0) sum += 2 * here;
    above = std::exchange(here, 2 * order / x * here - above);
  }
  return second / (sum + here);
}

// The transform of a ball, 1 at 0; a series near 0, where the quotients lose digits.
double ball_transform(int dimensions, double x) {
  if (dimensions == 3) return x < 1e-2 ? 1 - x * x / 10 : 3 * (std::sin(x) - x * std::cos(x)) / (x * x * x);
  return x < 1e-2 ? 1 - x * x / 12 : 8 * bessel_j2(x) / (x * x);
}

} // namespace

double field_correlation(int dimensions, double distance) {
  double sum = 0, power = 0;
  for (const Ball& ball : field) {
    const double x = std::numbers::pi * ball.rho * std::fabs(distance);
    sum += ball.power * ball_transform(dimensions, x), power += ball.power;
  }
  return sum / power;
}

std::vector<double> solve(std::vector<std::vector<double>> a) {
  const size_t n = a.size();
  for (size_t c = 0; c < n; ++c) {
    size_t pivot = c;
    for (size_t r = c; r < n; ++r)
      if (std::fabs(a[r][c]) > std::fabs(a[pivot][c])) pivot = r;
    std::swap(a[c], a[pivot]);
    for (double& v : a[c]) // the pivot itself last
      if (&v != &a[c][c]) v /= a[c][c];
    a[c][c] = 1;
    for (size_t r = 0; r < n; ++r) {
      if (r == c) continue;
      const double factor = a[r][c];
      for (size_t k = c; k <= n; ++k) a[r][k] -= factor * a[c][k];
    }
  }
  std::vector<double> x;
  for (const std::vector<double>& row : a) x.push_back(row[n]);
  return x;
}

} // namespace bccsplat

#include "fit/field_model.h"

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
// Chosen among some ten mixtures (tests/bench/notes/fit.md): slow waves are predicted well, fast ones and
// noise are not made much worse.
constexpr std::array<Ball, 5> field{{{0.2, 1}, {0.3, 0.3}, {0.5, 0.1}, {0.7, 0.02}, {0.9, 0.003}}};

// Bessel function of order 2, by its integral over a period: the trapezoid rule gives all digits once it has
// more nodes than x and some (in any rounding mode, unlike std::cyl_bessel_j).
double bessel_j2(double x) {
  const int nodes = 2 * static_cast<int>(x) + 60;
  double sum = 0;
  for (int k = 0; k < nodes; ++k) {
    const double angle = 2 * std::numbers::pi * k / nodes;
    sum += std::cos(2 * angle - x * std::sin(angle));
  }
  return sum / nodes;
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

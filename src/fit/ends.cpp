#include "fit/ends.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace bccsplat {
namespace {

// Frames next to an end that a prediction looks at, per widening. More hold up the first layers
// longer (tests/bench/notes/fit.md).
constexpr double frames_used = 6;

// Power of the waves whose frequencies fill the ball of radius rho times Nyquist, in 4D.
struct Ball {
  double rho, power;
};
// Chosen among some ten mixtures (tests/bench/notes/fit.md): slow waves are predicted well, fast ones and
// noise are not made much worse.
constexpr std::array<Ball, 5> field{{{0.2, 1}, {0.3, 0.3}, {0.5, 0.1}, {0.7, 0.02}, {0.9, 0.003}}};
// Times widening^2: weights stay small where frames are close. The sum of their squares is 30 one frame
// beyond the end and 94 at most.
constexpr double noise = 3e-5;

// Correlation of two frames `distance` apart. A ball in 4D has the density (1 - u^2)^(3/2) along an axis,
// whose transform is 8 J2(x) / x^2.
double correlation(double distance) {
  double sum = 0, power = 0;
  for (const Ball& ball : field) {
    const double x = std::numbers::pi * ball.rho * std::fabs(distance);
    // The series near 0, where the quotient loses digits.
    const double value = x < 1e-2 ? 1 - x * x / 12 : 8 * std::cyl_bessel_j(2.0, x) / (x * x);
    sum += ball.power * value, power += ball.power;
  }
  return sum / power;
}

// Gauss-Jordan elimination with partial pivoting of n rows of n + 1; the last column becomes the solution.
void solve(std::vector<std::vector<double>>& a) {
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
}

} // namespace

EndFrames::EndFrames(double widening)
    : widening_(widening), used_(static_cast<int64_t>(std::ceil(frames_used * widening))) {}

const std::vector<double>& EndFrames::weights(int64_t distance, int64_t frames) {
  const int64_t looked_at = std::min(frames, used_);
  auto [found, is_new] = known_.try_emplace({distance, looked_at});
  if (!is_new) return found->second;
  // Least mean square error under the constraint of the sum, by a Lagrange multiplier.
  const auto n = static_cast<size_t>(looked_at);
  std::vector<std::vector<double>> a(n + 1, std::vector<double>(n + 2));
  for (size_t i = 0; i < n; ++i) {
    for (size_t j = 0; j < n; ++j)
      a[i][j] = correlation((static_cast<double>(i) - static_cast<double>(j)) / widening_) +
                (i == j ? noise * widening_ * widening_ : 0);
    a[i][n] = a[n][i] = 1;
    a[i][n + 1] = correlation((static_cast<double>(i) + static_cast<double>(distance)) / widening_);
  }
  a[n][n + 1] = 1;
  solve(a);
  for (size_t i = 0; i < n; ++i) found->second.push_back(a[i][n + 1]);
  return found->second;
}

} // namespace bccsplat

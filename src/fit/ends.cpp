#include "fit/ends.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fit/field_model.h"

namespace bccsplat {
namespace {

// Frames next to an end that a prediction looks at, per widening. More hold up the first layers
// longer (tests/bench/notes/fit.md).
constexpr double frames_used = 6;

// Times widening^2: weights stay small where frames are close. The sum of their squares is 30 one frame
// beyond the end and 94 at most.
constexpr double noise = 3e-5;

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
      a[i][j] = field_correlation(4, (static_cast<double>(i) - static_cast<double>(j)) / widening_) +
                (i == j ? noise * widening_ * widening_ : 0);
    a[i][n] = a[n][i] = 1;
    a[i][n + 1] = field_correlation(4, (static_cast<double>(i) + static_cast<double>(distance)) / widening_);
  }
  a[n][n + 1] = 1;
  const std::vector<double> w = solve(std::move(a));
  found->second.assign(w.begin(), w.begin() + static_cast<std::ptrdiff_t>(n));
  return found->second;
}

} // namespace bccsplat

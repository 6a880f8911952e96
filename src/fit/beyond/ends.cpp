// SPDX-License-Identifier: Apache-2.0
#include "fit/beyond/ends.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fit/beyond/field_model.h"

namespace bccsplat {
namespace {

// Frames next to an end that a prediction looks at, per widening. More hold up the first layers longer.
constexpr double frames_used = 6;

} // namespace

EndFrames::EndFrames(double widening, double noise)
    : widening_(widening), noise_(noise), used_(used(widening)) {}

int64_t EndFrames::used(double widening) { return static_cast<int64_t>(std::ceil(frames_used * widening)); }

double EndFrames::correlation(int64_t lag) {
  for (int64_t next = correlations_.size(); next <= lag; ++next)
    correlations_.push_back(field_correlation(4, static_cast<double>(next) / widening_));
  return correlations_[lag];
}

const std::vector<double>& EndFrames::weights(int64_t distance, int64_t frames) {
  const int64_t looked_at = std::min(frames, used_);
  auto [found, is_new] = known_.try_emplace({distance, looked_at});
  if (!is_new) return found->second;
  // Least mean square error under the constraint of the sum, by a Lagrange multiplier.
  const size_t n = looked_at;
  std::vector<std::vector<double>> a(n + 1, std::vector<double>(n + 2));
  for (size_t i = 0; i < n; ++i) {
    for (size_t j = 0; j < n; ++j)
      a[i][j] = correlation(std::max(i, j) - std::min(i, j)) + (i == j ? noise_ * widening_ * widening_ : 0);
    a[i][n] = a[n][i] = 1;
    a[i][n + 1] = correlation(static_cast<int64_t>(i) + distance);
  }
  a[n][n + 1] = 1;
  const std::vector<double> w = solve(std::move(a));
  found->second.assign(w.begin(), w.begin() + n);
  return found->second;
}

void continue_rows(FilterTable& table, int64_t n, EndFrames& ends) {
  const size_t taps = table.taps;
  // Samples that a position may come to take, at either end.
  const int64_t most = std::min(n, std::max<int64_t>(table.taps, ends.used()));
  FilterTable inside{static_cast<int>(most), {}, {}};
  for (size_t i = 0; i < table.first.size(); ++i) {
    const int64_t first = table.first[i];
    const int64_t kept = std::clamp<int64_t>(first, 0, n - most);
    std::vector<double> sum(static_cast<size_t>(most));
    for (size_t k = 0; k < taps; ++k) {
      const int64_t at = first + static_cast<int64_t>(k), beyond = std::max(-at, at - (n - 1));
      const double weight = table.weight[i * taps + k];
      if (weight == 0) continue;
      if (beyond <= 0) {
        sum[at - kept] += weight;
        continue;
      }
      const std::vector<double>& w = ends.weights(beyond, n);
      for (size_t j = 0; j < w.size(); ++j) {
        const int64_t inner = j;
        sum[(at < 0 ? inner : n - 1 - inner) - kept] += weight * w[j];
      }
    }
    inside.first.push_back(kept);
    for (const double w : sum) inside.weight.push_back(static_cast<float>(w));
  }
  table = std::move(inside);
}

} // namespace bccsplat

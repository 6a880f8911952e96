// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/motion/fixed_in_time.h"

#include <algorithm>

namespace bccsplat::bench {
namespace {

// Where an index lies: after frame `first`, by a share of the interval.
struct Place {
  size_t first;
  double share;
};
Place place_of(double index, size_t n) {
  const size_t first = std::min(static_cast<size_t>(index), n - 2);
  return {first, index - static_cast<double>(first)};
}

std::vector<double> catmull_rom(const Place& p, size_t n) {
  const double f = p.share, g = 1 - f;
  const std::array<double, 4> by{-f * g * g / 2, (f * f * (3 * f - 5) + 2) / 2, (g * g * (3 * g - 5) + 2) / 2,
                                 -g * f * f / 2};
  std::vector<double> w(n);
  for (size_t k = 0; k < 4; ++k) {
    const size_t at = p.first + k; // one more than the frame's number
    if (at == 0)
      w[0] += 2 * by[k], w[1] -= by[k];
    else if (at > n)
      w[n - 1] += 2 * by[k], w[n - 2] -= by[k];
    else
      w[at - 1] += by[k];
  }
  return w;
}

std::vector<double> lagrange(const Place& p, size_t n) {
  const size_t count = std::min<size_t>(n, 4);
  const size_t begin = std::min(p.first > 0 ? p.first - 1 : 0, n - count);
  const double at = static_cast<double>(p.first) + p.share;
  std::vector<double> w(n);
  for (size_t i = begin; i < begin + count; ++i) {
    w[i] = 1;
    for (size_t j = begin; j < begin + count; ++j)
      if (j != i) w[i] *= (at - static_cast<double>(j)) / (static_cast<double>(i) - static_cast<double>(j));
  }
  return w;
}

// m[k-1] + 4 m[k] + m[k+1] = 6 (f[k-1] - 2 f[k] + f[k+1]), none at the ends, for each frame f apart.
std::vector<double> natural_spline(const Place& p, size_t n) {
  const double f = p.share, g = 1 - f;
  std::vector<double> w(n);
  for (size_t i = 0; i < n; ++i) {
    std::vector<double> m(n), diagonal(n, 4);
    for (size_t k = 1; k + 1 < n; ++k) {
      m[k] = 6 * ((i == k - 1) - 2. * (i == k) + (i == k + 1));
      if (k > 1) diagonal[k] -= 1 / diagonal[k - 1], m[k] -= m[k - 1] / diagonal[k - 1];
    }
    for (size_t k = n - 2; k >= 1; --k) m[k] = (m[k] - m[k + 1]) / diagonal[k];
    w[i] = g * (i == p.first) + f * (i == p.first + 1) + (g * g * g - g) / 6 * m[p.first] +
           (f * f * f - f) / 6 * m[p.first + 1];
  }
  return w;
}

} // namespace

std::vector<double> blend_weights(double index, size_t n) {
  const Place p = place_of(index, n);
  std::vector<double> w(n);
  w[p.first] = 1 - p.share, w[p.first + 1] = p.share;
  return w;
}

std::array<std::vector<double>, time_cubics> cubic_weights(double index, size_t n) {
  const Place p = place_of(index, n);
  return {catmull_rom(p, n), lagrange(p, n), natural_spline(p, n)};
}

motion::Box weighted(const std::vector<motion::Box>& frames, const std::vector<double>& weights) {
  motion::Box sum{frames[0].dims, std::vector<float>(frames[0].values.size())};
  for (size_t i = 0; i < frames.size(); ++i)
    for (size_t k = 0; weights[i] != 0 && k < sum.values.size(); ++k)
      sum.values[k] += static_cast<float>(weights[i]) * frames[i].values[k];
  return sum;
}

} // namespace bccsplat::bench

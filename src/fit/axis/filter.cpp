// SPDX-License-Identifier: Apache-2.0
// The resampling filter, a Kaiser-windowed sinc of 8 taps, as tables of its weights at given positions.
#include "fit/axis/filter.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace bccsplat {
namespace {

// Half width of the filter at widening 1, in samples, and the shape of its Kaiser window.
constexpr int half_width = 4;
constexpr double window_beta = 5.5;

double sinc(double x) {
  if (x == 0) return 1;
  if (x == std::round(x)) return 0; // sin(pi x) in floating point is not
  return std::sin(std::numbers::pi * x) / (std::numbers::pi * x);
}

// Modified Bessel function of order 0, by its power series; |x| <= 7 here.
double bessel_i0(double x) {
  double term = 1, sum = 1;
  for (int k = 1; term > 1e-17 * sum; ++k) {
    term *= (x / 2 / k) * (x / 2 / k);
    sum += term;
  }
  return sum;
}

// Columns that are 0 for every position go: a table of whole samples has one tap.
void trim(FilterTable& table) {
  const auto taps = static_cast<size_t>(table.taps), count = table.first.size();
  const auto empty = [&](size_t k) {
    for (size_t i = 0; i < count; ++i)
      if (table.weight[i * taps + k] != 0) return false;
    return true;
  };
  size_t begin = 0, end = taps;
  while (end - begin > 1 && empty(begin)) ++begin;
  while (end - begin > 1 && empty(end - 1)) --end;
  std::vector<float> kept;
  for (size_t i = 0; i < count; ++i) {
    table.first[i] += static_cast<int64_t>(begin);
    for (size_t k = begin; k < end; ++k) kept.push_back(table.weight[i * taps + k]);
  }
  table.weight = std::move(kept);
  table.taps = static_cast<int>(end - begin);
}

} // namespace

double kaiser_window(double u, double beta) {
  return bessel_i0(beta * std::sqrt(std::max(0.0, 1 - u * u))) / bessel_i0(beta);
}

int filter_reach(double widening) { return static_cast<int>(std::ceil(half_width * widening)); }

FilterTable filter_table(double widening, std::span<const double> positions) {
  const int reach = filter_reach(widening);
  FilterTable table;
  table.taps = 2 * reach;
  std::vector<double> w(static_cast<size_t>(table.taps));
  for (double p : positions) {
    if (std::fabs(p - std::round(p)) < 1e-9) p = std::round(p);
    const auto first = static_cast<int64_t>(std::floor(p)) - reach + 1;
    double sum = 0;
    for (size_t k = 0; k < w.size(); ++k) {
      const double x = (p - static_cast<double>(first + static_cast<int64_t>(k))) / widening;
      w[k] = std::fabs(x) < half_width ? sinc(x) * kaiser_window(x / half_width, window_beta) : 0;
      sum += w[k];
    }
    table.first.push_back(first);
    for (const double v : w) table.weight.push_back(static_cast<float>(v / sum));
  }
  trim(table);
  return table;
}

int64_t mirror_index(int64_t i, int64_t n) {
  if (n == 1) return 0;
  const int64_t period = 2 * (n - 1);
  i %= period;
  if (i < 0) i += period;
  return i < n ? i : period - i;
}

} // namespace bccsplat

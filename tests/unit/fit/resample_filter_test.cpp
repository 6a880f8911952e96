// SPDX-License-Identifier: Apache-2.0
// One-dimensional resampling filters.
#include <cmath>
#include <complex>
#include <numbers>

#include <gtest/gtest.h>

#include "fit/axis/filter.h"

namespace bccsplat {
namespace {

constexpr Filter filters[] = {Filter::kaiser8, Filter::kaiser6, Filter::bspline3};

std::vector<double> positions(int count, double step) {
  std::vector<double> p;
  for (int i = 0; i < count; ++i) p.push_back(i * step);
  return p;
}

TEST(ResampleFilter, WeightsSumToOne) {
  for (const Filter filter : filters)
    for (const double widening : {1.0, 1.4, 3.0}) {
      const FilterTable t = filter_table(filter, widening, positions(40, 0.37));
      for (size_t i = 0; i < 40; ++i) {
        double sum = 0;
        for (int k = 0; k < t.taps; ++k) sum += t.weight[i * t.taps + k];
        EXPECT_NEAR(sum, 1, 3e-7);
        EXPECT_LE(t.taps, 2 * filter_reach(filter, widening));
      }
    }
}

TEST(ResampleFilter, WholePositionsAreOneTap) {
  for (const Filter filter : filters) {
    const FilterTable t = filter_table(filter, 1, positions(30, 1.0000000000001));
    ASSERT_EQ(t.taps, 1);
    for (size_t i = 0; i < 30; ++i) {
      EXPECT_EQ(t.first[i], static_cast<int64_t>(i));
      EXPECT_EQ(t.weight[i], 1.0f);
    }
  }
}

// The value a filter gives for samples of f, at p.
double resampled(Filter filter, double widening, double p, const auto& f) {
  const std::vector<double> at{p};
  const FilterTable t = filter_table(filter, widening, at);
  double sum = 0;
  for (int k = 0; k < t.taps; ++k) sum += t.weight[k] * f(static_cast<double>(t.first[0] + k));
  return sum;
}

TEST(ResampleFilter, SplineReproducesCubics) {
  const auto f = [](double x) { return 1 + x * (0.5 + x * (-0.3 + x * 0.02)); };
  for (double p = 50; p < 51; p += 0.07) {
    // Where the filter is cut its weights are 2e-6; the cubic differs from its value at p by some thousand
    // there.
    const auto local = [&](double x) { return f(x - 50); };
    EXPECT_NEAR(resampled(Filter::bspline3, 1, p, local), local(p), 1e-3);
  }
}

TEST(ResampleFilter, KaiserPassesHalfTheBand) {
  for (const auto& [filter, bound] : {std::pair{Filter::kaiser8, 2e-3}, {Filter::kaiser6, 8e-3}})
    for (double w = 0; w < 0.5; w += 0.05)
      for (double p = 10; p < 11; p += 0.13) {
        const auto wave = [&](double x) { return std::cos(std::numbers::pi * w * x + 0.4); };
        EXPECT_NEAR(resampled(filter, 1, p, wave), wave(p), bound);
      }
}

TEST(ResampleFilter, WidenedFilterStopsWhatALatticeCannotHold) {
  // At twice the distance only half the band fits; what lies well above must not alias.
  for (const Filter filter : filters)
    for (double p = 30; p < 31; p += 0.13) {
      const auto slow = [](double x) { return std::cos(std::numbers::pi * 0.2 * x + 1); };
      const auto fast = [](double x) { return std::cos(std::numbers::pi * 0.85 * x + 1); };
      EXPECT_NEAR(resampled(filter, 2, p, slow), slow(p), 0.01);
      EXPECT_NEAR(resampled(filter, 2, p, fast), 0, 0.01);
    }
}

TEST(ResampleFilter, MirrorsAtBothEnds) {
  for (const int64_t n : {1, 2, 3, 10})
    for (int64_t i = -40; i < 40; ++i) {
      const int64_t m = mirror_index(i, n);
      ASSERT_GE(m, 0);
      ASSERT_LT(m, n);
      EXPECT_EQ(mirror_index(-i, n), m);
      EXPECT_EQ(mirror_index(2 * (n - 1) - i, n), m);
      if (i >= 0 && i < n) {
        EXPECT_EQ(m, i);
      }
    }
}

} // namespace
} // namespace bccsplat

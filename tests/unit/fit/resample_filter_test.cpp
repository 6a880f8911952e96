// SPDX-License-Identifier: Apache-2.0
// One-dimensional resampling filters.
#include <cmath>
#include <complex>
#include <numbers>

#include <gtest/gtest.h>

#include "fit/axis/filter.h"

namespace bccsplat {
namespace {

std::vector<double> positions(int count, double step) {
  std::vector<double> p;
  for (int i = 0; i < count; ++i) p.push_back(i * step);
  return p;
}

TEST(ResampleFilter, WeightsSumToOne) {
  for (const double widening : {1.0, 1.4, 3.0}) {
    const FilterTable t = filter_table(widening, positions(40, 0.37));
    for (size_t i = 0; i < 40; ++i) {
      double sum = 0;
      for (int k = 0; k < t.taps; ++k) sum += t.weight[i * t.taps + k];
      EXPECT_NEAR(sum, 1, 3e-7);
      EXPECT_LE(t.taps, 2 * filter_reach(widening));
    }
  }
}

TEST(ResampleFilter, WholePositionsAreOneTap) {
  const FilterTable t = filter_table(1, positions(30, 1.0000000000001));
  ASSERT_EQ(t.taps, 1);
  for (size_t i = 0; i < 30; ++i) {
    EXPECT_EQ(t.first[i], static_cast<int64_t>(i));
    EXPECT_EQ(t.weight[i], 1.0f);
  }
}

// The value that the filter gives for samples of f, at p.
double resampled(double widening, double p, const auto& f) {
  const std::vector<double> at{p};
  const FilterTable t = filter_table(widening, at);
  double sum = 0;
  for (int k = 0; k < t.taps; ++k) sum += t.weight[k] * f(static_cast<double>(t.first[0] + k));
  return sum;
}

TEST(ResampleFilter, PassesHalfTheBand) {
  for (double w = 0; w < 0.5; w += 0.05)
    for (double p = 10; p < 11; p += 0.13) {
      const auto wave = [&](double x) { return std::cos(std::numbers::pi * w * x + 0.4); };
      EXPECT_NEAR(resampled(1, p, wave), wave(p), 2e-3);
    }
}

TEST(ResampleFilter, WidenedFilterStopsWhatALatticeCannotHold) {
  // At twice the distance only half the band fits; what lies well above must not alias.
  for (double p = 30; p < 31; p += 0.13) {
    const auto slow = [](double x) { return std::cos(std::numbers::pi * 0.2 * x + 1); };
    const auto fast = [](double x) { return std::cos(std::numbers::pi * 0.85 * x + 1); };
    EXPECT_NEAR(resampled(2, p, slow), slow(p), 0.01);
    EXPECT_NEAR(resampled(2, p, fast), 0, 0.01);
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

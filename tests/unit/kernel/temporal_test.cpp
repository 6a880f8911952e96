// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "kernel/kernel.h"

namespace bccsplat {
namespace {

constexpr double layer_pitch = std::numbers::sqrt2;

class SplineOrders : public testing::TestWithParam<int> {
 protected:
  TemporalKernel beta = make_kernel("radial20+b" + std::to_string(GetParam())).time;
};
INSTANTIATE_TEST_SUITE_P(Splines, SplineOrders, testing::Values(2, 3, 4));

TEST_P(SplineOrders, LayersOfACosetSumToOneAtAnyPhase) {
  for (double phase = 0; phase < layer_pitch; phase += 0.0137) {
    double sum = 0;
    for (int k = -4; k <= 4; ++k) sum += beta.value(k * layer_pitch - phase);
    EXPECT_NEAR(sum, 1, 1e-14);
  }
}

TEST_P(SplineOrders, WithoutBendsIsTheTextbookSpline) {
  beta.bend = {};
  for (double t = -3; t < 3; t += 0.01) {
    const double x = std::abs(t) / layer_pitch;
    double expected = 0;
    if (GetParam() == 2) expected = std::max(1 - x, 0.0);
    if (GetParam() == 3) expected = x < 0.5 ? 0.75 - x * x : x < 1.5 ? 0.5 * (1.5 - x) * (1.5 - x) : 0;
    if (GetParam() == 4)
      expected = x < 1 ? 2.0 / 3 - x * x + x * x * x / 2 : x < 2 ? std::pow(2 - x, 3) / 6 : 0;
    EXPECT_NEAR(beta.value(t), expected, 1e-14) << t;
    EXPECT_GE(beta.value(t), 0);
  }
  EXPECT_EQ(beta.value(beta.half_width), 0);
  EXPECT_DOUBLE_EQ(beta.half_width, GetParam() * layer_pitch / 2);
}

TEST_P(SplineOrders, BendsAreThoseOfTheFormula) {
  TemporalKernel straight = beta;
  straight.bend = {};
  const int order = GetParam();
  for (const std::array<double, 2>& bend : {std::array{0.3, 0.0}, {0.0, 0.2}}) {
    beta.bend = bend;
    for (double t = -3; t < 3; t += 0.0173) {
      const double d = std::abs(t) / layer_pitch;
      const auto outer = [&](double h) {
        if (h < 0 || h > 1) return 0.0;
        return h * h * (1 - h) * (order == 3 ? bend[0] * (2 * h - 1) + bend[1] : bend[0] * (1 - h));
      };
      double expected = 0;
      if (order == 3) expected = outer(1.5 - d) - outer(0.5 + d) - outer(0.5 - d);
      if (order == 4) expected = outer(2 - d) - outer(1 - d);
      if (order != 3 && d < 1) {
        const double x = 1 - 2 * d;
        expected += bend[1] * x * std::pow(1 - x * x, order / 2);
      }
      EXPECT_NEAR(beta.value(t) - straight.value(t), expected, 1e-14) << t;
    }
  }
}

TEST_P(SplineOrders, ShippedBendsKeepTheSignAndTheSlopeContinuous) {
  EXPECT_EQ(beta.bend[1] != 0, GetParam() > 2);
  double before = beta.slope(-beta.half_width - 1e-3);
  for (double t = -beta.half_width; t < beta.half_width; t += 1e-3) {
    EXPECT_GE(beta.value(t), 0) << t;
    if (GetParam() == 2) continue; // a hat
    EXPECT_NEAR(beta.slope(t), before, 4e-3) << t;
    before = beta.slope(t);
  }
}

class TemporalKernels : public testing::TestWithParam<std::string> {
 protected:
  TemporalKernel beta = make_kernel(GetParam()).time;
};
INSTANTIATE_TEST_SUITE_P(Temporal, TemporalKernels,
                         testing::Values("radial20+b2", "radial20+b3", "radial20+b4", "gauss09", "paper"));

TEST_P(TemporalKernels, SlopeIsTheDerivative) {
  constexpr double h = 1e-6;
  for (double t = -beta.half_width + 0.01; t < beta.half_width - h; t += 0.0171) // never at a knot
    EXPECT_NEAR(beta.slope(t), (beta.value(t + h) - beta.value(t - h)) / (2 * h), 1e-8) << t;
  EXPECT_EQ(beta.slope(beta.half_width + 1), 0);
}

TEST_P(TemporalKernels, IntegralAgreesWithQuadrature) {
  for (const auto& [begin, end] :
       {std::pair{-0.3, 0.9}, {-9.0, 9.0}, {0.5, 1.7}, {-1.2, -0.2}, {0.9, -0.3}}) {
    constexpr int n = 20000;
    double sum = 0;
    for (int i = 0; i < n; ++i) sum += beta.value(begin + (end - begin) * (i + 0.5) / n) * (end - begin) / n;
    EXPECT_NEAR(beta.integral(begin, end), sum, 1e-6) << begin << " .. " << end;
  }
}

TEST_P(TemporalKernels, LayerSumIsOneInTheMeanForBothCosets) {
  constexpr int n = 400;
  double mean = 0;
  for (int i = 0; i < n; ++i)
    for (int k = -4; k <= 4; ++k) mean += beta.value((k - (i + 0.5) / n) * layer_pitch) / n;
  EXPECT_NEAR(mean, 1, 2e-4); // a cut Gaussian is a step: the rule sees it to its first order
}

TEST(KernelTemporal, GaussianIsTheExponential) {
  const TemporalKernel beta = make_kernel("gauss09").time;
  for (double t = -2.8; t < 2.8; t += 0.1)
    EXPECT_NEAR(beta.value(t) / beta.value(0), std::exp(-0.9 * t * t), 1e-14);
  EXPECT_EQ(beta.value(2 * layer_pitch), 0);
}

} // namespace
} // namespace bccsplat

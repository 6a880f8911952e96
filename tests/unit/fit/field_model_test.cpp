// SPDX-License-Identifier: Apache-2.0
// The correlation of the fields that predictions are made for, against waves themselves.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "fit/beyond/field_model.h"

namespace bccsplat::test {
namespace {

// The mean of f(0) f(x) over waves of the balls of field_model.cpp: along an axis a ball of frequencies has
// the density of its sections, (1 - u^2)^((dimensions - 1) / 2).
double mean_product(int dimensions, double distance) {
  constexpr std::array<std::array<double, 2>, 5> balls{
      {{0.2, 1}, {0.3, 0.3}, {0.5, 0.1}, {0.7, 0.02}, {0.9, 0.003}}};
  constexpr int steps = 20000;
  double sum = 0, power = 0;
  for (const auto& [rho, share] : balls) {
    double waves = 0, mean = 0;
    for (int i = 0; i < steps; ++i) {
      const double u = 2 * (i + 0.5) / steps - 1, density = std::pow(1 - u * u, 0.5 * (dimensions - 1));
      waves += density, mean += density * std::cos(rho * std::numbers::pi * u * distance);
    }
    sum += share * mean / waves, power += share;
  }
  return sum / power;
}

TEST(FieldModel, CorrelationsAreThoseOfWavesThatFillBalls) {
  for (const int dimensions : {3, 4}) {
    EXPECT_DOUBLE_EQ(field_correlation(dimensions, 0), 1);
    for (const double distance : {0.5, 1.0, 2.5, 6.0, 11.0}) {
      EXPECT_NEAR(field_correlation(dimensions, distance), mean_product(dimensions, distance), 1e-6)
          << dimensions << " dimensions, distance " << distance;
      EXPECT_EQ(field_correlation(dimensions, -distance), field_correlation(dimensions, distance));
    }
    // The series near 0 and the quotient meet.
    const double seam = 1e-2 / (std::numbers::pi * 0.9);
    EXPECT_NEAR(field_correlation(dimensions, seam * (1 - 1e-9)),
                field_correlation(dimensions, seam * (1 + 1e-9)), 1e-10);
  }
}

TEST(FieldModel, EquationsAreSolvedWhateverTheOrderOfTheirPivots) {
  // x = (3, -1, 2), with a 0 on the diagonal.
  const std::vector<double> x = solve({{0, 2, 1, 0}, {1, 1, 1, 4}, {4, 0, -2, 8}});
  ASSERT_EQ(x.size(), 3u);
  EXPECT_NEAR(x[0], 3, 1e-12);
  EXPECT_NEAR(x[1], -1, 1e-12);
  EXPECT_NEAR(x[2], 2, 1e-12);
}

} // namespace
} // namespace bccsplat::test

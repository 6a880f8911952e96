// SPDX-License-Identifier: Apache-2.0
// Values of a volume at points, against the truth and against their own differences.
#pragma once

#include <gtest/gtest.h>

#include "field/evaluate.h"
#include "tests/support/fields.h"

namespace bccsplat::test {

// All points lie inside.
inline std::vector<float> evaluate_values(const Coefficients& c, const std::vector<Vec4>& points,
                                          const Context& context) {
  std::vector<float> values(points.size());
  EXPECT_EQ(evaluate4(c, points, values, {}, context).outside, 0u);
  return values;
}

inline double snr_db(const std::vector<float>& got, const std::vector<Vec4>& points, const Field4& truth) {
  double signal = 0, error = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    const double f = truth(points[i]), off = got[i] - f;
    signal += f * f, error += off * off;
  }
  return 10 * std::log10(signal / error);
}

// Per axis: points whose gradient is further than `tolerance` from a central difference.
inline std::array<size_t, 4> gradient_misses(const Coefficients& c, const std::vector<Vec4>& points,
                                             double tolerance, const Context& context) {
  std::vector<float> values(points.size());
  std::vector<std::array<float, 4>> gradients(points.size());
  evaluate4(c, points, values, gradients, context);
  constexpr double h = 4e-3;
  std::array<size_t, 4> misses{};
  for (size_t a = 0; a < 4; ++a) {
    auto low = points, high = points;
    for (Vec4& p : low) p[a] -= h;
    for (Vec4& p : high) p[a] += h;
    const auto below = evaluate_values(c, low, context), above = evaluate_values(c, high, context);
    for (size_t i = 0; i < points.size(); ++i)
      misses[a] += std::fabs(gradients[i][a] - (above[i] - below[i]) / (2 * h)) > tolerance;
  }
  return misses;
}

} // namespace bccsplat::test

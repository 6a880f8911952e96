// SPDX-License-Identifier: Apache-2.0
// The normal form of hyperplanes.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/error.h"
#include "field/hyperplane.h"

namespace bccsplat {
namespace {

TEST(Hyperplane, HasAUnitNormalWhateverTheLengthGiven) {
  const Hyperplane expected(0.5, -0.5, 0.5, 0.5, 3);
  for (const double scale : {1e-300, 1e-9, 1.0, 7.0, 1e300}) {
    const Hyperplane h(scale, -scale, scale, scale, 6 * scale);
    for (size_t i = 0; i < 5; ++i) EXPECT_NEAR(h[i], expected[i], 1e-15) << scale;
  }
}

TEST(Hyperplane, HeightIsTheSignedDistance) {
  const Hyperplane h(3, 0, 4, 0, -10);
  EXPECT_NEAR(height(h, {0, 9, 0, 9}), -2, 1e-15);
  EXPECT_NEAR(height(h, {2, 0, 1, 0}), 0, 1e-15);
  EXPECT_NEAR(height(h.moved(1.5), {2, 0, 1, 0}), -1.5, 1e-15);
  EXPECT_EQ(h.moved(1.5).normal(), h.normal());
}

TEST(Hyperplane, GoesThroughItsPoint) {
  const Vec4 normal{0.1, 0.7, -0.5, 0.5}, point{3, -8, 2.5, 40};
  const Hyperplane h = Hyperplane::through(point, normal);
  EXPECT_NEAR(height(h, point), 0, 1e-14);
  for (size_t i = 0; i < 4; ++i) EXPECT_NEAR(h[i], normal[i], 1e-15);
}

TEST(Hyperplane, RefusesWhatHasNoNormal) {
  const auto refused = [](double a, double d, double e) {
    try {
      (void)Hyperplane(a, 0, 0, d, e);
    } catch (const Error& error) {
      return error.code() == Code::invalid_argument;
    }
    return false;
  };
  constexpr double infinity = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(refused(0, 0, -2));
  EXPECT_TRUE(refused(std::nan(""), 1, 0));
  EXPECT_TRUE(refused(1, infinity, 0));
  EXPECT_TRUE(refused(0, 1, -infinity));
  EXPECT_TRUE(refused(1e-300, 0, 1e300)); // e of the unit normal would overflow
}

} // namespace
} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Indices, even positions and coordinates of uneven axes: samples exact, both ways the same, monotone.
#include <gtest/gtest.h>

#include <cmath>

#include "points/uneven_axes.h"

namespace bccsplat {
namespace {

const std::vector<double> depths{0, 10, 20, 30, 50, 75, 100, 125, 150, 200, 250, 300, 400, 500, 700, 1000};
const std::vector<double> pressures{1000, 925, 850, 700, 500, 300, 250, 200, 100, 70, 50, 20, 10};

TEST(UnevenAxes, SamplesStandInProportionToTheirCoordinates) {
  for (const auto& at : {depths, pressures}) {
    const UnevenAxes axes({std::vector<double>{}, {}, at});
    EXPECT_FALSE(axes.uneven(0));
    ASSERT_TRUE(axes.uneven(2));
    const double last = static_cast<double>(at.size()) - 1;
    for (size_t i = 0; i < at.size(); ++i) {
      const double even = last * (at[i] - at[0]) / (at.back() - at[0]);
      EXPECT_NEAR(axes.even_of(2, static_cast<double>(i)), even, 1e-12);
      EXPECT_NEAR(axes.index_of(2, even), static_cast<double>(i), 1e-12);
      EXPECT_EQ(axes.nearest_sample(2, even), static_cast<int64_t>(i));
    }
  }
}

TEST(UnevenAxes, TheWayBackIsTheWay) {
  const UnevenAxes axes({depths, pressures, {}});
  for (size_t a = 0; a < 2; ++a) {
    const double last = static_cast<double>((a == 0 ? depths : pressures).size()) - 1;
    double before = -1;
    for (double i = 0; i <= last; i += 1.0 / 64) {
      const double even = axes.even_of(a, i);
      EXPECT_GT(even, before);
      before = even;
      EXPECT_NEAR(axes.index_of(a, even), i, 1e-12 * last);
      const double h = 1e-6, low = std::max(0.0, i - h), high = std::min(last, i + h);
      EXPECT_NEAR(axes.slope_at(a, i), (axes.even_of(a, high) - axes.even_of(a, low)) / (high - low), 1e-5);
    }
  }
}

TEST(UnevenAxes, BeyondTheEndsTheyGoOnStraight) {
  const UnevenAxes axes({std::vector<double>{}, depths, {}});
  for (const double p : {-3.0, -1e-9, 15.0, 15.5, 99.0}) {
    const double end = p < 1 ? 0 : 15;
    EXPECT_NEAR(axes.even_of(1, p), end + (p - end) * axes.slope_at(1, end), 1e-12);
    EXPECT_NEAR(axes.index_of(1, axes.even_of(1, p)), p, 1e-12);
    EXPECT_EQ(axes.even_of(0, p), p);
  }
  EXPECT_TRUE(std::isnan(axes.index_of(1, NAN)));
  EXPECT_EQ(axes.slope_at(0, 3), 1);
  EXPECT_EQ(axes.closest(0), 1);
  EXPECT_LE(axes.closest(1), 0.15 + 1e-12); // 10 m of 1000 in 15 steps
  EXPECT_GE(axes.closest(1), 0.10);
}

TEST(UnevenAxes, EvenCoordinatesChangeNothing) {
  const UnevenAxes axes({std::vector<double>{5, 7, 9, 11, 13}, {}, {}});
  for (double i = 0; i <= 4; i += 0.125) {
    EXPECT_NEAR(axes.even_of(0, i), i, 1e-14);
    EXPECT_NEAR(axes.slope_at(0, i), 1, 1e-14);
  }
}

// Between two samples the nearer one in index units decides, as for the field.
TEST(UnevenAxes, NearestSamplesChangeHalfWayInIndexUnits) {
  const UnevenAxes axes({depths, {}, {}});
  for (double i = 0.01; i < 15; i += 0.02)
    EXPECT_EQ(axes.nearest_sample(0, axes.even_of(0, i)), static_cast<int64_t>(std::floor(i + 0.5))) << i;
}

} // namespace
} // namespace bccsplat

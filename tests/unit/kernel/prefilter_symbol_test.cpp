// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/bench/kernels/kernel_spectrum.h"

namespace bccsplat {
namespace {

using Point = std::array<double, 4>;

// Returns the displacements between sites of D4* (BCC: t = 0 only) up to two layers and the given squared
// length in space. Coordinates are planes and layers, 1/sqrt2 apart: all even or all odd. On BCC the cosets
// are odd and even in space.
std::vector<Point> neighbours(int layers, int square, int dimensions) {
  std::vector<Point> found;
  for (int x = -2; x <= 2; ++x)
    for (int y = -2; y <= 2; ++y)
      for (int z = -2; z <= 2; ++z) {
        const int odd = x & 1;
        if ((y & 1) != odd || (z & 1) != odd || x * x + y * y + z * z != square) continue;
        for (int t = -2; t <= 2; ++t)
          if (std::abs(t) == layers && (dimensions == 3 || (t & 1) == odd)) {
            const double d = 1 / std::numbers::sqrt2;
            found.push_back({x * d, y * d, z * d, t * d});
          }
      }
  return found;
}

// Returns what summing the neighbours does to a plane wave.
double sum_symbol(const std::vector<Point>& sites, const Point& xi) {
  double sum = 0;
  for (const Point& d : sites)
    sum += std::cos(2 * std::numbers::pi * (xi[0] * d[0] + xi[1] * d[1] + xi[2] * d[2] + xi[3] * d[3]));
  return sum;
}

const std::vector<Point> frequencies{
    {0, 0, 0, 0}, {0.1, 0.23, -0.31, 0.4}, {0.5, 0, 0.2, -0.17}, {0.7, 0.6, 0.5, 0.3}};

TEST(PrefilterSymbol, OfEachNeighbourSumOnD4Star) {
  const auto spatial = neighbours(0, 4, 4), temporal = neighbours(2, 0, 4), mixed = neighbours(2, 4, 4);
  const auto cross = neighbours(1, 3, 4);
  ASSERT_EQ(spatial.size(), 6u);
  ASSERT_EQ(temporal.size(), 2u);
  ASSERT_EQ(mixed.size(), 12u);
  ASSERT_EQ(cross.size(), 16u);
  for (const Point& xi : frequencies) {
    const NeighbourMeans means = neighbour_means4(xi);
    const auto running = [&](const PrefilterStage& s) { return running_symbol(s, means, 16); };
    EXPECT_NEAR(running({.self = 0, .spatial = 1}), sum_symbol(spatial, xi), 1e-12);
    EXPECT_NEAR(running({.self = 0, .temporal = 1}), sum_symbol(temporal, xi), 1e-12);
    EXPECT_NEAR(running({.self = 0, .mixed = 1}), sum_symbol(mixed, xi), 1e-12);
    EXPECT_NEAR(running({.self = 0, .cross = 1}), sum_symbol(cross, xi), 1e-12);
    EXPECT_NEAR(source_symbol({.source_spatial = 1}, means), sum_symbol(spatial, xi), 1e-12);
    EXPECT_NEAR(source_symbol({.source_temporal = 1}, means), sum_symbol(temporal, xi), 1e-12);
    EXPECT_NEAR(source_symbol({.source_mixed = 1}, means), sum_symbol(mixed, xi), 1e-12);
    const PrefilterStage two[] = {{.self = 0.5, .cross = 0.1}, {.self = 2, .spatial = 0.3, .source = -1}};
    const double first = 0.5 + 0.1 * sum_symbol(cross, xi);
    EXPECT_NEAR(prefilter_symbol(two, means, 16), (2 + 0.3 * sum_symbol(spatial, xi)) * first - 1, 1e-12);
  }
}

TEST(PrefilterSymbol, OfEachNeighbourSumOnBcc) {
  const auto spatial = neighbours(0, 4, 3), cross = neighbours(0, 3, 3);
  ASSERT_EQ(cross.size(), 8u);
  for (const Point& p : frequencies) {
    const Point xi{p[0], p[1], p[2], 0};
    const NeighbourMeans means = neighbour_means3({p[0], p[1], p[2]});
    EXPECT_NEAR(running_symbol({.self = 0, .spatial = 1}, means, 8), sum_symbol(spatial, xi), 1e-12);
    EXPECT_NEAR(running_symbol({.self = 0, .cross = 1}, means, 8), sum_symbol(cross, xi), 1e-12);
  }
}

TEST(PrefilterSymbol, GainIsTheSumOfTheMagnitudesOfTheTaps) {
  const PrefilterStage one[] = {
      {.self = 2, .spatial = -0.1, .temporal = 0.2, .mixed = -0.05, .cross = -0.03}};
  EXPECT_NEAR(prefilter_gain4(one), 2 + 6 * 0.1 + 2 * 0.2 + 12 * 0.05 + 16 * 0.03, 1e-12);
  const PrefilterStage flat[] = {{.self = 2, .spatial = -0.1, .cross = -0.03}};
  EXPECT_NEAR(prefilter_gain3(flat), 2 + 6 * 0.1 + 8 * 0.03, 1e-12);
  // (1 + a S)^2 = 1 + 2 a S + a^2 (6 + pairs): the 36 products keep one sign each.
  const PrefilterStage squared[] = {{.self = 1, .spatial = -0.1}, {.self = 1, .spatial = -0.1}};
  EXPECT_NEAR(prefilter_gain3(squared), 1 + 1.2 + 0.36, 1e-12);
  // A c + B f with B = -A c of the first stage alone leaves nothing.
  const PrefilterStage nothing[] = {{.self = 1, .spatial = 0.25},
                                    {.self = 1, .source = -1, .source_spatial = -0.25}};
  EXPECT_NEAR(prefilter_gain3(nothing), 0, 1e-12);
}

TEST(PrefilterSymbol, ReachFollowsTheLongestWay) {
  const PrefilterStage cross_only[] = {{.cross = 0.1}, {.cross = 0.1}};
  EXPECT_EQ(prefilter_reach(cross_only).time, 2);
  EXPECT_EQ(prefilter_reach(cross_only).space, 2);
  const PrefilterStage temporal[] = {{.temporal = 0.1}, {.cross = 0.1, .source_spatial = 1}};
  EXPECT_EQ(prefilter_reach(temporal).time, 3);
  EXPECT_EQ(prefilter_reach(temporal).space, 2);
  EXPECT_EQ(prefilter_reach({}).time, 0);
}

} // namespace
} // namespace bccsplat

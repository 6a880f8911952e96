// SPDX-License-Identifier: Apache-2.0
// What comes through of light, where that is known: a block of one extinction, a wall, and directions of
// which the mean of a polynomial is that over the sphere.
#include "shade/light_volume.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/fields.h"

namespace bccsplat {
namespace {

constexpr int side = 9;

LightGrid block() { return {{1, 2, 3}, {0.5, 1, 2}, {side, side, side}}; }

// World length from a node to where light comes in, of a grid whose space is the world.
double way_out(const LightGrid& grid, const Vec3& p, const Vec3& towards) {
  double most = 1e30;
  for (size_t a = 0; a < 3; ++a) {
    if (towards[a] == 0) continue;
    const double end = towards[a] > 0 ? grid.begin[a] + grid.step[a] * (side - 1) : grid.begin[a];
    most = std::min(most, (end - p[a]) / towards[a]);
  }
  return most * length(towards);
}

TEST(LightVolume, ABlockLetsThroughWhatItsDepthSays) {
  const LightGrid grid = block();
  constexpr double extinction = 0.2;
  const std::vector<float> all(grid.size(), static_cast<float>(extinction));
  test::TestContext context;
  for (const Vec3& towards : {Vec3{1, 0, 0}, {-3, 0, 0}, {0, 1, 0}, {0, 0, -1}}) {
    const std::vector<float> light = light_through(grid, all, {towards, length(towards)}, context.get());
    size_t n = 0;
    for (int k = 0; k < side; ++k)
      for (int j = 0; j < side; ++j)
        for (int i = 0; i < side; ++i, ++n) {
          const Vec3 p{grid.begin[0] + grid.step[0] * i, grid.begin[1] + grid.step[1] * j,
                       grid.begin[2] + grid.step[2] * k};
          ASSERT_NEAR(light[n], std::exp(-extinction * way_out(grid, p, towards)), 1e-5) << n;
        }
  }
}

TEST(LightVolume, AWallThrowsItsShadowStraightOn) {
  const LightGrid grid{{0, 0, 0}, {1, 1, 1}, {side, side, side}};
  std::vector<float> wall(grid.size(), 0.0f); // one node of a plane
  constexpr int at = 6, column = 4;
  wall[(static_cast<size_t>(at) * side + column) * side + column] = 1;
  test::TestContext context;
  // One step along x for two along z: two planes below it the shadow has moved by one node.
  const std::vector<float> light = light_through(grid, wall, {{1, 0, 2}, std::sqrt(5.0)}, context.get());
  const auto share = [&](int i, int k) {
    return light[(static_cast<size_t>(k) * side + column) * side + static_cast<size_t>(i)];
  };
  const double through = std::exp(-std::sqrt(5.0) / 2);
  EXPECT_NEAR(share(column - 1, at - 2), through, 1e-5);
  EXPECT_NEAR(share(column - 3, at - 6), through, 1e-5);
  EXPECT_EQ(share(column + 1, at - 2), 1);
  EXPECT_EQ(share(column, at + 1), 1) << "what the light reaches first";
}

TEST(LightVolume, DirectionsAroundHaveTheMeansOfTheSphere) {
  double one = 0;
  Vec3 x2{}, x4{};
  double x2y2 = 0;
  for (const WayAround& way : all_around()) {
    const Vec3 d = normalized(way.direction);
    one += way.weight, x2y2 += way.weight * d[0] * d[0] * d[1] * d[1];
    for (size_t a = 0; a < 3; ++a) x2[a] += way.weight * d[a] * d[a], x4[a] += way.weight * std::pow(d[a], 4);
  }
  EXPECT_NEAR(one, 1, 1e-12);
  for (size_t a = 0; a < 3; ++a) {
    EXPECT_NEAR(x2[a], 1.0 / 3, 1e-12);
    EXPECT_NEAR(x4[a], 1.0 / 5, 1e-12);
  }
  EXPECT_NEAR(x2y2, 1.0 / 15, 1e-12);
}

TEST(LightVolume, IsLinearBetweenNodesAndGoesOnBeyond) {
  const LightGrid grid = block();
  std::vector<float> ramp(grid.size());
  for (size_t n = 0; n < ramp.size(); ++n) ramp[n] = static_cast<float>(n % side);
  const LightVolume volume(grid, {ramp}, {}, {});
  EXPECT_EQ(volume.lights(), 1u);
  EXPECT_FALSE(volume.has_ambient());
  EXPECT_FLOAT_EQ(volume.light(0, {1 + 0.5 * 2.25, 3.3, 4.4}), 2.25f);
  EXPECT_FLOAT_EQ(volume.light(0, {-10, 0, 0}), 0);
  EXPECT_FLOAT_EQ(volume.light(0, {100, 100, 100}), side - 1);
}

} // namespace
} // namespace bccsplat

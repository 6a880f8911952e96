// SPDX-License-Identifier: Apache-2.0
#include "points/rounded_brick.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/targets.h"

namespace bccsplat {
namespace {

Brick noise(float amplitude) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> value(-amplitude, amplitude);
  Brick brick;
  for (float& v : brick.value) v = value(random);
  brick.keep_above(0.3f * amplitude);
  return brick;
}

TEST(RoundedBrick, StepsAreAQuarterOfTheSamplesAtMost) {
  EXPECT_EQ(coarsest_step(1), 0.25f);
  EXPECT_EQ(coarsest_step(0.999), 0.125f);
  EXPECT_EQ(coarsest_step(2.5), 0.5f);
}

TEST(RoundedBrick, ValuesAreWithinHalfAStepAndAirStaysAir) {
  std::array<float, brick_sites> room;
  for (const float amplitude : {0.f, 1e-3f, 1.f, 60.f, 1000.f, 8191.f}) {
    const Brick brick = noise(amplitude);
    const auto rounded = RoundedBrick::round(brick, 0.25f);
    ASSERT_TRUE(rounded) << amplitude;
    int exponent = 0;
    EXPECT_EQ(std::frexp(rounded->step(), &exponent), 0.5f);
    EXPECT_LE(rounded->step(), 0.25f);
    EXPECT_GE(rounded->step(), 0.25f / 64);
    EXPECT_LE(rounded->bytes(), 9000u);
    const SampleBrick held{nullptr, rounded};
    const float* values = held.all(room);
    for (size_t i = 0; i < brick_sites; ++i) {
      ASSERT_LE(std::fabs(values[i] - brick.value[i]), rounded->step() / 2) << amplitude << " site " << i;
      if (brick.value[i] == 0) {
        ASSERT_EQ(values[i], 0);
      }
    }
    EXPECT_EQ(held.as_values()->kept, brick.kept);
  }
  EXPECT_FALSE(RoundedBrick::round(noise(9000), 0.25f)); // 16 bits do not hold it in steps so fine
}

TEST(RoundedBrick, HolesAndSitesThatAreKeptGoWithIt) {
  Brick brick = noise(1);
  BrickMask hole{};
  hole[7] = 0x0180;
  brick.hole = std::make_unique<BrickMask>(hole);
  const auto some = RoundedBrick::round(brick, 1);
  ASSERT_TRUE(some->hole());
  EXPECT_EQ(*some->hole(), hole);
  ASSERT_TRUE(some->kept());
  EXPECT_EQ(*some->kept(), brick.kept);
  brick.kept.fill(0xffff), brick.hole.reset();
  const SampleBrick all{nullptr, RoundedBrick::round(brick, 1)};
  EXPECT_FALSE(all.kept());
  EXPECT_FALSE(all.hole());
  EXPECT_EQ(all.as_values()->kept, brick.kept);
}

TEST(RoundedBrick, EveryTargetRoundsAlikeAndReadsAnyPart) {
  const Brick brick = noise(100);
  const auto reference = RoundedBrick::round(brick, 0.25f);
  std::array<float, brick_sites> expected, again;
  (void)SampleBrick{nullptr, reference}.all(expected);
  test::for_targets([&] {
    const auto rounded = RoundedBrick::round(brick, 0.25f);
    (void)SampleBrick{nullptr, rounded}.all(again);
    ASSERT_EQ(again, expected);
    for (const PlanePart part : {PlanePart{15, 15, 15, 1, 1}, PlanePart{3, 5, 2, 9, 11}, PlanePart{0}}) {
      std::array<float, 2 * brick_rows> plane{};
      rounded->read(part, plane.data(), 24);
      for (int y = 0; y < part.height; ++y)
        for (int x = 0; x < part.width; ++x)
          ASSERT_EQ(plane[y * 24 + x], expected[((part.plane * 16) + part.y + y) * 16 + part.x + x]);
    }
  });
}

} // namespace
} // namespace bccsplat

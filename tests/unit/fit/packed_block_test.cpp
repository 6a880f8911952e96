// SPDX-License-Identifier: Apache-2.0
// Blocks of whole numbers: what they lose, and when they are not made.
#include "fit/packed_block.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/fields.h"
#include "tests/support/targets.h"
#include "tests/unit/fit/fit_series.h"

namespace bccsplat::test {
namespace {

constexpr Int3 all{16, 16, 16};

Quantiser codes(double step) {
  Quantiser q;
  q.type = ValueType::u8;
  q.scale = step;
  return q;
}

TEST(PackedBlock, IsAPowerOfTwoAndASixtyFourthOfAStepAtMost) {
  EXPECT_EQ(packing_unit(codes(1)), 1.0f / 64);
  EXPECT_EQ(packing_unit(codes(3)), 1.0f / 32);
  EXPECT_EQ(packing_unit(codes(0.9)), 1.0f / 128);
  EXPECT_EQ(packing_unit(codes(1e-38)), 0.0f); // not a number that can be divided by
  Quantiser floats;
  floats.type = ValueType::f32;
  EXPECT_EQ(packing_unit(floats), 0.0f);
}

TEST(PackedBlock, RoundsToHalfAUnitAndKeepsWholeNumbersOnEveryTarget) {
  TestContext context;
  SiteBlockPool pool(context.memory);
  for_targets([&] {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> value(-300, 300);
    auto block = pool.floats.take();
    for (float& v : block->value) v = value(random);
    for (size_t i = 0; i < block->value.size(); i += 3) block->value[i] = std::round(block->value[i]);
    block->largest = 300;
    block->source.fill(0x1234);
    const auto before = block->value;
    const SiteBlockPtr packed = pack(block, all, 1.0f / 64, pool);
    ASSERT_TRUE(packed->packed);
    EXPECT_EQ(packed->largest, 300);
    EXPECT_EQ(packed->source, block->source);
    SiteValues room;
    const float* after = unpack(*packed, 1.0f / 64, room);
    for (size_t i = 0; i < before.size(); ++i) {
      ASSERT_LE(std::fabs(after[i] - before[i]), 1.0f / 128);
      if (i % 3 == 0) {
        ASSERT_EQ(after[i], before[i]);
      }
      ASSERT_EQ(after[i] * 64, std::nearbyint(before[i] * 64));
    }
  });
}

TEST(PackedBlock, StaysAsItIsWhereAValueDoesNotFit) {
  TestContext context;
  SiteBlockPool pool(context.memory);
  auto block = pool.floats.take();
  block->value.fill(1);
  block->value[77] = -600;
  EXPECT_FALSE(pack(block, all, 1.0f / 64, pool)->packed);
  EXPECT_FALSE(pack(block, all, 0, pool)->packed);
  EXPECT_TRUE(pack(block, {16, 4, 16}, 1.0f / 64, pool)->packed); // it lies in a row that is not there
}

// A spike that does not fit makes blocks of both kinds meet in one layer.
TEST(PackedBlock, MakesTheSameLayersButForTheUnit) {
  Series s = noise({37, 19, 22, 9}, 6);
  for (float& v : s.values) v = std::round(100 * v);
  s.values[s.values.size() / 2] = 700;
  FitOptions o = options_for(s);
  const auto floats = reference_layers(Lattice4::fit(o.lattice, o.dims), s, o.filter);
  for (FitChannel& c : o.channels) c.unit = 1.0f / 64, c.ringing = 0;
  for_targets([&] {
    const auto packed = run_fit(o, s);
    EXPECT_LT(worst_difference(packed, floats), 0.06);
    EXPECT_GT(worst_difference(packed, floats), 0.001);
  });
}

} // namespace
} // namespace bccsplat::test

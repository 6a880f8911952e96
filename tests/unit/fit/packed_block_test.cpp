// SPDX-License-Identifier: Apache-2.0
// Blocks of whole numbers: what they lose, and when they are not made.
#include "fit/kept/packed_block.h"

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

// Of a small range no unit is lost, of a larger one two bits are before 16 bits are taken for 12.
TEST(PackedBlock, RoundsToHalfAUnitAndKeepsWholeNumbers) {
  TestContext context;
  SiteBlockPool pool(context.memory);
  const struct {
    float range, start, unit;
    int bits;
  } cases[] = {{60, 0, 1, 12},  {60, 5000, 1, 12}, {250, -3, 4, 12},
               {300, 0, 1, 16}, {4000, 9, 4, 16},  {60, -200000, 1, 12}};
  for (const auto& c : cases) {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> value(c.start, c.start + c.range);
    auto block = pool.floats.take();
    for (float& v : block->value) v = value(random);
    for (size_t i = 0; i < block->value.size(); i += 3) block->value[i] = std::round(block->value[i]);
    block->largest = 300;
    block->source.fill(0x1234);
    const auto before = block->value;
    const SiteBlockPtr packed = pack(block, all, 1.0f / 64, pool);
    ASSERT_TRUE(packed->packed) << c.range;
    EXPECT_EQ(static_cast<const PackedSites&>(*packed).form.bits, c.bits) << c.range;
    EXPECT_EQ(packed->largest, 300);
    EXPECT_EQ(packed->source, block->source);
    alignas(64) std::array<float, brick_rows> plane;
    for (int i = 0; i < brick_sites; ++i) {
      const float after = plane_of(*packed, i / brick_rows, plane.data())[i % brick_rows];
      ASSERT_EQ(after, value_of(*packed, i)) << i;
      ASSERT_EQ(after * 64 / c.unit, std::nearbyint(before[i] * 64 / c.unit)) << i;
    }
  }
}

TEST(PackedBlock, StaysAsItIsWhereAValueDoesNotFit) {
  TestContext context;
  SiteBlockPool pool(context.memory);
  auto block = pool.floats.take();
  block->value.fill(1);
  block->value[77] = -6000;
  EXPECT_FALSE(pack(block, all, 1.0f / 64, pool)->packed);
  EXPECT_FALSE(pack(block, all, 0, pool)->packed);
  EXPECT_TRUE(pack(block, {16, 4, 16}, 1.0f / 64, pool)->packed); // it lies in a row that is not there
}

// A spike that does not fit makes blocks of both kinds meet in one layer.
TEST(PackedBlock, MakesTheSameLayersButForTheUnit) {
  Series s = noise({37, 19, 22, 9}, 6);
  for (float& v : s.values) v = std::round(100 * v);
  s.values[s.values.size() / 2] = 7000;
  FitOptions o = options_for(s);
  const auto floats = reference_layers(Lattice4::fit(o.lattice, o.dims), s);
  for (FitChannel& c : o.channels) c.unit = 1.0f / 64, c.ringing = 0;
  for_targets([&] {
    const auto packed = run_fit(o, s);
    EXPECT_LT(worst_difference(packed, floats), 0.06);
    EXPECT_GT(worst_difference(packed, floats), 0.001);
  });
}

} // namespace
} // namespace bccsplat::test

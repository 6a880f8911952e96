// SPDX-License-Identifier: Apache-2.0
// What is stored of a brick: rounding of every type, thresholds, holes, edges.
#include <cfloat>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "base/error.h"
#include "base/half.h"
#include "fit/kept/relevance.h"
#include "tests/support/targets.h"

namespace bccsplat {
namespace {

constexpr Int3 whole{16, 16, 16};

std::vector<float> values(double low, double high, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(low, high);
  std::vector<float> v(brick_sites);
  for (float& x : v) x = static_cast<float>(uniform(random));
  return v;
}

// Stored value relative to air, its code, and whether the type could not hold it: one formula per type, in
// double.
struct Stored {
  double value, code;
  bool clamped;
};
Stored reference(const Quantiser& q, float v) {
  const double air = q.air, absolute = v + air;
  if (q.type == ValueType::f32) return {v, v, false};
  if (q.type == ValueType::f16) {
    const double stored = q.offset == air ? static_cast<double>(v) : static_cast<double>(v + q.air);
    const bool over = std::fabs(stored) >= 65520;
    const double half = over ? std::copysign(65504.0, stored)
                             : static_cast<double>(half_to_float(float_to_half(static_cast<float>(stored))));
    return {q.offset == air ? half : static_cast<double>(static_cast<float>(half) - q.air), half, over};
  }
  const double code = std::nearbyint((absolute - q.offset) / q.scale), largest = largest_code(q.type);
  const double inside = std::min(std::max(code, 0.0), largest);
  return {relative_value(q, inside), inside, inside != code};
}

const Quantiser quantisers[] = {quantiser_of_source(SourceType::f32, 0),
                                quantiser_of_source(SourceType::f32, 7.3f),
                                quantiser_of_source(SourceType::u8, 0),
                                quantiser_of_source(SourceType::u8, 12),
                                quantiser_of_source(SourceType::u8, 12.3f),
                                quantiser_of_source(SourceType::i16, -5),
                                quantiser_of_source(SourceType::f16, 0),
                                quantiser_of_source(SourceType::f16, 2.7f),
                                quantiser_of_range(ValueType::f16, {0, 1}, 2.7f),
                                quantiser_of_range(ValueType::u8, {-3, 11}, 0.7f),
                                quantiser_of_range(ValueType::u16, {-300, 260}, 0)};

TEST(RelevanceSelect, EqualsTheReferenceOnEveryTarget) {
  test::for_targets([&] {
    for (const Quantiser& q : quantisers)
      for (const float threshold : {0.0f, 0.75f, 30.0f}) {
        const auto in = values(-320, 300, 1);
        Brick brick;
        const KeptCounts counts = Relevance(q, threshold).select(in.data(), whole, {}, brick);
        uint64_t kept = 0, clamped = 0;
        for (size_t i = 0; i < brick_sites; ++i) {
          const Stored s = reference(q, in[i]);
          const bool keep = threshold == 0 ? s.code != reference(q, 0).code : std::fabs(s.value) > threshold;
          ASSERT_EQ(brick.kept[i / 16] >> (i % 16) & 1, keep)
              << in[i] << " type " << int(q.type) << " offset " << q.offset;
          ASSERT_EQ(static_cast<double>(brick.value[i]), keep ? s.value : 0)
              << in[i] << " type " << int(q.type);
          kept += keep;
          clamped += s.clamped;
        }
        EXPECT_EQ(counts.kept, kept);
        EXPECT_EQ(counts.clamped, clamped);
        EXPECT_EQ(counts.holes, 0u);
      }
  });
}

TEST(RelevanceSelect, RoundingTwiceIsRoundingOnce) {
  for (const Quantiser& q : quantisers) {
    const auto in = values(-320, 300, 2);
    Brick once, twice;
    const Relevance r(q, 0);
    (void)r.select(in.data(), whole, {}, once);
    const KeptCounts again = r.select(once.value.data(), whole, {}, twice);
    EXPECT_EQ(once.value, twice.value);
    EXPECT_EQ(again.clamped, 0u);
  }
}

TEST(RelevanceSelect, RoundsEveryHalfToItself) {
  const Relevance r(quantiser_of_source(SourceType::f16, 0), 0);
  for (uint32_t first = 0; first < 65536; first += brick_sites) {
    std::vector<float> in(brick_sites);
    for (uint32_t i = 0; i < brick_sites; ++i) {
      const float v = half_to_float(static_cast<uint16_t>(first + i));
      in[i] = std::isfinite(v) ? v : 0;
    }
    Brick brick;
    const KeptCounts counts = r.select(in.data(), whole, {}, brick);
    EXPECT_EQ(counts.clamped, 0u);
    for (size_t i = 0; i < brick_sites; ++i) ASSERT_EQ(brick.value[i], in[i]);
  }
}

TEST(RelevanceSelect, AbsentSitesAreWithinTheThreshold) {
  for (const Quantiser& q : quantisers)
    for (const float threshold : {0.0f, 0.1f, 2.0f}) {
      const auto in = values(-3, 3, 3);
      Brick brick;
      (void)Relevance(q, threshold).select(in.data(), whole, {}, brick);
      // Half a step of the stored type comes on top of the threshold; air itself may lie between two steps.
      const double step = q.type == ValueType::f32 ? 0 : q.type == ValueType::f16 ? 0.01 : q.scale;
      uint64_t absent = 0;
      for (size_t i = 0; i < brick_sites; ++i) {
        if (reference(q, in[i]).clamped) continue;
        if (brick.kept[i / 16] >> (i % 16) & 1) {
          EXPECT_GE(std::fabs(in[i]), threshold - step - 1e-6);
        } else {
          EXPECT_LE(std::fabs(in[i]), threshold + step + 1e-6);
          ++absent;
        }
      }
      EXPECT_TRUE(absent > 0 || threshold <= step);
    }
}

TEST(RelevanceSelect, NothingBeyondTheEdgeAndHolesAlways) {
  const auto in = values(1, 2, 4);
  BrickMask holes{};
  for (uint16_t& row : holes) row = 0xfff0;
  std::vector<float> filled = in;
  for (size_t i = 0; i < brick_sites; ++i)
    if (i % 16 >= 4) filled[i] = 0; // a fill that equals air
  Brick brick;
  const Int3 size{9, 5, 7};
  const KeptCounts counts = Relevance(quantiser_of_source(SourceType::f32, 0), 0)
                                .select(filled.data(), size, {&holes, nullptr, 0}, brick);
  EXPECT_EQ(counts.kept, 9u * 5 * 7);
  EXPECT_EQ(counts.holes, 5u * 5 * 7);
  ASSERT_TRUE(brick.hole);
  for (int z = 0; z < 16; ++z)
    for (int y = 0; y < 16; ++y) {
      const size_t row = z * 16 + y;
      const bool inside = z < 7 && y < 5;
      EXPECT_EQ(brick.kept[row], inside ? 0x1ff : 0);
      EXPECT_EQ((*brick.hole)[row], inside ? 0x1f0 : 0);
      for (size_t x = 0; x < 16; ++x)
        EXPECT_EQ(brick.value[row * 16 + x], inside && x < 4 ? in[row * 16 + x] : 0.0f);
    }
  Brick none;
  (void)Relevance(quantiser_of_source(SourceType::f32, 0), 0).select(in.data(), size, {}, none);
  EXPECT_FALSE(none.hole);
}

TEST(RelevanceSelect, RingingCountsOnlyWhereItIsLoud) {
  const auto in = values(-1, 1, 5);
  BrickMask source;
  std::mt19937 random(6);
  for (uint16_t& row : source) row = static_cast<uint16_t>(random());
  Brick brick;
  const KeptCounts counts = Relevance(quantiser_of_source(SourceType::f32, 0), 0.1f)
                                .select(in.data(), whole, {nullptr, &source, 0.4f}, brick);
  uint64_t kept = 0;
  for (size_t i = 0; i < brick_sites; ++i) {
    const bool substance = source[i / 16] >> (i % 16) & 1;
    const bool keep = std::fabs(in[i]) > (substance ? 0.1f : 0.4f);
    ASSERT_EQ(brick.kept[i / 16] >> (i % 16) & 1, keep);
    ASSERT_EQ(brick.value[i], keep ? in[i] : 0.0f);
    kept += keep;
  }
  EXPECT_EQ(counts.kept, kept);
}

TEST(RelevanceSelect, WhatIsNotFiniteIsClamped) {
  std::vector<float> in(brick_sites, 0.0f);
  in[0] = INFINITY;
  in[1] = -INFINITY;
  in[2] = NAN;
  for (const Quantiser& q : quantisers) {
    Brick brick;
    const KeptCounts counts = Relevance(q, 0).select(in.data(), whole, {}, brick);
    EXPECT_GE(counts.clamped, 2u);
    for (size_t i = 0; i < 3; ++i) EXPECT_TRUE(std::isfinite(brick.value[i]));
    EXPECT_GT(brick.value[0], brick.value[1]);
  }
}

TEST(RelevanceSelect, RefusesSenselessChoices) {
  EXPECT_THROW(Relevance(quantiser_of_source(SourceType::f32, 0), -1), Error);
  EXPECT_THROW(Relevance(quantiser_of_source(SourceType::f32, 0), NAN), Error);
  EXPECT_THROW((void)quantiser_of_range(ValueType::u8, {1, 1}, 0), Error);
  EXPECT_THROW((void)quantiser_of_range(ValueType::u8, {0, INFINITY}, 0), Error);
  EXPECT_THROW((void)quantiser_of_range(ValueType::u8, {0, 1e-9}, 1), Error);
  EXPECT_THROW((void)quantiser_of_source(SourceType::unknown, 0), Error);
}

} // namespace
} // namespace bccsplat

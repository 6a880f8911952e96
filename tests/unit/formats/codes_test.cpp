// SPDX-License-Identifier: Apache-2.0
// Codes of samples, of every type: they survive the way there and back, rise with the values, are the nearest
// ones, and are clamped and counted beyond the range.
#include "formats/bcc4/coding/codes.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <random>

#include "base/half.h"
#include "tests/unit/formats/test_data.h"

namespace bccsplat {
namespace {

using test::channel;

std::vector<ChannelInfo> coded_channels() {
  ChannelInfo bytes = channel("u8", ValueType::u8), words = channel("u16", ValueType::u16);
  ChannelInfo shifted = words, fine = words, half_values = channel("f16", ValueType::f16, 3);
  shifted.scale = 0.1, shifted.offset = -3276.8, shifted.air = 0; // an i16 in tenths
  fine.scale = 1e-3, fine.offset = 0.1, fine.air = 1000.25f;
  half_values.offset = 0;
  ChannelInfo big_air = words;
  big_air.scale = 1, big_air.offset = 0, big_air.air = 0x1p22f;
  return {bytes,       words,
          shifted,     fine,
          big_air,     channel("f16 at air", ValueType::f16, -7),
          half_values, channel("f32", ValueType::f32, 1.5f)};
}

TEST(SampleCoder, EveryCodeSurvives) {
  for (const ChannelInfo& c : coded_channels()) {
    const SampleCoder coder(c);
    const uint32_t step = c.type == ValueType::f32 ? 65537 : 1;
    uint64_t clamped = 0;
    for (uint64_t code = coder.lowest(); code <= coder.highest(); code += step) {
      const auto q = static_cast<uint32_t>(code);
      const float v = coder.decode(q);
      ASSERT_TRUE(std::isfinite(v));
      // Values near air of a half with another offset are coarser as floats relative to air, but stay where
      // they are.
      const uint32_t again = coder.encode(v, clamped);
      if (c.type == ValueType::f16 && c.offset != c.air) {
        ASSERT_EQ(std::bit_cast<uint32_t>(coder.decode(again)), std::bit_cast<uint32_t>(v))
            << c.name << " " << q;
      } else {
        ASSERT_EQ(again, q) << c.name;
      }
    }
    EXPECT_EQ(clamped, 0u) << c.name;
  }
}

TEST(SampleCoder, CodesRiseWithValues) {
  for (const ChannelInfo& c : coded_channels()) {
    const SampleCoder coder(c);
    const uint32_t step = c.type == ValueType::f32 ? 1000003 : 7;
    float last = coder.decode(coder.lowest());
    for (uint64_t code = uint64_t{coder.lowest()} + step; code <= coder.highest(); code += step) {
      const float v = coder.decode(static_cast<uint32_t>(code));
      ASSERT_GE(v, last) << c.name << " " << code;
      last = v;
    }
  }
}

TEST(SampleCoder, NearestCode) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> value(-300, 300);
  for (const ChannelInfo& c : coded_channels()) {
    if (c.air > 1e6f) continue;
    const SampleCoder coder(c);
    uint64_t clamped = 0;
    for (int i = 0; i < 2000; ++i) {
      const float v = value(random);
      const uint64_t before = clamped;
      const uint32_t q = coder.encode(v, clamped);
      const double error = std::fabs(static_cast<double>(coder.decode(q)) - v);
      for (const int64_t other : {int64_t{q} - 1, int64_t{q} + 1}) {
        if (other < coder.lowest() || other > coder.highest()) continue;
        EXPECT_LE(error,
                  std::fabs(static_cast<double>(coder.decode(static_cast<uint32_t>(other))) - v) + 1e-4)
            << c.name << " " << v;
      }
      EXPECT_EQ(clamped > before,
                c.scale < 0.6 && (q == coder.lowest() || q == coder.highest()) && error > c.scale / 2 + 1e-9)
          << c.name << " " << v;
    }
  }
}

TEST(SampleCoder, ClampsAndCounts) {
  uint64_t clamped = 0;
  const SampleCoder bytes(channel("u8", ValueType::u8)), halves(channel("f16", ValueType::f16));
  EXPECT_EQ(bytes.encode(-1, clamped), 0u);
  EXPECT_EQ(bytes.encode(1e30f, clamped), 255u);
  EXPECT_EQ(halves.decode(halves.encode(1e6f, clamped)), 65504);
  EXPECT_EQ(halves.decode(halves.encode(-1e6f, clamped)), -65504);
  EXPECT_EQ(clamped, 4u);
  EXPECT_EQ(bytes.encode(127.6f, clamped),
            255u); // less than half a step above the top: rounding, no clamping
  EXPECT_EQ(clamped, 4u);
}

// Relative to another value than air, which is taken off in double precision.
TEST(SampleCoder, RelativeToAnotherValue) {
  for (const ValueType type : {ValueType::u8, ValueType::u16, ValueType::f16, ValueType::f32}) {
    Quantiser q;
    q.type = type, q.air = 3;
    q.offset = 3, q.scale = is_float(type) ? 1 : 0.25;
    constexpr float zero = 1000.1f;
    const SampleCoder from_air(q), from_zero(q, zero);
    for (const float relative : {0.0f, 0.25f, 17.5f, 63.75f}) {
      uint64_t clamped = 0;
      const uint32_t code = from_air.encode(relative, clamped);
      EXPECT_EQ(from_zero.decode(code), static_cast<float>(static_cast<double>(relative) + 3 - zero));
      EXPECT_NEAR(from_zero.value(code), from_air.value(code), 1e-4);
      EXPECT_EQ(clamped, 0u);
    }
  }
}

TEST(SampleCoder, FloatsAreBitExact) {
  const SampleCoder coder(channel("f32", ValueType::f32, 1e6f));
  uint64_t clamped = 0;
  for (const float v : {0.0f, -0.0f, 1e-45f, -1e-30f, 3.4e38f, 1.2345678f})
    EXPECT_EQ(std::bit_cast<uint32_t>(coder.decode(coder.encode(v, clamped))), std::bit_cast<uint32_t>(v));
}

} // namespace
} // namespace bccsplat

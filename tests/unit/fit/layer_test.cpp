// SPDX-License-Identifier: Apache-2.0
// The form in which layers of floats leave the fit.
#include "fit/kept/layer.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/fit/fit_series.h"

namespace bccsplat::test {
namespace {

constexpr float unit = 1.0f / 64;

std::vector<SampleLayer> layers_of(const Series& s, float unit_of_values) {
  FitOptions o = options_for(s);
  o.channels[0].quantiser.type = ValueType::f32;
  o.channels[0].unit = unit_of_values;
  Bench bench;
  std::vector<SampleLayer> made;
  Fit fit(
      o,
      [&](int32_t, int, const SlabLayers& layers) {
        made.insert(made.end(), layers.compact().begin(), layers.compact().end());
      },
      bench.context);
  for (uint32_t t = 0; t < s.dims[3]; ++t) fit.add_frame(0, std::vector{s.box(t)});
  (void)fit.finish();
  return made;
}

// A dense series of bytes.
Series bytes() {
  Series s = noise({37, 20, 22, 9}, 6);
  for (float& v : s.values) v = std::round(128 + 100 * v);
  return s;
}

// Differences are those of frames in whole numbers, then of samples, each by half a step.
void expect_in_bits(const Series& s, int bits, float step) {
  const std::vector<SampleLayer> packed = layers_of(s, unit), floats = layers_of(s, 0);
  ASSERT_EQ(packed.size(), floats.size());
  std::array<float, brick_sites> room;
  for (size_t m = 0; m < packed.size(); ++m) {
    EXPECT_LT(packed[m].bytes(), (bits / 32.0 + 0.06) * static_cast<double>(floats[m].bytes()));
    for (size_t slot = 0; slot < packed[m].brick_slots(); ++slot) {
      const SampleBrick &was = floats[m].brick(slot), &now = packed[m].brick(slot);
      ASSERT_EQ(static_cast<bool>(was), static_cast<bool>(now));
      if (!was) continue;
      ASSERT_TRUE(was.values);
      ASSERT_TRUE(now.codes);
      const float* const values = now.all(room);
      for (size_t i = 0; i < brick_sites; ++i) ASSERT_NEAR(values[i], was.values->value[i], 1.5f * step);
    }
  }
}

TEST(LayersOfFloats, TakeTwelveBitsASiteWhereTheirSourceComesInSteps) {
  Series s = bytes();
  for (float& v : s.values) v = std::round(0.4f * v);
  expect_in_bits(s, 12, 4 * unit);
}

TEST(LayersOfFloats, TakeSixteenBitsWhereTwelveHoldNoSuchSteps) { expect_in_bits(bytes(), 16, 4 * unit); }

TEST(LayersOfFloats, StayFloatsWhereSixteenBitsHoldNoSuchSteps) {
  Series s = bytes();
  for (float& v : s.values) v *= 40;
  for (const SampleLayer& layer : layers_of(s, unit))
    for (size_t slot = 0; slot < layer.brick_slots(); ++slot)
      if (const SampleBrick& brick = layer.brick(slot)) {
        ASSERT_TRUE(brick.values);
      }
}

} // namespace
} // namespace bccsplat::test

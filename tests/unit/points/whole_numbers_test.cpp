// SPDX-License-Identifier: Apache-2.0
#include "points/whole_numbers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "tests/support/targets.h"

namespace bccsplat {
namespace {

constexpr Int3 all{brick_edge, brick_edge, brick_edge};
constexpr float unit = 1.0f / 64;

Brick noise(float low, float high) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> value(low, high);
  Brick brick;
  for (float& v : brick.value) v = value(random);
  return brick;
}

NumberForm form_of(const Brick& brick) { return number_form(brick.value.data(), all, unit, 4 * unit); }

TEST(WholeNumbers, TakeTheFewestBitsAndOfThoseTheFinestStep) {
  const auto ends = [](float low, float high) {
    Brick brick;
    brick.value.fill(low);
    brick.value.back() = high;
    return form_of(brick);
  };
  EXPECT_EQ(ends(7, 7 + 4095 * unit).bits, 12);
  EXPECT_EQ(ends(7, 7 + 4095 * unit).step, unit);
  EXPECT_EQ(ends(7, 7 + 4096 * unit).step, 2 * unit);
  EXPECT_EQ(ends(-100, 4095 * 4 * unit - 100).bits, 12);
  EXPECT_EQ(ends(-100, 4096 * 4 * unit - 100).bits, 16);
  EXPECT_EQ(ends(-100, 4096 * 4 * unit - 100).step, unit);
  EXPECT_EQ(ends(0, 65535 * 4 * unit).bits, 16);
  EXPECT_EQ(ends(0, 65536 * 4 * unit).bits, 0);
  EXPECT_EQ(ends(1e9f, 1e9f).bits, 0); // no whole number of units among floats
  EXPECT_EQ(ends(-1e38f, 1e38f).bits, 0);
}

TEST(WholeNumbers, WhatIsNoSiteDoesNotHaveToFit) {
  Brick brick;
  brick.value.fill(1e30f);
  for (int z = 0; z < 5; ++z)
    for (int y = 0; y < 7; ++y)
      for (int x = 0; x < 9; ++x) brick.value[(z * 16 + y) * 16 + x] = static_cast<float>(x);
  for (const float garbage : {1e30f, -1e30f, std::nanf("")}) {
    for (float& v : brick.value)
      if (!(std::fabs(v) < 100)) v = garbage;
    test::for_targets([&] {
      const NumberForm form = number_form(brick.value.data(), {9, 7, 5}, unit, unit);
      ASSERT_EQ(form.bits, 12);
      std::vector<uint8_t> numbers(number_bytes(form.bits));
      write_numbers(form, brick.value.data(), numbers.data());
      std::array<float, 16 * 7> plane{};
      read_numbers(form, numbers.data(), {.plane = 4, .width = 9, .height = 7}, plane.data(), 16);
      for (size_t i = 0; i < plane.size(); ++i)
        if (i % 16 < 9) {
          ASSERT_EQ(plane[i], static_cast<float>(i % 16));
        }
    });
  }
}

// Every row and every offset, of both forms.
TEST(WholeNumbers, EveryTargetRoundsAlikeAndReadsAnyPart) {
  for (const float range : {30.f, 200.f, 900.f}) {
    const Brick brick = noise(-range / 3, range - range / 3);
    test::for_targets([&] {
      const NumberForm form = form_of(brick);
      ASSERT_EQ(form.bits, range < 256 ? 12 : 16);
      std::vector<uint8_t> numbers(number_bytes(form.bits));
      write_numbers(form, brick.value.data(), numbers.data());
      for (int offset = 0; offset < 16; ++offset)
        for (const PlanePart part : {PlanePart{3, offset, 15 - offset, 16 - offset, 1 + offset},
                                     PlanePart{15, offset, offset, 1, 16 - offset}}) {
          std::array<float, brick_rows + 16> plane{};
          read_numbers(form, numbers.data(), part, plane.data(), 16);
          for (int y = 0; y < part.height; ++y)
            for (int x = 0; x < part.width; ++x) {
              const float v = brick.value[(part.plane * 16 + part.y + y) * 16 + part.x + x];
              ASSERT_EQ(plane[y * 16 + x], std::nearbyint(v / form.step) * form.step);
            }
        }
    });
  }
}

} // namespace
} // namespace bccsplat

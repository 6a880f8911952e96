// SPDX-License-Identifier: Apache-2.0
// What follows from the kind of data: colours, window and opacity.
#include "shade/kind_look.h"

#include <gtest/gtest.h>

#include <cmath>

#include "shade/look.h"

namespace bccsplat {
namespace {

using series::DataKind;

// Noise near 0, tissue whose values fall off from it, and the bright rim of a coil.
ValueCounts body_counts(DataKind kind) {
  ValueCounts c;
  c.bins.assign(256, 0);
  c.stored = c.source = {0, 2560};
  c.voxels = 1e6;
  c.data = kind;
  for (int i = 0; i < 256; ++i)
    c.bins[i] = static_cast<uint64_t>(5e5 * std::exp(-i * i / 8.0) +
                                      (i < 80 ? 2e4 * std::exp(-i / 30.0) : 0) + (i > 200 ? 200 : 0));
  return c;
}

TransferFunction function_of(DataKind kind) {
  return look_function(survey_values(body_counts(kind)), Look::automatic, RenderMode::composite);
}

bool is_grey(const TransferFunction& f) {
  for (const ColorPoint& c : f.colors)
    if (c.color[0] != c.color[1] || c.color[1] != c.color[2]) return false;
  return true;
}

TEST(KindLook, TheWindowOfAScanEndsBeforeItsRim) {
  EXPECT_GT(survey_values(body_counts(DataKind::unknown)).colors.high, 2000);
  for (const DataKind scan : {DataKind::mr, DataKind::ct}) {
    const ValueSurvey s = survey_values(body_counts(scan));
    EXPECT_LT(s.colors.high, 800);
    EXPECT_GT(s.colors.high, 600);
  }
}

TEST(KindLook, ScansAndSmokeAreGreyAndRiseToWhite) {
  for (const DataKind kind : {DataKind::ct, DataKind::mr, DataKind::smoke}) {
    const TransferFunction f = function_of(kind);
    EXPECT_TRUE(is_grey(f));
    for (size_t i = 1; i < f.colors.size(); ++i) EXPECT_GT(f.colors[i].color[0], f.colors[i - 1].color[0]);
    EXPECT_GT(f.colors.back().color[0], 0.85);
  }
}

TEST(KindLook, WhatIsOfNoKnownKindHasTheColoursOfFields) {
  const TransferFunction f = function_of(DataKind::unknown), field = function_of(DataKind::field);
  EXPECT_FALSE(is_grey(f));
  ASSERT_EQ(f.colors.size(), field.colors.size());
  for (size_t i = 0; i < f.colors.size(); ++i) EXPECT_EQ(f.colors[i].color, field.colors[i].color);
  ASSERT_EQ(f.opacities.size(), field.opacities.size());
  for (size_t i = 0; i < f.opacities.size(); ++i)
    EXPECT_EQ(f.opacities[i].opacity, field.opacities[i].opacity);
}

TEST(KindLook, ABodyIsSeenWholeAndFogThrough) {
  const auto left = [](DataKind kind) { // of the light behind what is shown
    const ValueSurvey s = survey_values(body_counts(kind));
    EXPECT_EQ(s.kind, ValueKind::fog);
    return std::pow(1 - function_of(kind).opacity(s.background + s.mean), s.crossing);
  };
  EXPECT_LT(left(DataKind::mr), 0.002);
  EXPECT_GT(left(DataKind::mr), 1e-5);
  EXPECT_GT(left(DataKind::smoke), 0.01);
}

TEST(KindLook, StatisticsOfBothSignsDiverge) {
  ValueCounts c;
  c.bins.assign(256, 0);
  c.stored = c.source = {-9, 9};
  c.voxels = 1e6;
  for (int i = 0; i < 256; ++i) {
    const double v = (i - 127.5) * 18 / 256;
    c.bins[i] = static_cast<uint64_t>(1e5 * std::exp(-v * v) + 500 * std::exp(-v * v / 30));
  }
  const auto middle = [&](DataKind kind) {
    c.data = kind;
    const ValueSurvey s = survey_values(c);
    EXPECT_EQ(s.kind, ValueKind::both_signs);
    const TransferFunction f = look_function(s, Look::automatic, RenderMode::composite);
    EXPECT_GT(f.color(8)[0], 2 * f.color(8)[2]);
    EXPECT_GT(f.color(-8)[2], 2 * f.color(-8)[0]);
    return f.opacity(s.mean);
  };
  EXPECT_GT(middle(DataKind::statistic), 1.5 * middle(DataKind::unknown));
}

TEST(KindLook, ALookThatIsAskedForIsDrawn) {
  const TransferFunction fire =
      look_function(survey_for(body_counts(DataKind::mr), Look::fire), Look::fire, RenderMode::composite);
  EXPECT_FALSE(is_grey(fire));
}

} // namespace
} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Histograms of the shapes that volumes have, and what is made of them.
#include "shade/value_survey.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace bccsplat {
namespace {

// A histogram as a file has it, made of normal distributions, exponential tails and single values.
struct Counts : ValueCounts {
  Counts(double low, double high) {
    stored = source = {low, high};
    bins.assign(256, 0);
    voxels = 1e6;
  }
  [[nodiscard]] double value(size_t bin) const {
    return stored.low + (static_cast<double>(bin) + 0.5) * (stored.high - stored.low) / 256;
  }
  void add(double count, const auto& density) {
    double sum = 0;
    for (size_t i = 0; i < bins.size(); ++i) sum += density(value(i));
    for (size_t i = 0; i < bins.size(); ++i)
      bins[i] += static_cast<uint64_t>(count * density(value(i)) / sum + 0.5);
  }
  Counts& normal(double count, double mean, double sigma) {
    add(count, [&](double v) { return std::exp(-0.5 * std::pow((v - mean) / sigma, 2)); });
    return *this;
  }
  Counts& tail(double count, double from, double length) {
    add(count, [&](double v) { return v < from ? 0.0 : std::exp((from - v) / length); });
    return *this;
  }
  Counts& even(double count) {
    add(count, [](double) { return 1.0; });
    return *this;
  }
};

TEST(ValueSurvey, AnObjectInNoiseIsASolidWhoseNoiseIsEmpty) {
  const ValueSurvey s =
      survey_values(Counts(0, 255).normal(7e5, 76, 6).normal(2e5, 150, 8).normal(1e5, 220, 9));
  EXPECT_EQ(s.kind, ValueKind::solid);
  EXPECT_TRUE(s.above && !s.below);
  EXPECT_GE(s.empty.high, 76 + 3 * 6);
  EXPECT_LE(s.empty.high, 125);
  EXPECT_NEAR(s.object, 150, 4);
  EXPECT_NEAR(s.noise, 8, 1.5);
  EXPECT_NEAR(s.boundary, 113, 4);
  EXPECT_NEAR(s.crossing, std::cbrt(3e5), 5);
}

TEST(ValueSurvey, ValuesThatVaryAreNoNoise) {
  // A smooth field that rises from air: values between are nearly as common as those of the plateau, which
  // end soon.
  Counts c(0, 134);
  c.tail(1e5, 0, 8).even(4e5).normal(5e4, 92, 7);
  c.air_sites = 2'000'000;
  for (size_t i = 0; i < c.bins.size(); ++i)
    if (c.value(i) > 100) c.bins[i] /= 8;
  const ValueSurvey s = survey_values(c);
  ASSERT_EQ(s.kind, ValueKind::solid);
  EXPECT_EQ(s.noise, 0);
}

TEST(ValueSurvey, BinsOfOtherBoundsMakeNoPeak) {
  // Values that are a little more common near 95, not enough for an object. Where the file's bins are wider
  // than those of the source's range, one of these falls between two of them now and then.
  for (const double beyond : {0.2, 0.9, 1.4, 2.7, 5.0}) {
    Counts c(0, 134 + beyond);
    c.source = {0, 134};
    c.tail(1e5, 0, 8).normal(3e4, 95, 6);
    c.add(6e5, [](double v) { return v < 102 ? 1 : 0.5 * std::exp((102 - v) / 12); });
    for (size_t i = 0; i < c.bins.size(); ++i)
      if (c.value(i) > 133) c.bins[i] = 0;
    c.air_sites = 2'000'000;
    EXPECT_EQ(survey_values(c).kind, ValueKind::fog) << beyond;
  }
}

TEST(ValueSurvey, HounsfieldUnitsHaveTheirAirAtTheLowEnd) {
  Counts c(-1024, 2986);
  c.normal(6e5, -1000, 20).normal(3e5, 40, 30).tail(5e4, 200, 300);
  const ValueSurvey s = survey_values(c); // air, where nothing is stored, is 0: it says nothing here
  EXPECT_EQ(s.kind, ValueKind::solid);
  EXPECT_NEAR(s.background, -1000, 20);
  EXPECT_LE(s.empty.high, -500);
  EXPECT_NEAR(s.boundary, -480, 30);
}

TEST(ValueSurvey, RingingBeyondTheSourceIsNoValueOfItsOwn) {
  Counts c(-1500, 1500);
  c.source = {-1000, 900};
  c.normal(6e5, -1000, 80).normal(3e5, 900, 60);
  const ValueSurvey s = survey_values(c);
  EXPECT_GE(s.colors.low, -1000);
  EXPECT_LE(s.colors.high, 900);
}

TEST(ValueSurvey, FogRisesFromAirWithoutAGap) {
  Counts c(0, 5);
  c.tail(2e5, 0, 0.5);
  c.air_sites = 800000;
  const ValueSurvey s = survey_values(c);
  EXPECT_EQ(s.kind, ValueKind::fog);
  EXPECT_EQ(s.background, 0);
  EXPECT_GT(s.empty.high, 0);
  EXPECT_LT(s.empty.high, 0.5);
  // A surface is nearer to the noise than to the value that divides the fog best, deep inside.
  std::vector<double> bins(c.bins.begin(), c.bins.end());
  bins[0] += static_cast<double>(c.air_sites);
  const double best = otsu_threshold(bins, c.stored, 0);
  EXPECT_GT(s.boundary, s.empty.high);
  EXPECT_LT(s.boundary - s.empty.high, 0.5 * (best - s.empty.high));
}

TEST(ValueSurvey, NoiseBesideExactAirIsEmptyToo) {
  Counts c(0, 255);
  c.tail(3e5, 0, 4).normal(2e5, 135, 8);
  c.air_sites = 500000;
  const ValueSurvey s = survey_values(c);
  EXPECT_EQ(s.kind, ValueKind::solid);
  EXPECT_GE(s.empty.high, 8); // where the tail has fallen to an eighth
}

TEST(ValueSurvey, AMaskIsWhatIsNotAirHoweverMuchThatIs) {
  for (const double value : {1.0, -1.0}) {
    Counts c(std::min(value, 0.0), std::max(value, 0.0));
    c.stored = {value, value};
    c.bins[0] = 780'000, c.air_sites = 220'000;
    const ValueSurvey s = survey_values(c);
    EXPECT_EQ(s.kind, ValueKind::solid);
    EXPECT_EQ(s.background, 0);
    EXPECT_TRUE(value > 0 ? s.above && !s.below : s.below && !s.above);
    EXPECT_NEAR(s.boundary, value / 2, 0.05);
  }
}

TEST(ValueSurvey, SignedValuesAreShownOnBothSides) {
  const ValueSurvey s = survey_values(Counts(-9, 18).normal(9e5, 0, 1).normal(5e4, 0, 5));
  EXPECT_EQ(s.kind, ValueKind::both_signs);
  EXPECT_TRUE(s.above && s.below);
  EXPECT_EQ(s.empty.low, -s.empty.high);
  EXPECT_EQ(s.colors.low, -s.colors.high);
}

TEST(ValueSurvey, LabelsAreListed) {
  Counts c(1, 5);
  c.integers = true;
  c.bins.assign(256, 0);
  for (const size_t label : {1, 2, 5}) c.bins[std::min<size_t>(255, (label - 1) * 64)] = 1000;
  c.air_sites = 9000;
  const ValueSurvey s = survey_values(c);
  EXPECT_EQ(s.kind, ValueKind::labels);
  EXPECT_EQ(s.labels, (std::vector<double>{1, 2, 5}));
  EXPECT_EQ(s.background, 0);
  EXPECT_EQ(s.boundary, 0.5);
  c.air = 9;
  EXPECT_EQ(survey_values(c).background, 0);
  c.integers = false;
  EXPECT_NE(survey_values(c).kind, ValueKind::labels);
}

TEST(ValueSurvey, LabelsThatTheFileNamesAreListedWhateverTheyAre) {
  Counts c(0.5, 512.5);
  c.labels = true, c.integers = false;
  c.bins.assign(256, 0);
  c.bins[0] = c.bins[9] = c.bins[255] = 1000; // two numbers wide
  EXPECT_EQ(survey_values(c).kind, ValueKind::labels);
  EXPECT_EQ(survey_values(c).labels, (std::vector<double>{1, 2, 19, 20, 511, 512}));
  c.labels = false, c.integers = true;
  c.stored = c.source = {1, 5};
  EXPECT_NE(survey_values(c).kind, ValueKind::labels);
  EXPECT_EQ(survey_values(c, ValueKind::labels).kind, ValueKind::labels) << "asked for";
}

TEST(ValueSurvey, DistancesCutOffOnBothSidesAreALevelSet) {
  const ValueSurvey s = survey_values(Counts(-3, 3).normal(8e5, 3, 0.02).normal(1e5, -3, 0.02).even(1e5));
  EXPECT_EQ(s.kind, ValueKind::level_set);
  EXPECT_TRUE(s.below && !s.above);
  EXPECT_EQ(s.boundary, 0);
}

TEST(ValueSurvey, WithoutABackgroundAllIsData) {
  Counts c(4, 28);
  c.even(1e6);
  c.incomplete = true;
  const ValueSurvey water = survey_values(c);
  EXPECT_EQ(water.kind, ValueKind::dense);
  EXPECT_GT(water.empty.low, water.empty.high); // none is transparent, the mean least of all
  c.incomplete = false;
  const ValueSurvey box = survey_values(c);
  EXPECT_EQ(box.kind, ValueKind::dense);
  EXPECT_NEAR(box.empty.high, 16, 0.5);
}

TEST(ValueSurvey, NothingAndOneValueAreTold) {
  EXPECT_EQ(survey_values(Counts(0, 0)).kind, ValueKind::empty);
  Counts c(7, 7);
  c.bins[0] = 1000;
  const ValueSurvey s = survey_values(c);
  EXPECT_EQ(s.kind, ValueKind::constant);
  EXPECT_EQ(s.boundary, 3.5);
  EXPECT_EQ(s.object, 7);
}

TEST(ValueSurvey, WhatDamagedFilesSayIsSurvived) {
  constexpr double most = std::numeric_limits<double>::max(),
                   least = std::numeric_limits<double>::denorm_min();
  for (const Range& range : {Range{-most, most}, {0, least}, {most, most}, {5, -5}, {0, most}, {-1, 1}})
    for (const Range& source : {range, Range{-1, 2}}) {
      Counts c(range.low, range.high);
      c.source = source;
      c.bins.assign(256, UINT64_MAX / 300);
      c.air = -3e38, c.air_sites = UINT64_MAX;
      const ValueSurvey s = survey_values(c);
      EXPECT_LE(s.colors.low, s.colors.high);
      EXPECT_TRUE(std::isfinite(s.boundary));
    }
}

TEST(ValueSurvey, BrightBackgroundsAreEmptyAbove) {
  const ValueSurvey s = survey_values(Counts(0, 255).normal(8e5, 230, 4).normal(2e5, 90, 10));
  EXPECT_TRUE(s.below && !s.above);
  EXPECT_LT(s.empty.low, 230 - 10);
  EXPECT_NEAR(s.boundary, 160, 4);
}

TEST(ValueSurvey, ABoundaryIsBehindAHumpOfHaze) {
  // Air whose slope reaches far, haze about half way to the object, and the object.
  const auto with_haze = [](double haze, double at, bool upside_down) {
    Counts c(0, 255);
    c.tail(1.5e6, 0, 12).normal(haze, at, 7).normal(2e5, 100, 5);
    c.air_sites = 5'000'000;
    if (upside_down) std::reverse(c.bins.begin(), c.bins.end()), c.air = 255;
    return survey_values(c);
  };
  for (const bool upside_down : {false, true}) {
    const auto value = [&](const ValueSurvey& s) { return upside_down ? 255 - s.boundary : s.boundary; };
    const ValueSurvey clear = with_haze(0, 52, upside_down), hazy = with_haze(1e5, 52, upside_down);
    ASSERT_EQ(clear.kind, ValueKind::solid);
    ASSERT_EQ(hazy.kind, ValueKind::solid);
    EXPECT_NEAR(value(clear), 50, 3);
    EXPECT_GT(value(hazy), 52 + 10);
    EXPECT_LT(value(hazy), 100 - 10);
    // What is rare beside the object is no haze, nor is what is over half way.
    EXPECT_NEAR(value(with_haze(2e3, 52, upside_down)), 50, 3);
    EXPECT_NEAR(value(with_haze(2e5, 36, upside_down)), 50, 3);
  }
}

// Where values between noise and object are about as common as the object's own, a surface is inside it; an
// object with an edge has it there, and what is composited keeps its boundary either way.
TEST(ValueSurvey, SurfacesOfObjectsWithoutAnEdgeAreInsideThem) {
  const auto object = [](double mean, double sigma) {
    Counts c(0, 400);
    c.normal(5e5, 20, 5).normal(5e5, mean, sigma);
    return survey_values(c);
  };
  const ValueSurvey edge = object(200, 30), none = object(170, 95);
  ASSERT_EQ(edge.kind, ValueKind::solid);
  ASSERT_EQ(none.kind, ValueKind::solid);
  EXPECT_EQ(edge.surface, edge.boundary);
  EXPECT_NEAR(none.surface, 170, 12);
  EXPECT_LT(none.boundary, 120);
  // So rare values are no object that reaches down to the noise.
  Counts few(0, 400);
  few.normal(1e6, 20, 5).normal(5e4, 170, 95);
  const ValueSurvey rare = survey_values(few);
  EXPECT_EQ(rare.surface, rare.boundary);
}

// The colours of a part are those of its own values; air and noise stay those of the whole.
TEST(ValueSurvey, APartHasColoursOfItsOwn) {
  const Counts whole = Counts(0, 1000).normal(9e5, 20, 5).normal(1e5, 800, 30);
  const ValueSurvey all = survey_values(whole);
  const ValueSurvey part = survey_part(all, Counts(0, 1000).normal(1e4, 20, 5).normal(1e3, 100, 8));
  EXPECT_EQ(part.empty.high, all.empty.high);
  EXPECT_EQ(part.boundary, all.boundary);
  EXPECT_EQ(part.crossing, all.crossing);
  EXPECT_GT(all.colors.high, 850);
  EXPECT_NEAR(part.colors.high, 120, 10);
  EXPECT_NEAR(part.mean, 100 - all.background, 12);
  // Nothing of it seen, and labels: as the whole.
  EXPECT_EQ(survey_part(all, Counts(0, 1000).normal(1e4, 20, 2)).colors.high, all.colors.high);
  ValueSurvey labels = all;
  labels.kind = ValueKind::labels;
  EXPECT_EQ(survey_part(labels, Counts(0, 1000).normal(1e3, 100, 8)).colors.high, all.colors.high);
}

TEST(ValueSurvey, OtsuDividesTwoPeaksBetweenThem) {
  std::vector<double> bins(100, 0.0);
  bins[20] = 5, bins[21] = 5, bins[70] = 3, bins[71] = 2;
  const double t = otsu_threshold(bins, {0, 100}, 0);
  EXPECT_GE(t, 22);
  EXPECT_LE(t, 70);
}

// Where a plateau is one value, ripple is not to run through all colours.
TEST(ValueSurvey, ColoursOfOneValueAreAShareOfItsDistanceFromTheBackground) {
  Counts c(0, 1.01);
  c.normal(1e5, 1, 0.002);
  c.air_sites = 900000;
  const ValueSurvey s = survey_values(c);
  EXPECT_GE(s.colors.high - s.colors.low, 0.049);
  EXPECT_NEAR(s.colors.high, 1, 0.01) << "the room is on the side of the background";
}

} // namespace
} // namespace bccsplat

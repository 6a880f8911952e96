// SPDX-License-Identifier: Apache-2.0
#include "shade/look.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"

namespace bccsplat {
namespace {

ValueCounts solid_counts(double voxels) {
  ValueCounts c;
  c.bins.assign(256, 0);
  c.stored = c.source = {0, 256};
  c.voxels = voxels;
  for (int i = 0; i < 256; ++i)
    c.bins[i] = static_cast<uint64_t>(7e5 * std::exp(-0.5 * std::pow((i - 30) / 5.0, 2)) +
                                      2e5 * std::exp(-0.5 * std::pow((i - 150) / 8.0, 2)));
  return c;
}

constexpr RenderMode modes[] = {RenderMode::composite, RenderMode::isosurface, RenderMode::xray,
                                RenderMode::maximum};
constexpr Look looks[] = {Look::automatic, Look::ct_bone, Look::ct_soft,   Look::mr,
                          Look::fog,       Look::fire,    Look::both_signs};

TEST(Look, EveryFunctionIsOne) {
  ValueCounts empty, constant, wave = solid_counts(1e6), labels;
  constant.bins.assign(256, 0), constant.bins[0] = 5, constant.stored = constant.source = {7, 7};
  wave.stored = wave.source = {-28, 228};
  labels = constant, labels.integers = true, labels.stored = labels.source = {0, 4}, labels.bins[255] = 5;
  for (const ValueCounts& c : {empty, constant, wave, labels, solid_counts(1e6)})
    for (const Look look : looks)
      for (const RenderMode mode : modes) {
        const TransferFunction f = look_function(survey_for(c, look), look, mode);
        EXPECT_NO_THROW(f.check());
        EXPECT_LE(f.colors.size(), 64u);
        EXPECT_LE(f.opacities.size(), 32u);
      }
}

TEST(Look, AirIsTransparentAndTheObjectIsNot) {
  const ValueSurvey s = survey_values(solid_counts(1e6));
  const TransferFunction f = look_function(s, Look::automatic, RenderMode::composite);
  EXPECT_EQ(f.opacity(30), 0);
  EXPECT_EQ(f.opacity(45), 0);
  EXPECT_GT(f.opacity(150), f.opacity(90));
  const double through = std::pow(1 - f.opacity(150), s.crossing);
  EXPECT_LT(through, 1e-3);
}

TEST(Look, AnObjectIsAsOpaqueInALargerVolume) {
  const auto shown = [](double voxels) {
    const ValueSurvey s = survey_values(solid_counts(voxels));
    const TransferFunction f = look_function(s, Look::fog, RenderMode::composite);
    return 1 - std::pow(1 - f.opacity(s.background + s.mean), s.crossing);
  };
  EXPECT_NEAR(shown(64 * 64 * 64), shown(512.0 * 512 * 512), 0.02);
}

TEST(Look, MaximumIsOpaqueWhereThereIsNoAir) {
  const TransferFunction f =
      look_function(survey_values(solid_counts(1e6)), Look::automatic, RenderMode::maximum);
  EXPECT_EQ(f.opacity(40), 0);
  EXPECT_EQ(f.opacity(150), 1);
  EXPECT_EQ(f.opacity(255), 1);
}

TEST(Look, AnIsosurfaceHasOneColour) {
  const TransferFunction f =
      look_function(survey_values(solid_counts(1e6)), Look::automatic, RenderMode::isosurface);
  EXPECT_EQ(f.color(60), f.color(200));
}

TEST(Look, LabelsKeepTheirColoursUpToHalfway) {
  ValueCounts c;
  c.bins.assign(256, 0), c.bins[0] = 5, c.bins[255] = 5;
  c.stored = c.source = {1, 5};
  c.integers = true, c.air_sites = 10;
  const TransferFunction f = look_function(survey_values(c), Look::automatic, RenderMode::composite);
  EXPECT_EQ(f.opacity(0.4), 0);
  EXPECT_LT(length(f.color(1) - f.color(2.9)), 1e-12);
  EXPECT_LT(length(f.color(3.1) - f.color(5)), 1e-12);
  EXPECT_GT(length(f.color(1) - f.color(5)), 0.1);
}

TEST(Look, AMaskIsShownFromHalfwayToAir) {
  ValueCounts c;
  c.bins.assign(256, 0), c.bins[255] = 5;
  c.stored = {199, 200}, c.source = {0, 200};
  c.integers = true, c.air_sites = 10;
  const ValueSurvey s = survey_values(c);
  EXPECT_EQ(s.labels, std::vector<double>{200});
  EXPECT_EQ(s.background, 0);
  EXPECT_EQ(s.boundary, 100);
  const TransferFunction f = look_function(s, Look::automatic, RenderMode::composite);
  EXPECT_EQ(f.opacity(85), 0);
  EXPECT_GT(f.opacity(115), 0.1);
  EXPECT_GT(f.opacity(230), 0.1);
}

TEST(Look, LabelsOfOtherValuesAreRefused) {
  try {
    (void)survey_for(solid_counts(1e6), Look::labels);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), Code::invalid_argument);
  }
}

} // namespace
} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Slopes along the rays by differences of sheets.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "splat/sheet/sheet_args.h"
#include "tests/support/splat_scene.h"

namespace bccsplat {
namespace {

using namespace test;

// The share of a wave's slope that differences find, the wave having so many cycles per lattice unit.
double found(const DepthWeights& w, double cycles, double distance) {
  const double angle = 2 * std::numbers::pi * cycles * distance;
  return (2 * static_cast<double>(w.near) * std::sin(angle) +
          2 * static_cast<double>(w.far) * std::sin(2 * angle)) /
         angle;
}

constexpr DepthWeights fourth_degree{8.0f / 12, -1.0f / 12};

TEST(DepthWeights, ConstantSlopesAndOneWaveAreExact) {
  for (double distance = 0.02; distance < 2; distance += 0.02) {
    const DepthWeights w = depth_weights(distance, 0);
    EXPECT_NEAR(2 * w.near + 4 * w.far, 1, 1e-6) << distance;
    EXPECT_NEAR(found(w, 0.1, distance), 1, 2e-6) << distance;
  }
}

TEST(DepthWeights, LongerWavesAreHardlyTooSteepAndShorterOnesLessTooFlat) {
  for (const double distance : {0.25, 0.5, 1.0}) {
    const DepthWeights w = depth_weights(distance, 0);
    for (double cycles = 0.01; cycles < 0.5; cycles += 0.01) {
      const double share = found(w, cycles, distance), before = found(fourth_degree, cycles, distance);
      EXPECT_GT(share, before) << cycles << ' ' << distance;
      EXPECT_LT(share, 1.0014) << cycles << ' ' << distance;
    }
  }
  EXPECT_GT(found(depth_weights(1, 0), 0.3, 1), found(fourth_degree, 0.3, 1) + 0.01);
}

TEST(DepthWeights, AreContinuousAndEndAtTheFourthDegree) {
  EXPECT_NEAR(depth_weights(1e-4, 0).near, fourth_degree.near, 1e-7);
  EXPECT_NEAR(depth_weights(1e-4, 0).far, fourth_degree.far, 1e-7);
  for (double distance = 0; distance < 8; distance += 1e-3) {
    const DepthWeights a = depth_weights(distance, 0), b = depth_weights(distance + 1e-3, 0);
    EXPECT_NEAR(a.near, b.near, 1e-3) << distance;
    EXPECT_NEAR(a.far, b.far, 1e-3) << distance;
  }
}

TEST(DepthWeights, FallShortAsDifferencesOfPixelsDo) {
  EXPECT_EQ(depth_weights(1, 1).far, fourth_degree.far);
  EXPECT_EQ(depth_weights(0.5, 2).far, fourth_degree.far);
  float before = depth_weights(1, 0).far;
  for (double across = 0.1; across < 1; across += 0.1) {
    const float far = depth_weights(1, across).far;
    EXPECT_GT(far, before) << across;
    before = far;
  }
}

// A field near the band limit, seen aslant in steps of T.
TEST(DepthWeights, DraftsOfShortWavesAreNearer) {
  const Slice slice = make_slice({14, 14, 14}, marschner_lobb(14, 2));
  for (const bool perspective : {false, true}) {
    const Scene scene =
        make_scene(slice, ramp_function(0.3, 1, 0.2), fit_camera(slice, perspective, 35, 45, 56, 56));
    RenderOptions o;
    o.opacity_stop = 1, o.sheet_step = 0.25;
    ImageStorage reference(56, 56), got(56, 56);
    o.reference = true;
    draw(scene, o, reference);
    o.reference = false;
    o.sheet_step = 1, o.gradient = GradientMethod::fourth_order;
    draw(scene, o, got);
    EXPECT_GT(compare(reference, got).db(), perspective ? 35.3 : 36.82);
  }
}

} // namespace
} // namespace bccsplat

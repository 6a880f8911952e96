// SPDX-License-Identifier: Apache-2.0
// How a sample is lit by how much gradient there is.
#include "shade/light.h"

#include <gtest/gtest.h>

namespace bccsplat {
namespace {

const Vec3 to_viewer{0, 0, 1}, slanted{0.6, 0, 0.8};

TEST(Light, WithoutNoiseEveryGradientIsASurface) {
  const Lights lights;
  for (const double size : {1e-30, 1e-3, 1.0, 1e30}) {
    const Shading s = shade(lights, size * slanted, to_viewer, 5);
    EXPECT_NEAR(s.scale[0], 0.3 + 0.7 * 0.8, 1e-12);
    EXPECT_NEAR(s.highlight[0], 0.2 * std::pow(0.8, 20), 1e-12);
  }
}

TEST(Light, WhatIsNoiseIsLitAsIfItFacedEveryLight) {
  Lights lights;
  lights.lights.push_back({{1, 0, 0}, {0.5, 0.25, 0}});
  lights.noise = {0.1, 0};
  for (const double size : {0.0, 0.01, 0.1}) {
    const Shading s = shade(lights, size * slanted, to_viewer, 5);
    for (size_t c = 0; c < 3; ++c) {
      EXPECT_DOUBLE_EQ(s.scale[c], 0.3 + 0.7 * (1 + lights.lights[1].color[c]));
      EXPECT_EQ(s.highlight[c], 0);
    }
  }
}

TEST(Light, SurfacesRiseFromNoiseToThreeTimesNoise) {
  Lights lights;
  lights.noise = {0.1, 0};
  double before = 1;
  for (double size = 0.1; size < 0.3; size += 0.005) {
    const double light = shade(lights, size * slanted, to_viewer, 5).scale[0];
    EXPECT_LE(light, before);
    EXPECT_LT(before - light, 0.02) << size; // no step
    before = light;
  }
  const Shading most = shade(lights, 0.3 * slanted, to_viewer, 5), plain = shade({}, slanted, to_viewer, 5);
  EXPECT_NEAR(most.scale[0], plain.scale[0], 1e-12);
  EXPECT_NEAR(most.highlight[0], plain.highlight[0], 1e-12);
}

TEST(Light, NoiseGrowsWithTheDistanceFromTheBase) {
  const GradientNoise noise{0.1, 0.02};
  EXPECT_DOUBLE_EQ(noise.at(0), 0.1);
  EXPECT_DOUBLE_EQ(noise.at(5), 0.2);
  EXPECT_DOUBLE_EQ(noise.at(-5), 0.2);
  EXPECT_EQ(surface_weight(0.2, noise.at(-5)), 0);
  EXPECT_EQ(surface_weight(0.3, noise.at(0)), 1);
  EXPECT_EQ(surface_weight(0, 0), 0);
}

} // namespace
} // namespace bccsplat

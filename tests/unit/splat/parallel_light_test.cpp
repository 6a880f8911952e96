// SPDX-License-Identifier: Apache-2.0
// Light of a parallel view, made once, is that of shade().
#include "splat/shade/parallel_light.h"

#include <gtest/gtest.h>

#include <random>

namespace bccsplat {
namespace {

TEST(ParallelLight, IsThatOfOneSample) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const Vec3 to_viewer = normalized({0.3, -0.5, 0.8});
  Lights lights;
  lights.lights.push_back({{1, 0.2, -0.4}, {0.5, 0.25, 0.1}});
  lights.lights.push_back({-1.0 * to_viewer, {1, 0.9, 0.8}}); // from behind
  lights.noise = {0.1, 0.02};
  for (const double shininess : {20.0, 0.0, 7.0, 3.3, 5000.0}) {
    lights.shininess = shininess;
    const ParallelLight parallel(lights, to_viewer);
    for (int n = 0; n < 400; ++n) {
      const double size = n % 3 == 0 ? 0.4 : std::exp(20 * uniform(random)), value = 3 * uniform(random);
      Vec3 gradient = n == 0 ? Vec3{} : size * Vec3{uniform(random), uniform(random), uniform(random)};
      if (n % 7 == 1) gradient = size * to_viewer;
      const Shading one = shade(lights, gradient, to_viewer, value), many = parallel.shade(gradient, value);
      for (size_t c = 0; c < 3; ++c) {
        EXPECT_NEAR(many.scale[c], one.scale[c], 1e-12);
        EXPECT_NEAR(many.highlight[c], one.highlight[c], 1e-11);
      }
    }
  }
}

} // namespace
} // namespace bccsplat

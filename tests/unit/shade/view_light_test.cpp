// SPDX-License-Identifier: Apache-2.0
// Light of a view, made once, is that of shade().
#include "shade/view_light.h"

#include <gtest/gtest.h>

#include <random>

namespace bccsplat {
namespace {

TEST(ViewLight, IsThatOfOneSample) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const Vec3 to_viewer = normalized({0.3, -0.5, 0.8});
  Lights lights;
  lights.lights.push_back({{1, 0.2, -0.4}, {0.5, 0.25, 0.1}});
  lights.lights.push_back({-1.0 * to_viewer, {1, 0.9, 0.8}}); // from behind
  lights.noise = {0.1, 0.02};
  for (const double shininess : {20.0, 0.0, 7.0, 3.3, 5000.0}) {
    lights.shininess = shininess;
    const ViewLight parallel(lights, to_viewer);
    for (int n = 0; n < 400; ++n) {
      const double size = n % 3 == 0 ? 0.4 : std::exp(20 * uniform(random)), value = 3 * uniform(random);
      Vec3 gradient = n == 0 ? Vec3{} : size * Vec3{uniform(random), uniform(random), uniform(random)};
      if (n % 7 == 1) gradient = size * to_viewer;
      const Shading one = shade(lights, gradient, to_viewer, value), many = parallel.shade(gradient, value);
      for (size_t c = 0; c < 3; ++c) {
        EXPECT_NEAR(many.scale[c], one.scale[c], 1e-12);
        EXPECT_NEAR(many.highlight[c], one.highlight[c], 1e-11);
      }
      // Seen from elsewhere, and from straight behind a light.
      const Vec3 aside = n % 5 == 0 ? -1.0 * normalized(lights.lights[1].direction)
                                    : normalized({uniform(random), uniform(random), 1.1});
      const Shading there = shade(lights, gradient, aside, value),
                    of_many = parallel.shade(gradient, value, aside);
      for (size_t c = 0; c < 3; ++c) {
        EXPECT_NEAR(of_many.scale[c], there.scale[c], 1e-12);
        EXPECT_NEAR(of_many.highlight[c], there.highlight[c], 1e-11);
      }
    }
  }
}

} // namespace
} // namespace bccsplat

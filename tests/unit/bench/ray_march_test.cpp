// SPDX-License-Identifier: Apache-2.0
// The benchmark's ray-marcher against its double-precision reference.
#include "tests/bench/ray_march/ray_march.h"

#include <gtest/gtest.h>

#include "tests/support/splat_scene.h"

namespace bccsplat::bench {
namespace {

using namespace test;

struct Case {
  const char* name;
  bool perspective;
  RenderMode mode;
  bool shading;
  double step;
};

class RayMarch : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(Bench, RayMarch,
                         testing::Values(Case{"composite", false, RenderMode::composite, true, 1},
                                         Case{"composite_fine", false, RenderMode::composite, true, 0.3},
                                         Case{"unshaded", false, RenderMode::composite, false, 0.5},
                                         Case{"perspective", true, RenderMode::composite, true, 0.5},
                                         Case{"isosurface", false, RenderMode::isosurface, true, 1},
                                         Case{"isosurface_perspective", true, RenderMode::isosurface, true,
                                              0.5}),
                         [](const auto& instance) { return instance.param.name; });

TEST_P(RayMarch, DrawsWhatItsReferenceDraws) {
  const Case& c = GetParam();
  // A ball in empty space beside a pattern: cells to skip, dense ones and the ends of the domain.
  const Field3 pattern = marschner_lobb(21, 2);
  const MarchGrid grid = make_march_grid({45, 29, 37}, [&](double x, double y, double z) {
    const double ball = 1 - std::hypot(x - 36, y - 20, z - 9) / 6;
    return std::max({0.0, ball, x < 21 ? 0.9 * pattern(x, y, z) : 0});
  });
  MarchScene scene;
  scene.grid = &grid;
  scene.function = ramp_function(0.35, 1, 0.5);
  scene.camera = fit_camera(grid_domain(grid), c.perspective, 20, 30, 71, 58);
  scene.lights.lights = {Light{}, Light{{1, 2, -0.5}, {0.2, 0.5, 0.1}}};
  MarchOptions o;
  o.mode = c.mode, o.shading = c.shading, o.step = c.step, o.iso_value = 0.52;
  const std::vector<uint8_t> distance = march_distances(grid, scene.function, o);
  EXPECT_GT(std::count_if(distance.begin(), distance.end(), [](uint8_t n) { return n > 0; }), 20);
  scene.distance = &distance;
  ImageStorage slow(71, 58), fast(71, 58), plain(71, 58);
  TestContext context(2);
  ray_march_reference(scene, o, slow.image);
  ray_march(scene, o, context.get(), fast.image);
  o.skip = false;
  ray_march(scene, o, context.get(), plain.image);
  size_t covered = 0, differ = 0;
  for (size_t p = 0; p < slow.rgba.size(); p += 4) {
    covered += slow.rgba[p + 3] > 0;
    for (size_t k = 0; k < 4; ++k) differ += std::fabs(slow.rgba[p + k] - fast.rgba[p + k]) > 4e-3f;
  }
  EXPECT_GT(covered, 600u);
  // Rays that graze a surface or an entry of the table may fall on either side.
  EXPECT_LE(differ, 4 + covered / 200);
  EXPECT_GT(compare(slow, fast).db(), c.mode == RenderMode::isosurface ? 30 : 60);
  EXPECT_GT(compare(plain, fast).db(), c.mode == RenderMode::isosurface ? 40 : 90);
}

} // namespace
} // namespace bccsplat::bench

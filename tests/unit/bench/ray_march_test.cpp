// SPDX-License-Identifier: Apache-2.0
// The benchmark's ray-marcher against its double-precision reference, and what it interpolates with.
#include "tests/bench/ray_march/ray_march.h"

#include <random>

#include <gtest/gtest.h>

#include "tests/support/splat_scene.h"
#include "tests/support/targets.h"

namespace bccsplat::bench {
namespace {

using namespace test;

constexpr Interpolation tricubic = Interpolation::tricubic;

struct Case {
  const char* name;
  bool perspective;
  RenderMode mode;
  bool shading;
  double step;
  Interpolation interpolation = Interpolation::trilinear;
};

class RayMarch : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(
    Bench, RayMarch,
    testing::Values(Case{"composite", false, RenderMode::composite, true, 1},
                    Case{"composite_fine", false, RenderMode::composite, true, 0.3},
                    Case{"unshaded", false, RenderMode::composite, false, 0.5},
                    Case{"perspective", true, RenderMode::composite, true, 0.5},
                    Case{"isosurface", false, RenderMode::isosurface, true, 1},
                    Case{"isosurface_perspective", true, RenderMode::isosurface, true, 0.5},
                    Case{"tricubic", false, RenderMode::composite, true, 1, tricubic},
                    Case{"tricubic_perspective", true, RenderMode::composite, true, 0.5, tricubic},
                    Case{"tricubic_isosurface", false, RenderMode::isosurface, true, 1, tricubic},
                    Case{"tricubic_isosurface_perspective", true, RenderMode::isosurface, true, 0.5,
                         tricubic}),
    [](const auto& instance) { return instance.param.name; });

TEST_P(RayMarch, DrawsWhatItsReferenceDraws) {
  const Case& c = GetParam();
  // A ball in empty space beside a pattern: cells to skip, dense ones and the ends of the domain.
  const Field3 pattern = marschner_lobb(21, 2);
  const auto field = [&](double x, double y, double z) {
    const double ball = 1 - std::hypot(x - 36, y - 20, z - 9) / 6;
    return std::max({0.0, ball, x < 21 ? 0.9 * pattern(x, y, z) : 0});
  };
  const MarchGrid grid = make_march_grid({45, 29, 37}, field, c.interpolation);
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

// A plane just before the end of a cell, that rays cross between the last sheet in it and the first one
// behind.
TEST(RayMarchCells, NoSurfaceIsLostOnTheWayOut) {
  for (const Interpolation interpolation : {Interpolation::trilinear, tricubic})
    for (const double iso : {7.2, 7.6, 7.95, 8.3}) {
      const MarchGrid grid = make_march_grid(
          {25, 25, 25}, [](double, double, double z) { return z; }, interpolation);
      MarchOptions o;
      o.mode = RenderMode::isosurface, o.iso_value = iso;
      MarchScene scene;
      scene.grid = &grid, scene.function = ramp_function(0, 24, 1);
      scene.camera = fit_camera(grid_domain(grid), false, 3, 4, 64, 64);
      const std::vector<uint8_t> distance = march_distances(grid, scene.function, o);
      scene.distance = &distance;
      ImageStorage picture(64, 64);
      TestContext context(1);
      ray_march(scene, o, context.get(), picture.image);
      size_t covered = 0;
      for (size_t p = 3; p < picture.rgba.size(); p += 4) covered += picture.rgba[p] > 0;
      EXPECT_GT(covered, 1300u) << "iso value " << iso;
    }
}

// Points everywhere in the grid, its corners and samples among them.
std::vector<MarchPoint> points_in(const Int3& dims) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> unit(0, 1);
  std::vector<MarchPoint> points{
      {0, 0, 0},
      {static_cast<float>(dims[0] - 1), static_cast<float>(dims[1] - 1), static_cast<float>(dims[2] - 1)},
      {2, 3, 4}};
  while (points.size() < 1001) { // no multiple of any number of lanes
    MarchPoint p;
    for (size_t a = 0; a < 3; ++a) p[a] = unit(random) * static_cast<float>(dims[a] - 1);
    points.push_back(p);
  }
  return points;
}

Vec3 wide(const MarchPoint& p) {
  return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
}

MarchGrid noise_grid(const Int3& dims, Interpolation interpolation) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(0, 1);
  return make_march_grid(
      dims, [&](double, double, double) { return unit(random); }, interpolation);
}

TEST(RayMarchTricubic, VectorsGiveTheValuesAndGradientsOfTheFormula) {
  const Int3 dims{23, 17, 19};
  const MarchGrid grid = noise_grid(dims, tricubic);
  const std::vector<MarchPoint> points = points_in(dims);
  for_targets([&] {
    std::vector<MarchFieldValue> values(points.size());
    if (!march_values(grid, points, values)) return; // scalar: the formula is what draws
    for (size_t i = 0; i < points.size(); ++i) {
      Vec3 gradient;
      const double value = march_value(grid, wide(points[i]), &gradient);
      ASSERT_NEAR(values[i].value, value, 1e-5);
      for (size_t a = 0; a < 3; ++a) ASSERT_NEAR(values[i].gradient[a], gradient[a], 2e-5);
    }
  });
}

TEST(RayMarchTricubic, GradientIsTheLimitOfDifferences) {
  const Int3 dims{23, 17, 19};
  const MarchGrid grid = noise_grid(dims, tricubic);
  constexpr double h = 1e-4;
  for (const MarchPoint& point : points_in({21, 15, 17})) {
    const Vec3 p = wide(point) + Vec3{1, 1, 1};
    Vec3 gradient;
    (void)march_value(grid, p, &gradient);
    for (size_t a = 0; a < 3; ++a) {
      Vec3 low = p, high = p;
      low[a] -= h, high[a] += h;
      ASSERT_NEAR((march_value(grid, high) - march_value(grid, low)) / (2 * h), gradient[a], 2e-3);
    }
  }
}

TEST(RayMarchTricubic, SplinesPassThroughTheSamples) {
  const Int3 dims{9, 70, 2};
  const MarchGrid splines = noise_grid(dims, tricubic), samples = noise_grid(dims, Interpolation::trilinear);
  for (int z = 0; z < dims[2]; ++z)
    for (int y = 0; y < dims[1]; ++y)
      for (int x = 0; x < dims[0]; ++x)
        ASSERT_NEAR(
            march_value(splines, {static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)}),
            samples.value[samples.at(x, y, z)], 1e-6);
}

// Mirrored ends bend a polynomial: what they add falls to 0.27 of it per sample.
TEST(RayMarchTricubic, ReproducesQuadratics) {
  const auto field = [](double x, double y, double z) {
    return 0.3 + 0.01 * x - 0.02 * y + 0.001 * (x * x - 2 * y * y + x * z + z * z - y * z);
  };
  const Int3 dims{41, 43, 45};
  const MarchGrid grid = make_march_grid(dims, field, tricubic);
  for (const MarchPoint& point : points_in({11, 13, 15})) {
    const Vec3 p = wide(point) + Vec3{15, 15, 15};
    ASSERT_NEAR(march_value(grid, p), field(p[0], p[1], p[2]), 1e-6);
  }
}

TEST(RayMarchTricubic, ValuesInACellAreWithinItsBounds) {
  const Int3 dims{23, 17, 19};
  const MarchGrid grid = noise_grid(dims, tricubic);
  // Coefficients bound the values, too, but by far too much.
  const auto [least, most] = std::minmax_element(grid.value.begin(), grid.value.end());
  for (size_t c = 0; c < grid.low.size(); ++c) EXPECT_LT(grid.high[c] - grid.low[c], 0.8f * (*most - *least));
  for (const MarchPoint& point : points_in(dims)) {
    Int3 cell;
    for (size_t a = 0; a < 3; ++a)
      cell[a] = std::min(static_cast<int>(point[a]) / MarchGrid::cell_edge, grid.cells[a] - 1);
    const size_t c = cell[0] + grid.cells[0] * (cell[1] + grid.cells[1] * cell[2]);
    const double value = march_value(grid, wide(point));
    ASSERT_GE(value, grid.low[c] - 1e-6);
    ASSERT_LE(value, grid.high[c] + 1e-6);
  }
}

} // namespace
} // namespace bccsplat::bench

// SPDX-License-Identifier: Apache-2.0
// Dense sampling of a slice against the slow reference.
#include "field/sample_grid.h"

#include <gtest/gtest.h>

#include "tests/support/dense_layer.h"
#include "tests/support/fields.h"
#include "tests/support/targets.h"

namespace bccsplat {
namespace {

using test::TestContext;

// Noise coefficients in [-1, 1] above air, with a place in slice space of its own; a brick in four is absent.
Slice noise_slice(const char* kernel, const Int3& last) {
  Slice s;
  s.lattice.last = last;
  s.kernel = make_kernel(kernel);
  s.base = 3;
  std::mt19937 random(17);
  std::uniform_real_distribution<float> value(-1, 1);
  for (int c = 0; c < 2; ++c) {
    std::vector<float> dense(static_cast<size_t>(s.lattice.sites(c)));
    for (float& v : dense) v = value(random);
    BrickLayer& layer = s.coset[c];
    layer = test::layer_from_dense(s.lattice, c, dense);
    for (size_t slot = 0; slot < layer.brick_slots() && layer.brick_slots() > 1; ++slot)
      if (random() % 4 == 0) layer.set(slot, nullptr);
  }
  for (size_t a = 0; a < 3; ++a) {
    s.domain_end[a] = s.lattice.plane_distance() * last[a];
    s.lattice_to_slice.linear[a] = {};
    s.lattice_to_slice.linear[a][a] = 0.9 + 0.1 * static_cast<double>(a);
    s.lattice_to_slice.offset[a] = -2.5 + static_cast<double>(a);
  }
  return s;
}

void expect_reference(const Slice& slice, const Grid& grid) {
  TestContext context;
  const size_t count = static_cast<size_t>(grid.dims[0] * grid.dims[1]) * grid.dims[2];
  std::vector<float> values(count, -99);
  sample_grid(slice, grid, values.data(), context.get());
  const Affine3 to_lattice = slice.lattice_to_slice.inverse();
  size_t i = 0, inside = 0;
  for (int z = 0; z < grid.dims[2]; ++z)
    for (int y = 0; y < grid.dims[1]; ++y)
      for (int x = 0; x < grid.dims[0]; ++x, ++i) {
        Vec3 p = to_lattice.point({grid.origin[0] + grid.step[0] * x, grid.origin[1] + grid.step[1] * y,
                                   grid.origin[2] + grid.step[2] * z});
        if (!slice.inside(p) || slice.is_hole(p)) {
          ASSERT_TRUE(std::isnan(values[i])) << x << ' ' << y << ' ' << z;
          continue;
        }
        ++inside;
        ASSERT_NEAR(values[i], evaluate_reference(slice, p, nullptr), 3e-6) << x << ' ' << y << ' ' << z;
      }
  EXPECT_GT(inside, count / 8);
}

class GridKernel : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(SampleGrid, GridKernel,
                         testing::Values("fast", "default", "fine", "gauss09", "paper"),
                         [](const auto& instance) { return std::string(instance.param); });

TEST_P(GridKernel, SamplesAreTheReferenceOnEveryTarget) {
  const Slice slice = noise_slice(GetParam(), {60, 33, 20});
  test::for_targets([&] {
    for (const double step : {1.0, 0.31, 2.7}) {
      Grid grid;
      grid.origin = {-3.5, -2, -1.1}; // the first samples lie outside
      grid.step = {step, 0.8 * step, 1.2 * step};
      grid.dims = {static_cast<int32_t>(45 / step), static_cast<int32_t>(30 / step), 5};
      expect_reference(slice, grid);
    }
  });
}

TEST(SampleGrid, AnyStepAndSize) {
  const Slice slice = noise_slice("default", {60, 33, 20});
  expect_reference(slice, {{36, 20, 14}, {-1, -0.7, -1.3}, {40, 30, 12}}); // backwards
  expect_reference(slice, {{3, 4, 5}, {0, 0, 0}, {3, 2, 2}});              // all samples in one place
  expect_reference(slice, {{5, 5, 5}, {1e-4, 1e-4, 1e-4}, {700, 3, 2}});
  expect_reference(slice, {{-2.5, -1.5, -0.5}, {38, 23, 15}, {2, 2, 2}}); // the corners
}

TEST(SampleGrid, LongRowsAreCutIntoTiles) {
  const Slice slice = noise_slice("fine", {2000, 9, 9});
  expect_reference(slice, {{-2, -1, 0}, {3.9, 1, 1}, {320, 4, 3}});
  expect_reference(slice, {{-2, -1, 0}, {0.9, 1, 1}, {1400, 2, 2}});
}

TEST(SampleGrid, TinyLattice) {
  expect_reference(noise_slice("fine", {1, 2, 1}), {{-2.5, -1.5, -0.5}, {0.11, 0.17, 0.1}, {7, 8, 8}});
}

TEST(SampleGrid, ClipsAndHoles) {
  Slice slice = noise_slice("default", {40, 40, 40});
  slice.clip.push_back({{1, -0.5, 0.25}, -4});
  auto brick = std::make_shared<Brick>();
  brick->value = slice.coset[0].share(0) ? slice.coset[0].share(0)->value : brick->value;
  brick->hole = std::make_unique<BrickMask>();
  for (auto& row : *brick->hole) row = 0x0f80;
  slice.coset[0].set(0, std::move(brick));
  slice.has_holes = true;
  expect_reference(slice, {{-2, -1, 0}, {1, 1, 1}, {24, 24, 24}});
}

TEST(SampleGrid, AxesThatAreNotThoseOfTheLattice) {
  Slice slice = noise_slice("default", {20, 20, 20});
  slice.lattice_to_slice.linear = {Vec3{0.8, -0.6, 0}, Vec3{0.6, 0.8, 0}, Vec3{0, 0, 1}};
  expect_reference(slice, {{-4, 2, 2}, {0.7, 0.7, 0.7}, {14, 14, 14}});
}

} // namespace
} // namespace bccsplat

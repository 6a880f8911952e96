// SPDX-License-Identifier: Apache-2.0
// Isosurfaces by rays: the bound that cells are passed over by, and that passing over them changes no pixel.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/bench/rays/ray_picture.h"
#include "tests/support/splat_scene.h"
#include "tests/support/targets.h"

namespace bccsplat::bench {
namespace {

using namespace test;

// With coefficients of +-1 that make the most of a place, the difference from the corners comes near the
// bound and never passes it.
TEST(Rays, BoundHoldsAndIsNear) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (const char* name : {"radial16+b2", "radial18+b3", "radial20+b3", "radial24+b4"}) {
    const RadialKernel kernel = make_kernel(name).space;
    for (const int parts : {1, 2}) {
      const CellBound bound = cell_bound(kernel, parts);
      double most = 0;
      for (int trial = 0; trial < 4000; ++trial) {
        Vec3 low, part;
        for (size_t a = 0; a < 3; ++a) {
          low[a] = std::floor(uniform(random) * parts) / parts;
          part[a] = uniform(random);
        }
        double range = 0, middle = 0;
        for (int z = -5; z <= 6; ++z)
          for (int y = -5; y <= 6; ++y)
            for (int x = -5; x <= 6; ++x) {
              if (((x ^ y) & 1) != 0 || ((x ^ z) & 1) != 0) continue;
              const auto weight = [&](const Vec3& at) {
                const Vec3 d = at - Vec3{1.0 * x, 1.0 * y, 1.0 * z};
                return kernel.value(0.5 * dot(d, d));
              };
              double r = weight(low + (1.0 / parts) * part);
              for (size_t c = 0; c < 8; ++c) {
                double share = 1;
                Vec3 corner = low;
                for (size_t a = 0; a < 3; ++a) {
                  share *= (c >> a & 1) != 0 ? part[a] : 1 - part[a];
                  corner[a] += (c >> a & 1) != 0 ? 1.0 / parts : 0;
                }
                r -= share * weight(corner);
              }
              range += std::fabs(r), middle += r;
            }
        EXPECT_LE(range, bound.of_range) << name;
        EXPECT_LE(std::fabs(middle), bound.of_middle) << name;
        most = std::max(most, range);
      }
      EXPECT_GT(most, (parts == 1 ? 0.9 : 0.75) * bound.of_range) << name << ' ' << parts;
    }
  }
}

// The field lies where its cell says, and cells say something: rounded outward, by a few hundredths.
TEST(Rays, CellsHoldTheField) {
  constexpr int n = 26;
  const Slice s = make_slice({n, n + 3, n - 5}, marschner_lobb(n, 5));
  std::mt19937 random(11);
  for (const int parts : {1, 2}) {
    const CellRanges ranges = make_cell_ranges(s, parts, cell_bound(s.kernel.space, parts));
    double width = 0;
    constexpr int trials = 20000;
    for (int trial = 0; trial < trials; ++trial) {
      Vec3 p;
      Int3 cell;
      for (size_t a = 0; a < 3; ++a) {
        p[a] = std::uniform_real_distribution<double>(0, s.domain_end[a])(random);
        cell[a] = std::min(static_cast<int>(p[a] * std::sqrt(2.0)), ranges.cells[a] - 1);
      }
      const auto block = static_cast<size_t>(
          ((cell[2] / 4) * ranges.blocks[1] + cell[1] / 4) * ranges.blocks[0] + cell[0] / 4);
      ASSERT_GE(ranges.of_block[block], 0);
      const BlockRanges& b = ranges.ranges[static_cast<size_t>(ranges.of_block[block])];
      const auto at = static_cast<size_t>(((cell[2] & 3) * 4 + (cell[1] & 3)) * 4 + (cell[0] & 3));
      const double value = evaluate_reference(s, p, nullptr) - static_cast<double>(s.base);
      const auto edge = [&](uint8_t byte) { return static_cast<double>(b.low + b.scale * byte); };
      ASSERT_GE(value, edge(b.from[at]) - 1e-6);
      ASSERT_LE(value, edge(b.to[at]) + 1e-6);
      width += edge(b.to[at]) - edge(b.from[at]);
    }
    EXPECT_LT(width / trials, parts == 1 ? 0.75 : 0.5);
  }
}

// From all sides, near and far, with and without air.
TEST(Rays, PassingOverCellsChangesNoPixel) {
  const Slice dense = make_slice({30, 26, 33}, marschner_lobb(30, 5));
  const Slice sparse = make_slice({44, 40, 36}, [](double x, double y, double z) {
    return std::max(0.0, 1 - std::hypot(x - 30, y - 22, z - 9) / 6) +
           std::max(0.0, 1 - std::hypot(x - 8, y - 9, z - 28) / 5);
  });
  for (const Slice* s : {&dense, &sparse})
    for (const int parts : {1, 2}) {
      const CellRanges ranges = make_cell_ranges(*s, parts, cell_bound(s->kernel.space, parts));
      for (const auto& [x, y] :
           {std::pair{20.0, 30.0}, std::pair{0.0, 0.0}, std::pair{200.0, 75.0}, std::pair{-80.0, 140.0}}) {
        constexpr int size = 90;
        const Scene scene = make_scene(*s, ramp_function(0, 1, 0.5), fit_camera(*s, false, x, y, size, size));
        for (const double iso : {0.3, 0.5})
          for (const double step : {1.0, 0.5}) {
            RayPicture everywhere(scene, ranges, iso, true), rays(scene, ranges, iso);
            ImageStorage all(size, size), some(size, size);
            everywhere.draw(step, false, all.image);
            rays.draw(step, false, some.image);
            EXPECT_TRUE(some.rgba == all.rgba) << x << ' ' << y << ' ' << iso << ' ' << step;
            EXPECT_GT(rays.counts().hits, 50u);
            EXPECT_LT(rays.counts().samples, 3 * everywhere.counts().samples / 4);
          }
      }
    }
}

// What is passed over, and with it the picture, is the same with vectors of any length.
TEST(Rays, CellsAreTheSameOnEveryTarget) {
  const Slice s = make_slice({30, 26, 33}, marschner_lobb(30, 5));
  const CellBound bound = cell_bound(s.kernel.space, 2);
  const Scene scene = make_scene(s, ramp_function(0, 1, 0.5), fit_camera(s, false, 20, 30, 60, 60));
  const CellRanges best = make_cell_ranges(s, 2, bound);
  for_targets([&] {
    const CellRanges ranges = make_cell_ranges(s, 2, bound);
    ASSERT_EQ(ranges.ranges.size(), best.ranges.size());
    for (size_t n = 0; n < best.ranges.size(); ++n)
      EXPECT_NEAR(ranges.ranges[n].low, best.ranges[n].low, 1e-5f);
    ImageStorage all(60, 60), some(60, 60);
    RayPicture(scene, ranges, 0.5, true).draw(1, false, all.image);
    RayPicture(scene, ranges, 0.5).draw(1, false, some.image);
    EXPECT_TRUE(some.rgba == all.rgba);
  });
}

// What sheets draw, but where rays graze.
TEST(Rays, PicturesAreThoseOfTheRenderer) {
  constexpr int n = 36, size = 124;
  const Slice s = make_slice({n, n, n}, marschner_lobb(n, 5));
  const Scene scene = make_scene(s, ramp_function(0, 1, 0.5), fit_camera(s, false, 20, 30, size, size));
  RenderOptions options;
  options.mode = RenderMode::isosurface, options.iso_value = 0.5, options.reference = true;
  ImageStorage exact(size, size), image(size, size);
  (void)draw(scene, options, exact);
  const CellRanges ranges = make_cell_ranges(s, 2, cell_bound(s.kernel.space, 2));
  RayPicture(scene, ranges, 0.5).draw(0.5, false, image.image);
  EXPECT_GT(compare(image, exact).db(), 41);
}

} // namespace
} // namespace bccsplat::bench

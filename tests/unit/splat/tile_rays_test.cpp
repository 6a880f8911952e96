// SPDX-License-Identifier: Apache-2.0
// The rays of a tile, made whole rows at a time, are compared with one ray at a time.
#include "splat/tile/tile_rays.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/splat_scene.h"

namespace bccsplat {
namespace {

using namespace test;

TEST(TileRays, AreThoseOfTheirPixels) {
  Affine3 sheared;
  sheared.linear = {Vec3{1, 0, 0}, Vec3{0, 1.2, 0.2}, Vec3{0, 0, 1.4}};
  Slice slice = make_slice(
      {12, 9, 11}, [](double, double, double) { return 1; }, "default", sheared);
  for (const bool clipped : {false, true}) {
    if (clipped) slice.clip = {{{0.6, 0, 0.8}, -4}, {{0, -1, 0}, 6.5}, {{0, 0, 1}, 0.25}};
    for (const bool perspective : {false, true})
      for (const double turn : {0.0, 33.0, 90.0}) { // 0 and 90: rays along faces of the domain
        const Camera camera = fit_camera(slice, perspective, turn / 3, turn, 61, 57);
        const SheetView view = make_view(slice, resolve_camera(camera), 61, 57, 0.5);
        PlannedTile tile;
        tile.x = 7, tile.y = 3, tile.width = 50, tile.height = 51;
        constexpr int pitch = 64;
        std::vector<float> planes(ray_planes * pitch * 51, 7.0f);
        PixelPlanes out;
        const TileRays rays = make_rays(slice, view, tile, pitch, planes.data(), out);
        int open = 0;
        for (int y = 0; y < tile.height; ++y)
          for (int x = 0; x < pitch; ++x) {
            const size_t p = pitch * y + x;
            if (x >= tile.width) {
              ASSERT_GT(out.enter[p], out.leave[p]);
              ASSERT_EQ(out.path[p], 0.0f);
              continue;
            }
            const auto [k0, k1] = ray_interval(slice, view, tile.x + x, tile.y + y);
            if (std::fabs(k0 - k1) < 1e-9) continue; // along an edge: rounding decides
            ASSERT_EQ(out.enter[p] < out.leave[p], k0 < k1) << x << ' ' << y;
            const Vec3 ray = view.lattice_to_world.vector(view.ray(tile.x + x, tile.y + y));
            ASSERT_NEAR(out.path[p], length(ray), 1e-6);
            ASSERT_NEAR(out.view_y[p], -ray[1] / length(ray), 1e-6);
            if (!(k0 < k1)) continue;
            ++open;
            ASSERT_NEAR(out.enter[p], k0, 1e-5);
            ASSERT_NEAR(out.leave[p], k1, 1e-5);
            ASSERT_LE(rays.low, k0 + 1e-9);
            ASSERT_GE(rays.high, k1 - 1e-9);
          }
        EXPECT_EQ(rays.open, open);
        EXPECT_GT(open, 300);
      }
  }
}

} // namespace
} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Axes of rays: what is said of a tile's rays holds for each of them, and few axes are taken where few do.
#include "rays/ray_axes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "rays/ray_lanes.h"
#include "tests/support/splat_scene.h"
#include "view/camera.h"

namespace bccsplat {
namespace {

SheetView view_of(double fovy, double turn, int width, int height) {
  const Slice s = test::make_slice({20, 24, 18}, [](double x, double, double) { return x; });
  Camera camera = fit_camera(s, fovy > 0, 20, turn, width, height);
  if (fovy > 0) camera.fovy_degrees = fovy;
  return make_view(s, resolve_camera(camera), width, height, 0.5);
}

// Each ray, and those of a piece beside each other.
void check_rays(const SheetView& view, const RayAxes& axes) {
  const int columns = (view.width + ray_tile_edge - 1) / ray_tile_edge;
  const auto axis_of = [&](int i, int j) -> const RayAxis& {
    return axes.axes[axes.of_tile[j / ray_tile_edge * columns + i / ray_tile_edge]];
  };
  constexpr double rounding = 1e-12;
  for (int j = 0; j < view.height; ++j)
    for (int i = 0; i < view.width; ++i) {
      const RayAxis& axis = axis_of(i, j);
      const Vec3 ray = view.ray(i, j),
                 first = view.ray(i / piece_edge * piece_edge, j / piece_edge * piece_edge);
      ASSERT_GE(axis.direction * ray[axis.along], axis.least - rounding);
      for (const RayAxis::Across& a : axis.across) {
        ASSERT_NE(a.axis, axis.along);
        const double slope = ray[a.axis] / ray[axis.along];
        ASSERT_GE(slope, a.low - rounding);
        ASSERT_LE(slope, a.high + rounding);
        ASSERT_LE(std::fabs(slope - first[a.axis] / first[axis.along]), a.of_piece + rounding);
      }
    }
}

TEST(RayAxes, HoldForEveryRay) {
  for (const double fovy : {0.0, 5.0, 30.0, 60.0, 100.0})
    for (const double turn : {0.0, 25.0, 44.0, 160.0, 250.0}) {
      const SheetView view = view_of(fovy, turn, 300, 200);
      const auto axes = find_ray_axes(view);
      ASSERT_TRUE(axes) << fovy << ' ' << turn;
      ASSERT_EQ(axes->of_tile.size(), 20u);
      check_rays(view, *axes);
      std::set<std::pair<size_t, int>> ways;
      for (const RayAxis& a : axes->axes) EXPECT_TRUE(ways.insert({a.along, a.direction}).second);
    }
}

// Parallel rays have one slope, rays that nearly are share an axis, those of wide views take what is nearest.
TEST(RayAxes, AreOneWhereRaysAreNearlyParallel) {
  for (const double turn : {0.0, 25.0, 44.0, 160.0}) {
    const auto flat = find_ray_axes(view_of(0, turn, 320, 200)),
               narrow = find_ray_axes(view_of(5, turn, 320, 200));
    ASSERT_TRUE(flat && narrow);
    EXPECT_EQ(flat->axes.size(), 1u);
    EXPECT_LE(flat->axes[0].steepest(), 1.0);
    for (const auto& a : flat->axes[0].across) {
      EXPECT_EQ(a.low, a.high);
      EXPECT_EQ(a.of_piece, 0.0);
    }
    EXPECT_EQ(narrow->axes.size(), 1u);
    const auto wide = find_ray_axes(view_of(70, turn, 640, 360));
    ASSERT_TRUE(wide);
    EXPECT_GT(wide->axes.size(), 1u) << turn;
    for (const RayAxis& a : wide->axes) EXPECT_LT(a.steepest(), 1.5) << turn;
  }
  EXPECT_FALSE(find_ray_axes(view_of(170, 30, 64, 64)));
}

} // namespace
} // namespace bccsplat

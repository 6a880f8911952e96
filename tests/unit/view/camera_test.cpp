// SPDX-License-Identifier: Apache-2.0
// Cameras: what fits into the picture, matrices for other programs against the samples of the splatter, and
// views that make no sense.
#include "view/camera.h"

#include <gtest/gtest.h>

#include "tests/support/larger.h"
#include "tests/support/splat_scene.h"

namespace bccsplat {
namespace {

using test::make_slice;

// Returns the pixel of a world point, fractional; the centre of the top left pixel is (0, 0).
std::array<double, 2> project(const WorldCamera& c, const Vec3& p, int width, int height) {
  const Vec3 d = p - c.position;
  const double depth = c.perspective ? dot(d, c.forward) : 1.0;
  const double pixel = c.height / height;
  return {dot(d, c.right) / depth / pixel + 0.5 * (width - 1),
          -dot(d, c.up) / depth / pixel + 0.5 * (height - 1)};
}

Affine3 sheared() {
  Affine3 a;
  a.linear = {Vec3{0.5, 0.1, 0}, Vec3{0, -1.5, 0.2}, Vec3{0.1, 0, 2}};
  a.offset = {100, -20, 7};
  return a;
}

TEST(Camera, FitShowsTheWholeSliceAndNoMore) {
  const Slice slice = make_slice(
      {9, 14, 6}, [](double, double, double) { return 1; }, "default", sheared());
  const Affine3 to_world = slice.slice_to_world.after(slice.lattice_to_slice);
  for (const bool perspective : {false, true})
    for (const auto& [width, height] : {std::pair{64, 64}, {200, 50}, {50, 200}})
      for (const double turn : {0.0, 35.0, -110.0}) {
        const Camera camera = fit_camera(slice, perspective, turn / 2, turn, width, height);
        const WorldCamera c = resolve_camera(camera);
        const auto centre = project(c, to_world.point(0.5 * slice.domain_end), width, height);
        EXPECT_NEAR(centre[0], 0.5 * (width - 1), 1e-9);
        EXPECT_NEAR(centre[1], 0.5 * (height - 1), 1e-9);
        double farthest = 0;
        for (const Vec3& p : box_corners({}, slice.domain_end)) {
          const auto at = project(c, to_world.point(p), width, height);
          farthest = larger(farthest, std::hypot(at[0] - centre[0], at[1] - centre[1]));
        }
        // The sphere's outline touches the smaller side; corners lie within it.
        EXPECT_LE(farthest, 0.5 * std::min(width, height) * (1 + 1e-9));
        EXPECT_GE(farthest, 0.25 * std::min(width, height));
      }
}

// Of the way from the middle to an edge, the farthest that a corner of the box goes.
double reach(const WorldBox& box, const WorldCamera& c, int width, int height) {
  double most = 0;
  for (const Vec3& p : box_corners(box.low, box.high)) {
    const auto at = project(c, p, width, height);
    most = larger(most, std::fabs(at[0] - 0.5 * (width - 1)) / (0.5 * width));
    most = larger(most, std::fabs(at[1] - 0.5 * (height - 1)) / (0.5 * height));
  }
  return most;
}

TEST(Camera, FittedBoxFillsThePictureInItsWidestTurn) {
  const WorldBox box{{-3, 10, 5}, {7, 12, 6}};
  for (const ViewSide& side : {back_side, front_side, anterior_of_ras, anterior_of_lps})
    for (const bool perspective : {false, true})
      for (const auto& [width, height] : {std::pair{64, 64}, {200, 50}, {50, 200}}) {
        double most = 0, size = 0;
        for (int turn = 0; turn < 360; ++turn) {
          const Camera camera = fit_box(box, side, perspective, 25, turn, width, height);
          most = larger(most, reach(box, resolve_camera(camera), width, height));
          const double now = perspective ? length(camera.position - camera.target) : camera.ortho_height;
          if (turn == 0) size = now;
          EXPECT_NEAR(now, size, 1e-9 * size);
        }
        EXPECT_NEAR(most, 0.92, 0.002) << perspective << width;
      }
}

TEST(Camera, SidesHaveTheirAxesToTheRightAndUp) {
  const WorldBox box{{0, 0, 0}, {2, 2, 2}};
  const auto axes = [&](const ViewSide& side) {
    const WorldCamera c = resolve_camera(fit_box(box, side, false, 0, 0, 64, 64));
    return std::array<Vec3, 3>{c.right, c.up, -1.0 * c.forward};
  };
  const Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  using Axes = std::array<Vec3, 3>;
  const auto expect = [](const Axes& found, const Axes& wanted) {
    for (size_t a = 0; a < 3; ++a) EXPECT_NEAR(length(found[a] - wanted[a]), 0, 1e-12) << a;
  };
  expect(axes(back_side), {-1.0 * x, y, -1.0 * z});
  expect(axes(front_side), {x, y, z});
  expect(axes(anterior_of_ras), {-1.0 * x, z, y});
  expect(axes(anterior_of_lps), {x, z, -1.0 * y});
  // The camera goes to the right, and then up.
  const WorldCamera c = resolve_camera(fit_box(box, front_side, false, 20, 30, 64, 64));
  EXPECT_GT(c.position[0], 1);
  EXPECT_GT(c.position[1], 1);
  EXPECT_GT(c.position[2], 1);
  EXPECT_GT(c.up[1], 0.9);
}

// Returns x M divided by its fourth part.
Vec3 times(const Vec3& p, const std::array<double, 16>& m) {
  std::array<double, 4> out{};
  for (size_t c = 0; c < 4; ++c) out[c] = p[0] * m[c] + p[1] * m[4 + c] + p[2] * m[8 + c] + m[12 + c];
  return (1 / out[3]) * Vec3{out[0], out[1], out[2]};
}

// The points at which the splatter samples pixel (i, j), on any sheet, must come out in the middle of its
// square.
TEST(Camera, MatricesPutSamplesIntoTheirPixels) {
  const Slice slice = make_slice(
      {9, 14, 6}, [](double, double, double) { return 1; }, "default", sheared());
  constexpr int width = 40, height = 25;
  for (const bool perspective : {false, true}) {
    const WorldCamera camera =
        resolve_camera(fit_camera(slice, perspective, 25, -110, uint32_t{width}, uint32_t{height}));
    const SheetView view = make_view(slice, camera, width, height, 0.5);
    const PictureMatrices m = picture_matrices(camera, width, height);
    for (const int k : {-3, 0, 5})
      for (const auto& [i, j] : {std::pair{0, 0}, {width - 1, 0}, {7, 19}, {width - 1, height - 1}}) {
        const Vec3 world = view.lattice_to_world.point(view.sample(i, j, k));
        const Vec3 ndc = times(world, m.world_to_ndc), seen = times(world, m.world_to_camera);
        EXPECT_NEAR(ndc[0], (i + 0.5) / width, 1e-9);
        EXPECT_NEAR(ndc[1], (j + 0.5) / height, 1e-9);
        const double depth = (k + view.depth) * view.step_world;
        EXPECT_NEAR(seen[2], depth, 1e-9 * depth); // in front is positive
        EXPECT_NEAR(ndc[2], perspective ? -1 / depth : depth, 1e-9 * depth);
        // Left-handed: right of the middle is +x, above it +y.
        EXPECT_EQ(seen[0] > 0, i > (width - 1) / 2);
        EXPECT_EQ(seen[1] > 0, j < height / 2);
      }
  }
}

TEST(Camera, StartsAlongZWithYUpAndTurnsAsDocumented) {
  const Slice slice = make_slice({9, 9, 9}, [](double, double, double) { return 1; });
  const auto camera = [&](double x, double y) {
    return resolve_camera(fit_camera(slice, false, x, y, 64, 64));
  };
  const auto expect = [](const Vec3& got, const Vec3& want) {
    for (size_t a = 0; a < 3; ++a) EXPECT_NEAR(got[a], want[a], 1e-12);
  };
  expect(camera(0, 0).forward, {0, 0, 1});
  expect(camera(0, 0).up, {0, 1, 0});
  expect(camera(0, 0).right, {-1, 0, 0}); // right-handed: x points left when z points away
  expect(camera(0, 90).forward, {1, 0, 0});
  expect(camera(90, 0).forward, {0, -1, 0});      // from above
  EXPECT_NEAR(camera(20, 30).right[1], 0, 1e-12); // the vertical stays upright
}

TEST(Camera, RefusesSenselessViews) {
  Camera c;
  c.position = {0, 0, -5}, c.target = {0, 0, 0}, c.up = {0, 1, 0};
  EXPECT_NO_THROW((void)resolve_camera(c));
  const auto bad = [&](auto change) {
    Camera other = c;
    change(other);
    try {
      (void)resolve_camera(other);
      return false;
    } catch (const Error& e) {
      return e.code() == Code::invalid_argument;
    }
  };
  EXPECT_TRUE(bad([](Camera& x) { x.target = x.position; }));
  EXPECT_TRUE(bad([](Camera& x) { x.up = {0, 0, 3}; }));
  EXPECT_TRUE(bad([](Camera& x) { x.up = {0, 0, 0}; }));
  EXPECT_TRUE(bad([](Camera& x) { x.ortho_height = 0; }));
  EXPECT_TRUE(bad([](Camera& x) { x.position[0] = std::nan(""); }));
  EXPECT_TRUE(bad([](Camera& x) { x.perspective = true, x.fovy_degrees = 180; }));
  EXPECT_TRUE(bad([](Camera& x) { x.perspective = true, x.fovy_degrees = 0; }));
}

TEST(Camera, SamplesOfAViewProjectOntoTheirPixels) {
  const Slice slice = make_slice(
      {9, 14, 6}, [](double, double, double) { return 1; }, "default", sheared());
  for (const bool perspective : {false, true}) {
    const WorldCamera c = resolve_camera(fit_camera(slice, perspective, 20, 30, 37, 21));
    const SheetView view = make_view(slice, c, 37, 21, 0.5);
    for (const double i : {0.0, 11.0, 36.0})
      for (const double j : {0.0, 20.0})
        for (const double k : {-7.0, 0.0, 4.0}) {
          const Vec3 p = view.lattice_to_world.point(view.sample(i, j, k));
          const auto at = project(c, p, 37, 21);
          EXPECT_NEAR(at[0], i, 1e-9);
          EXPECT_NEAR(at[1], j, 1e-9);
          EXPECT_NEAR(dot(p - c.position, c.forward), (k + view.depth) * view.step_world, 1e-9);
          EXPECT_NEAR(view.sheet(view.sample(i, j, k)), k, 1e-9);
        }
    // Sheets are `step` apart in lattice space.
    EXPECT_NEAR(dot(view.normal, view.sample(3, 4, 1) - view.sample(3, 4, 0)), 0.5, 1e-12);
  }
}

} // namespace
} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
#include "scene/seen_box.h"

#include <gtest/gtest.h>

#include <memory>

#include "tests/support/splat_scene.h"

namespace bccsplat {
namespace {

using test::make_slice;

// A ball of radius 5 around (12, 20, 9) in 40 x 32 x 24 samples, or one of 9 and a speck in a far corner.
Slice seen_ball(bool speck) {
  return make_slice({40, 32, 24}, [&](double x, double y, double z) {
    if (speck && x > 38 && y > 30 && z > 22) return 1.0;
    return std::clamp((speck ? 9.5 : 5.5) - std::hypot(x - 12, y - 20, z - 9), 0.0, 1.0);
  });
}

TransferFunction shows_from(double value) {
  TransferFunction f;
  f.colors = {{0, {1, 1, 1}}};
  f.opacities = {{value, 0}, {value, 1}};
  return f;
}

void expect_box(const WorldBox& box, const Vec3& low, const Vec3& high, double tolerance) {
  for (size_t a = 0; a < 3; ++a) {
    EXPECT_NEAR(box.low[a], low[a], tolerance) << a;
    EXPECT_NEAR(box.high[a], high[a], tolerance) << a;
  }
}

TEST(SeenBox, IsAroundTheObjectAndNotTheDomain) {
  expect_box(seen_box(seen_ball(false), shows_from(0.5)), {7, 15, 4}, {17, 25, 14}, 2.5);
}

TEST(SeenBox, LeavesSpecksOut) {
  const WorldBox box = seen_box(seen_ball(true), shows_from(0.5));
  EXPECT_LT(box.high[0], 24);
  EXPECT_LT(box.high[2], 21);
}

TEST(SeenBox, IsTheDomainWhereNothingOrAirIsSeen) {
  expect_box(seen_box(seen_ball(false), shows_from(2)), {0, 0, 0}, {39, 31, 23}, 1e-6);
  TransferFunction all = shows_from(0.5);
  all.opacities = {{0, 0.1}};
  expect_box(seen_box(seen_ball(false), all), {0, 0, 0}, {39, 31, 23}, 1e-6);
}

TEST(SeenBox, IsInTheWorld) {
  Affine3 world;
  world.linear = {Vec3{0, -2, 0}, Vec3{3, 0, 0}, Vec3{0, 0, 1}}; // x' = -2 y, y' = 3 x
  world.offset = {100, 0, 0};
  const Slice slice = make_slice(
      {40, 32, 24},
      [](double x, double y, double z) {
        return std::clamp(5.5 - std::hypot(x - 12, y - 20, z - 9), 0.0, 1.0);
      },
      "default", world);
  expect_box(seen_box(slice, shows_from(0.5)), {50, 21, 4}, {70, 51, 14}, 7);
}

// Points on no lattice: every sample of a slice as one, and next to nothing of a second row of them far away.
class Scattered final : public ScatteredField {
 public:
  void at(std::span<const Vec3>, std::span<float>, std::span<Vec3>) const override {}
  [[nodiscard]] bool splat(const ScatterSheet&) const override { return false; }
  void each_point(const std::function<void(const Vec3&, float, float)>& body) const override {
    for (int z = 0; z < 24; ++z)
      for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 40; ++x) {
          const double d = std::hypot(x - 12, y - 20, z - 9);
          body({x * 1.0, y * 1.0, z * 1.0}, d < 5.5 ? 1 : 0, 1);
        }
    for (int x = 0; x < 40; ++x) body({x * 1.0, 31, 23}, 1, 1e-4f);
  }
};

TEST(SeenBox, IsAroundScatteredPoints) {
  Slice slice = make_slice({40, 32, 24}, [](double, double, double) { return 0.0; });
  slice.scattered = std::make_shared<Scattered>();
  slice.bounds = {0, 1};
  slice.lattice_to_slice = {};
  expect_box(seen_box(slice, shows_from(0.5)), {7, 15, 4}, {17, 25, 14}, 2.5);
  expect_box(seen_box(slice, shows_from(2)), {0, 0, 0}, {39, 31, 23}, 0.75); // in cells of a half
}

} // namespace
} // namespace bccsplat

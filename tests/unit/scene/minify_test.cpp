// SPDX-License-Identifier: Apache-2.0
// Pictures smaller than the data: drawn from coarser levels of the slice.
#include "scene/minify.h"

#include <gtest/gtest.h>

#include <cstring>

#include "tests/support/larger.h"
#include "tests/support/splat_scene.h"

namespace bccsplat {
namespace {

using namespace test;

// Returns noise up to the band limit, fading towards the ends of the domain.
Slice noise(uint32_t n) {
  const PlaneWaves waves(24, 0.95, 3, 3);
  const double centre = (n - 1) / 2.0;
  return make_slice({n, n, n}, [&](double x, double y, double z) {
    const double r = std::hypot(x - centre, y - centre, z - centre) / centre;
    return std::exp(-4 * r * r) * (0.7 + 0.15 * waves({x, y, z, 0}));
  });
}

struct Small {
  TestContext context; // the levels are charged to its budget
  Slice slice;
  CoarseLevels levels;
  Scene scene;

  Small(uint32_t n, int size, double pixels_per_t) : slice(noise(n)) {
    Camera camera = fit_camera(slice, false, 20, 30, size, size);
    camera.ortho_height = size / pixels_per_t;
    scene = make_scene(slice, ramp_function(0.3, 1, 0.1), camera);
    scene.levels = &levels;
  }
  RenderStats draw(const RenderOptions& options, ImageStorage& out) {
    return render(scene, options, context.get(), out.image);
  }
};

// Returns the RMSE against the mean of the picture drawn `factor` times as large, over its largest value.
double error_of(Small& drawn, const RenderOptions& options, int size, int factor, RenderStats* stats) {
  ImageStorage small(size, size), large(factor * size, factor * size);
  *stats = drawn.draw(options, small);
  Scene fine = drawn.scene;
  fine.levels = nullptr;
  draw(fine, options, large);
  double sum = 0, most = 0;
  for (int j = 0; j < size; ++j)
    for (int i = 0; i < size; ++i) {
      double mean = 0;
      for (int y = 0; y < factor; ++y)
        for (int x = 0; x < factor; ++x)
          mean +=
              static_cast<double>(large.image.rgba.at(factor * i + x, factor * j + y)[0]) / (factor * factor);
      const double difference = small.image.rgba.at(i, j)[0] - mean;
      sum += difference * difference, most = larger(most, mean);
    }
  return std::sqrt(sum / (size * size)) / most;
}

TEST(Minify, FourTimesSmallerIsTheAreaAverageAtASixteenthOfThePoints) {
  const int size = 24;
  Small small(56, size, 0.25);
  RenderOptions o;
  o.mode = RenderMode::xray;
  RenderStats coarse, full;
  const double with = error_of(small, o, size, 8, &coarse);
  o.disable_skips = skip_fine_detail;
  const double without = error_of(small, o, size, 8, &full);
  EXPECT_EQ(coarse.level, 2);
  EXPECT_EQ(full.level, 0);
  EXPECT_LT(with, 0.03);
  EXPECT_LT(with, 0.8 * without); // which aliases
  EXPECT_LT(coarse.drawn.points_total * 16, full.drawn.points_total);
  // In classified pictures, what classification makes of fine detail is lost.
  o = {};
  EXPECT_LT(error_of(small, o, size, 8, &coarse), 0.06);
  EXPECT_EQ(coarse.level, 2);
}

TEST(Minify, EachLevelHoldsAboutAnEighth) {
  TestContext context;
  const Slice slice = noise(64);
  const CoarseLevels levels;
  int64_t before = slice.points();
  for (int n = 1; n <= 3; ++n) {
    const CoarseLevels::Level& level = levels.level(slice, n, context.get());
    EXPECT_LT(level.slice.points() * 5, before) << n;
    EXPECT_EQ(&level, &levels.level(slice, n, context.get()));
    before = level.slice.points();
  }
}

TEST(Minify, LargePicturesAreLeftAlone) {
  for (const double pixels : {2.0, 1.0, 0.6}) {
    Small small(24, 40, pixels);
    ImageStorage with(40, 40, true), without(40, 40, true);
    EXPECT_EQ(small.draw({}, with).level, 0);
    small.scene.levels = nullptr;
    small.draw({}, without);
    EXPECT_EQ(std::memcmp(with.rgba.data(), without.rgba.data(), with.rgba.size() * sizeof(float)), 0);
    EXPECT_EQ(std::memcmp(with.depth.data(), without.depth.data(), with.depth.size() * sizeof(float)), 0);
  }
}

TEST(Minify, TheAccurateSettingsKeepDetailAndMaximaStay) {
  Small small(40, 16, 0.3);
  ImageStorage out(16, 16);
  RenderOptions o;
  EXPECT_EQ(small.draw(o, out).level, 1);
  o.quality = Quality::fine;
  EXPECT_EQ(small.draw(o, out).level, 0);
  o.mode = RenderMode::xray;
  EXPECT_EQ(small.draw(o, out).level, 1);
  o.quality = Quality::draft;
  o.mode = RenderMode::maximum;
  EXPECT_EQ(small.draw(o, out).level, 0);
}

TEST(Minify, LevelsFollowThePixelAndEndWithTheLattice) {
  const Slice slice = noise(40);
  Camera camera = fit_camera(slice, false, 20, 30, 64, 64);
  const auto level = [&](double pixel) { // T
    camera.ortho_height = 64 * pixel;
    return minification_level(slice, camera, 64, 64);
  };
  const double unit = slice.lattice_to_slice.linear[0][0]; // T per lattice unit, just below 1
  EXPECT_EQ(level(0.5), 0);
  EXPECT_EQ(level(1.99 * unit), 0);
  EXPECT_EQ(level(2.01 * unit), 1);
  EXPECT_EQ(level(3.99 * unit), 1);
  EXPECT_EQ(level(4.01 * unit), 2);
  EXPECT_EQ(level(1e6), 3); // 56 planes: 28, 14, 7
  // The volume may be behind the camera or at its eye.
  camera = fit_camera(slice, true, 0, 0, 64, 64);
  camera.target = camera.position + (camera.position - camera.target);
  EXPECT_EQ(minification_level(slice, camera, 64, 64), 0);
}

TEST(Minify, AStepAskedForStaysTheSameLength) {
  Small small(40, 16, 0.45);
  ImageStorage out(16, 16);
  RenderOptions o;
  o.sheet_step = 0.8;
  const RenderStats coarse = small.draw(o, out);
  EXPECT_EQ(coarse.level, 1);
  EXPECT_DOUBLE_EQ(coarse.sheet_step, 0.8);
  o.disable_skips = skip_fine_detail;
  const RenderStats full = small.draw(o, out);
  EXPECT_NEAR(static_cast<double>(coarse.drawn.sheets), static_cast<double>(full.drawn.sheets), 2);
}

TEST(Minify, GoesByTheDirectionThatHasMostPixels) {
  // Along one diagonal of the picture a pixel is half a lattice unit long, along the other two.
  const Slice slice = make_slice({60, 60, 60}, [](double, double, double) { return 1; }, "default", {}, 0,
                                 LatticeKind::bcc, {0.5, 2, 0.5, 1});
  Camera camera = fit_camera(slice, false, 0, 0, 50, 50);
  camera.ortho_height = 50;
  camera.up = {1, 1, 0};
  EXPECT_EQ(minification_level(slice, camera, 50, 50), 0);
  camera.ortho_height = 4.2 * 50; // now 2.1 and 8.4
  EXPECT_EQ(minification_level(slice, camera, 50, 50), 1);
}

} // namespace
} // namespace bccsplat

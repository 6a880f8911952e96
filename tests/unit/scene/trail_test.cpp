// SPDX-License-Identifier: Apache-2.0
// Trails: their moments and weights, stills against sums of layers and slices, other hyperplanes, and what
// covers what.
#include "scene/trail.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/unit/scene/trail_picture.h"

namespace bccsplat {
namespace {

using namespace test;

class TrailBehind : public TrailPicture {
 protected:
  TrailBehind() : TrailPicture(13) {}
};

// A ball that lights up: between frames 11 and 13 it passes what is seen.
class TrailFlash : public TrailPicture {
 protected:
  TrailFlash()
      : TrailPicture(sample_field(Lattice4::fit(LatticeKind::d4star, {32, 16, 17, 24}), [](const Vec4& p) {
          return ball(p[0] - 16, p[1] - 8, p[2] - 8, 2.5) / (1 + std::exp(3 * (12 - p[3])));
        })) {}
};

TEST_F(TrailPicture, NoIntervalIsNoTrail) {
  const Slice s = still(11);
  EXPECT_TRUE(trail(s, {.interval = {0, 0}}).moments.empty());
  EXPECT_TRUE(trail(still(0), {.interval = {-5, 0}}).moments.empty()); // before the series
  EXPECT_EQ(draw(s, solid), draw(s, solid, {}));
}

TEST_F(TrailPicture, OneStillIsThatStill) {
  // A transparent slice and a trail of one still with all of the weight give the still's own picture.
  TransferFunction nothing = solid;
  nothing.opacities = {{0, 0}};
  const auto t = trail(still(11), {.interval = {-4, 0}, .samples = 1});
  ASSERT_EQ(t.moments.size(), 1u);
  EXPECT_EQ(t.moments[0].frame, 9);
  EXPECT_LT(largest_difference(draw(still(11), nothing, t), draw(still(9), thin)), 2e-5);
}

TEST_F(TrailPicture, WeightsSumToOneAndClipAtTheEnds) {
  for (const TrailContent content : {TrailContent::classified, TrailContent::mean, TrailContent::maximum}) {
    const auto t = trail(still(2), {.content = content, .interval = {-6, 1}, .samples = 3, .intervals = 2});
    double sum = 0;
    for (const TrailMoment& s : t.moments) {
      sum += s.weight;
      EXPECT_GE(s.frame, 0);
      EXPECT_LE(s.frame, 3);
    }
    EXPECT_NEAR(sum, 1, 1e-12);
    EXPECT_EQ(t.moments.front().interval, 0);
    EXPECT_EQ(t.moments.back().interval, 1);
  }
}

TEST_F(TrailPicture, ClassifiedConvergesWithTheStills) {
  const Slice s = still(20);
  const auto picture = [&](int n) { return draw(s, solid, trail(s, {.interval = {-12, 0}, .samples = n})); };
  const auto fine = picture(64);
  const double e8 = largest_difference(picture(8), fine), e16 = largest_difference(picture(16), fine);
  EXPECT_LT(e16, 0.6 * e8);
  EXPECT_LT(e16, 0.02);
}

TEST_F(TrailPicture, LayersMixedOnTheSheetsAreTheStills) {
  const Slice s = still(20);
  const Trail layers = trail(s, {.interval = {-12, 0}, .samples = 24, .intervals = 2});
  ASSERT_LT(layers.sources.size(), 48u);
  ASSERT_GT(layers.moments.front().shares.size(), 1u);
  const Trail stills = stills_of(layers, coefficients, context.get());
  for (const auto& [shading, gradient] :
       {std::pair{false, GradientMethod::analytic}, std::pair{true, GradientMethod::analytic},
        std::pair{true, GradientMethod::fourth_order}}) {
    options.shading = shading, options.gradient = gradient;
    std::vector<float> time, time_of_stills;
    const auto mixed = draw(s, solid, layers, TrailCombine::physical, &time);
    const auto drawn = draw(s, solid, stills, TrailCombine::physical, &time_of_stills);
    EXPECT_LT(largest_difference(mixed, drawn), shading ? 2e-3 : 2e-5);
    for (size_t p = 0; p < time.size(); ++p)
      if (drawn[4 * p + 3] > 0.01f) {
        EXPECT_NEAR(time[p], time_of_stills[p], 0.01);
      }
    options.disable_skips = 15;
    EXPECT_LT(largest_difference(mixed, draw(s, solid, layers)), 1e-6);
    options.disable_skips = 0;
  }
}

// Layers that alone are invisible are needed where their sum with later ones is not.
TEST_F(TrailFlash, NoLayerIsLeftOutForWhatItIsAlone) {
  TransferFunction nothing = solid;
  nothing.opacities = {{0, 0}};
  thin.opacities = {{0.3, 0}, {0.35, 0.5}};
  const Slice s = still(20);
  const Trail layers = trail(s, {.interval = {-10, -6}, .samples = 24});
  ASSERT_GT(layers.moments.front().shares.size(), 1u);
  const auto mixed = draw(s, nothing, layers);
  EXPECT_GT(at(mixed, 24, 12)[3], 0.1f);
  EXPECT_LT(largest_difference(mixed, draw(s, nothing, stills_of(layers, coefficients, context.get()))),
            1e-4);
  options.disable_skips =
      skip_transfer_function | skip_frustum | skip_occlusion | skip_empty_sheets | skip_cells;
  EXPECT_LT(largest_difference(mixed, draw(s, nothing, layers)), 1e-6);
}

// The mean of the field over the interval is compared with that of 128 slices.
TEST_F(TrailPicture, MeanIsTheMeanOfSlices) {
  const Trail t = trail(still(20), {.content = TrailContent::mean, .interval = {-9, 0}});
  ASSERT_EQ(t.sources.size(), 1u);
  std::vector<Vec3> points;
  for (const Vec4& p : test::random_points(samples.lattice(), 200, 1)) {
    const Vec3 unit = samples.lattice().lattice_unit();
    points.push_back({p[0] / unit[0], p[1] / unit[1], p[2] / unit[2]});
  }
  std::vector<float> mean(points.size()), at(points.size());
  std::vector<double> sum(points.size());
  (void)evaluate(t.sources[0].slice, points, mean, {});
  constexpr int slices = 128;
  for (int k = 0; k < slices; ++k) {
    (void)evaluate(still(11 + 9 * (k + 0.5) / slices), points, at, {});
    for (size_t n = 0; n < points.size(); ++n) sum[n] += static_cast<double>(at[n]) / slices;
  }
  for (size_t n = 0; n < points.size(); ++n) EXPECT_NEAR(mean[n], sum[n], 2e-4);
}

// A trail along any normal is the accumulation of classified slices of the same hyperplane, moved into the
// past, the future, or both. The slice itself is transparent.
TEST_F(TrailPicture, AnyHyperplane) {
  TransferFunction nothing = solid;
  nothing.opacities = {{0, 0}};
  camera.target = {10, 6, 9}, camera.position = {-20, 20, -40}, camera.ortho_height = 40;
  const Hyperplane planes[] = {{0, 0, 1, 0, -7}, {1, 0, 0, 0, -12.5}, {0.5, 0.5, 0.5, -0.5, -8}};
  for (const Hyperplane& h : planes) {
    const Slice s = hyperslice(coefficients, h, {}, {}, context.get());
    for (const std::array<double, 2> interval :
         {std::array{-4.0, 0.0}, std::array{0.0, 3.0}, std::array{-2.0, 2.0}}) {
      const Trail t = trail(s, {.interval = interval, .samples = 5});
      ASSERT_EQ(t.moments.size(), 5u);
      // The slices are drawn one by one, each with all the weight, for extinctions average.
      std::vector<double> sum(size_t{4} * width * height);
      double seen = 0;
      for (size_t m = 0; m < t.moments.size(); ++m) {
        const double offset = interval[0] + (static_cast<double>(m) + 0.5) / 5 * (interval[1] - interval[0]);
        const Slice moved = hyperslice(coefficients, h.moved(offset), {}, {}, context.get());
        const auto picture = draw(moved, thin);
        for (size_t p = 3; p < picture.size(); p += 4) {
          sum[p] += std::log1p(-std::min(static_cast<double>(picture[p]), 0.999999)) / 5;
          seen = std::max(seen, static_cast<double>(picture[p]));
        }
      }
      EXPECT_GT(seen, 0.2);
      const auto together = draw(s, nothing, t);
      for (size_t p = 3; p < together.size(); p += 4) EXPECT_NEAR(together[p], -std::expm1(sum[p]), 2e-3);
    }
    EXPECT_TRUE(trail(s, {.interval = {100, 200}}).moments.empty());
  }
}

TEST_F(TrailPicture, MeanAlongANormalIsTheMeanOfSlices) {
  const Hyperplane h{0.5, 0.5, 0.5, -0.5, -8};
  const Slice s = hyperslice(coefficients, h, {}, {}, context.get());
  const Trail t = trail(s, {.content = TrailContent::mean, .interval = {-2, 2}});
  ASSERT_EQ(t.sources.size(), 1u);
  std::vector<Vec3> points;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-10, 20);
  while (points.size() < 100) {
    const Vec3 p{uniform(random), uniform(random), uniform(random)};
    if (s.inside(s.lattice_to_slice.inverse().point(p))) points.push_back(p); // slice space
  }
  const auto values = [&](const Slice& slice) {
    std::vector<Vec3> at;
    for (const Vec3& p : points) at.push_back(slice.lattice_to_slice.inverse().point(p));
    std::vector<float> v(points.size());
    (void)evaluate(slice, at, v, {});
    return v;
  };
  const auto mean = values(t.sources[0].slice);
  constexpr int slices = 16;
  std::vector<double> sum(points.size());
  for (int k = 0; k < slices; ++k) {
    const double offset = -2 + 4 * (k + 0.5) / slices;
    const auto at =
        values(hyperslice(coefficients, {h[0], h[1], h[2], h[3], h[4] - offset}, {}, {}, context.get()));
    for (size_t n = 0; n < points.size(); ++n) sum[n] += static_cast<double>(at[n]) / slices;
  }
  for (size_t n = 0; n < points.size(); ++n)
    if (std::isfinite(sum[n])) {
      EXPECT_NEAR(mean[n], sum[n], 0.01);
    }
}

TEST_F(TrailPicture, ThinFastObjectsLeaveATrail) {
  const Slice s = still(20);
  const auto classified = draw(s, solid, trail(s, {.interval = {-18, 0}}));
  const float* left = at(classified, 12, 12); // the runner was there, about x = 8, in the beginning
  EXPECT_GT(left[1], 0.05f);
  EXPECT_EQ(left[0], 0.0f);
  const auto mean = draw(s, solid, trail(s, {.content = TrailContent::mean, .interval = {-18, 0}}));
  EXPECT_LT(at(mean, 12, 12)[1], left[1] / 2); // the mean of the field is below the threshold
  const auto maximum =
      draw(s, solid, trail(s, {.content = TrailContent::maximum, .interval = {-18, 0}, .samples = 18}));
  EXPECT_GT(at(maximum, 12, 12)[1], left[1]);
}

TEST_F(TrailPicture, InFrontItCoversTheObject) {
  const Slice s = still(20);
  const auto t = trail(s, {.interval = {-18, 0}});
  const float red = at(draw(s, solid), 24, 12)[0];
  EXPECT_GT(red, 0.8f);
  const auto physical = draw(s, solid, t);
  EXPECT_LT(at(physical, 24, 12)[0], red - 0.05f);
  EXPECT_GT(at(physical, 24, 12)[1], 0.05f);
}

// What the runner adds at the object's centre is seen by comparing the trail while it passes there with the
// trail when it is past.
TEST_F(TrailBehind, TheObjectHidesIt) {
  const Slice s = still(22);
  const auto passing = draw(s, solid, trail(s, {.interval = {-16, -10}}));
  const auto past = draw(s, solid, trail(s, {.interval = {-4, 0}}));
  for (size_t c = 0; c < 4; ++c) EXPECT_NEAR(at(passing, 24, 12)[c], at(past, 24, 12)[c], 0.01);
  EXPECT_GT(at(passing, 18, 12)[1], at(past, 18, 12)[1] + 0.04f); // beside the object it is seen
}

TEST_F(TrailPicture, PhysicalConvergesWithTheStep) {
  const Slice s = still(20);
  const auto t = trail(s, {.interval = {-10, 0}, .samples = 6});
  const auto picture = [&](double step, TrailCombine combine) {
    options.sheet_step = step;
    return draw(s, solid, t, combine);
  };
  const auto fine = picture(1.0 / 16, TrailCombine::physical);
  EXPECT_LT(largest_difference(picture(0.25, TrailCombine::physical), fine), 0.02);
  EXPECT_LT(largest_difference(picture(0.25, TrailCombine::physical), fine),
            0.4 * largest_difference(picture(1, TrailCombine::physical), fine));
  // As printed, the object lets more through, and the less so the thinner the sheets.
  float before = 1;
  for (const double step : {1.0, 0.5, 0.25}) {
    const float printed = 1 - at(picture(step, TrailCombine::interleaved), 24, 12)[3];
    EXPECT_LT(printed, 0.8f * before) << step;
    before = printed;
  }
}

// Equation (8) by hand where the slice is an isosurface: a field that rises along z passes the value at z =
// 7, in the middle one of three sheets, which stand for z = 0 to 4, 4 to 12 and 12 to 16. The trail has
// opacity 1/16 per unit everywhere and is green, the surface is red and opaque on its sheet and behind it.
class TrailRamp : public TrailPicture {
 protected:
  TrailRamp()
      : TrailPicture(sample_field(Lattice4::fit(LatticeKind::d4star, {32, 16, 17, 24}),
                                  [](const Vec4& p) { return 0.5 + 0.02 * (p[2] - 7); })) {
    options.sheet_step = 8;
    solid.colors = {{0, {1, 0, 0}}}, solid.opacities = {{0.5, 1}};
    thin.colors = {{0, {0, 1, 0}}}, thin.opacities = {{0, 0.0625}};
    thin.unit_distance = 1;
  }
};

TEST_F(TrailRamp, IsosurfacesAndTrailsAreJoinedByTheEquationAsPrinted) {
  options.mode = RenderMode::isosurface, options.iso_value = 0.5;
  const Slice s = still(12);
  const Trail t = trail(s, {.interval = {-4, 0}, .samples = 2});
  const auto opacity = [](double length) { return 1 - std::pow(1 - 0.0625, length); };
  const double before = opacity(4), middle = opacity(8), behind = opacity(4);
  double alpha = before / 2, red = 0, green = before / 2;
  red += (1 - alpha) / 2, green += (1 - alpha) * middle / 2, alpha += (1 - alpha) * (1 + middle) / 2;
  red += (1 - alpha) / 2, green += (1 - alpha) * behind / 2, alpha += (1 - alpha) * (1 + behind) / 2;
  for (const bool reference : {true, false}) {
    options.disable_skips = reference ? 127 : 0;
    const auto picture = draw(s, solid, t, TrailCombine::interleaved);
    EXPECT_NEAR(at(picture, 24, 12)[0], red, 2e-3);
    EXPECT_NEAR(at(picture, 24, 12)[1], green, 2e-3);
    EXPECT_NEAR(at(picture, 24, 12)[3], alpha, 2e-3);
  }
}

TEST_F(TrailPicture, IsosurfaceEndsTheTrail) {
  const Slice s = still(20);
  options.mode = RenderMode::isosurface;
  options.iso_value = 0.65;
  const auto front = draw(s, solid, trail(s, {.interval = {-18, 0}}));
  const float* p = at(front, 24, 12);
  EXPECT_NEAR(p[3], 1, 1e-5);
  EXPECT_GT(p[1], 0.05f); // what passed before it
  EXPECT_GT(p[0], 0.1f);  // the surface shines through
}

TEST_F(TrailPicture, MeanTimeOfAMovingBall) {
  TransferFunction nothing = solid;
  nothing.opacities = {{0, 0}};
  const Slice s = still(20);
  std::vector<float> time;
  (void)draw(s, nothing, trail(s, {.interval = {-18, 0}, .samples = 36}), TrailCombine::physical, &time);
  // The runner is at x = 5 + t; pixel i looks at x = 15.5 + (i + 0.5 - 24) / 1.5.
  for (const int i : {31, 33, 35}) {
    const double x = 15.5 + (i + 0.5 - 24) / 1.5;
    EXPECT_NEAR(time[12 * width + static_cast<size_t>(i)], x - 5, 0.4);
  }
}

TEST_F(TrailPicture, ThreadsAndTilesDoNotChangeABit) {
  const Slice s = still(20);
  const auto t = trail(s, {.interval = {-10, 0}, .samples = 40});
  options.shading = true;
  const auto one = draw(s, solid, t);
  options.tile_size = 17;
  EXPECT_EQ(one, draw(s, solid, t));
  options.tile_size = 0;
  TestContext alone(1), three(3);
  const auto with = [&](TestContext& c) {
    ImageStorage image(width, height);
    Scene scene;
    scene.slice = &s, scene.camera = camera, scene.function = solid;
    scene.trail = &t, scene.trail_functions = {thin};
    (void)render(scene, options, c.get(), image.image);
    return image.rgba;
  };
  EXPECT_EQ(with(alone), with(three));
}

// Rays of a perspective begin at other sheets in each tile.
TEST_F(TrailPicture, TilesAreLitAlike) {
  const Slice s = still(20);
  const auto t = trail(s, {.interval = {-10, 0}, .samples = 10});
  options.shading = true, options.sheet_step = 1;
  camera.perspective = true, camera.fovy_degrees = 25;
  camera.position = {30, -4, -16};
  solid.opacities = thin.opacities = {{0.05, 0}, {0.9, 0.25}}; // of segments that are lit by halves in part
  for (const TrailCombine combine : {TrailCombine::physical, TrailCombine::interleaved}) {
    options.tile_size = 0;
    const auto whole = draw(s, solid, t, combine);
    options.tile_size = 9;
    EXPECT_LT(largest_difference(whole, draw(s, solid, t, combine)), 2e-5);
  }
}

} // namespace
} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// What a file tells of the noise of its gradients, and that pictures of every mode follow it.
#include "render/gradient_noise.h"

#include <algorithm>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "render/trail.h"
#include "splat/shade/surface.h"
#include "tests/support/splat_scene.h"

namespace bccsplat {
namespace {

using namespace test;

TEST(GradientNoise, RippleIsAShareOfTheValueAndNoiseIsNot) {
  ValueSurvey s;
  s.kind = ValueKind::solid, s.object = 100;
  EXPECT_EQ(gradient_noise(s, 0, 0, 0.03).constant, 0);
  EXPECT_DOUBLE_EQ(gradient_noise(s, 0, 0, 0.03).of_value, 0.03);
  s.noise = 2;
  EXPECT_DOUBLE_EQ(gradient_noise(s, 0, 0, 0.02).constant, 6);
  // Rounding to a step is off by a standard deviation of step / sqrt(12), and so is a threshold.
  s.noise = 0;
  EXPECT_NEAR(gradient_noise(s, 1, 0, 0.02).constant, 3 / std::sqrt(12), 1e-3);
  EXPECT_NEAR(gradient_noise(s, 0, 2, 0.02).constant, 6 / std::sqrt(12), 2e-3);
}

TEST(GradientNoise, EdgesOfThreeVoxelsAreSurfaces) {
  ValueSurvey s;
  s.kind = ValueKind::solid, s.object = 100, s.noise = 20;
  EXPECT_EQ(surface_weight(100 / 3.0, gradient_noise(s, 0, 0, 0.02).constant), 1);
  // The boundary of a mask, and that between labels that are one apart, though all are rounded to 1.
  s = {};
  s.kind = ValueKind::labels, s.background = 0, s.labels = {2, 3, 7};
  EXPECT_EQ(surface_weight(1 / 3.0, gradient_noise(s, 1, 0, 0.02).constant), 1);
  s = {};
  s.kind = ValueKind::constant, s.object = 1;
  EXPECT_EQ(surface_weight(1 / 3.0, gradient_noise(s, 1, 0, 0.02).constant), 1);
}

// A constant field as kernels bring it back: gradients at random points, of which one in a hundred is larger.
TEST(GradientNoise, RippleIsThatOfTheKernel) {
  for (const char* name : {"fast", "default", "fine"}) {
    const Slice slice = make_slice(
        {20, 20, 20}, [](double, double, double) { return 1.0; }, name);
    ASSERT_TRUE(slice.lattice.bcc && slice.base == 0) << name;
    std::mt19937 random(7);
    std::uniform_real_distribution<double> at(8, 12);
    std::vector<Vec3> points(4000), gradients(points.size());
    for (Vec3& p : points) p = {at(random), at(random), at(random)};
    std::vector<float> values(points.size());
    field_at(SurfaceField(slice), points, values, gradients);
    std::vector<double> lengths;
    for (const Vec3& g : gradients) lengths.push_back(length(g));
    std::sort(lengths.begin(), lengths.end());
    const double expected = lengths[lengths.size() * 99 / 100];
    EXPECT_NEAR(ripple_gradient(slice.kernel, true), expected, 0.2 * expected) << name;
  }
  EXPECT_EQ(ripple_gradient(make_kernel("paper"), true), 0) << "divided by the lattice sum";
}

// A field that rises slowly and aslant to the view.
class WeakGradient : public testing::Test {
 protected:
  static constexpr int size = 24;
  WeakGradient()
      : slice(make_slice({20, 20, 20}, [](double x, double, double z) { return 0.5 + 0.02 * (x - z); })),
        scene(make_scene(slice, white(), fit_camera(slice, false, 0, 0, size, size))) {}
  static TransferFunction white() {
    TransferFunction f;
    f.colors = {{0, {0.5, 0.5, 0.5}}}, f.opacities = {{0, 0.4}};
    return f;
  }
  // The smallest and the largest light over opacity, well inside the domain.
  [[nodiscard]] std::array<float, 2> light(const RenderOptions& options) const {
    ImageStorage out(size, size);
    draw(scene, options, out);
    std::array<float, 2> range{1e30f, -1e30f};
    for (int y = 10; y < 15; ++y)
      for (int x = 10; x < 15; ++x) {
        const float* rgba = out.image.rgba.at(x, y);
        if (rgba[3] == 0) continue;
        range = {std::min(range[0], rgba[0] / rgba[3]), std::max(range[1], rgba[0] / rgba[3])};
      }
    return range;
  }
  void expect_follows(const RenderOptions& options, const char* what) {
    scene.lights.noise = {};
    EXPECT_LT(light(options)[1], 0.49f) << what; // the surface faces the light by 0.71
    scene.lights.noise = {0.1, 0};
    EXPECT_NEAR(light(options)[0], 0.5f, 1e-4f) << what;
    EXPECT_NEAR(light(options)[1], 0.5f, 1e-4f) << what;
    scene.lights.noise = {0, 0.1 / 0.2}; // as much, from the values
    EXPECT_NEAR(light(options)[0], 0.5f, 1e-4f) << what;
    EXPECT_NEAR(light(options)[1], 0.5f, 1e-4f) << what;
  }
  Slice slice;
  Scene scene;
};

TEST_F(WeakGradient, IsNoSurfaceInAnyMode) {
  RenderOptions o;
  o.shading = true;
  for (const auto method :
       {GradientMethod::analytic, GradientMethod::central, GradientMethod::fourth_order}) {
    o.gradient = method;
    for (const bool perspective : {false, true}) {
      scene.camera = fit_camera(slice, perspective, 0, 0, size, size);
      for (const Preintegrate p : {Preintegrate::off, Preintegrate::on}) {
        o.preintegrate = p;
        expect_follows(o, "composite");
      }
    }
  }
  o.mode = RenderMode::maximum;
  expect_follows(o, "maximum");
  o.mode = RenderMode::isosurface, o.iso_value = 0.5;
  expect_follows(o, "isosurface");
  o.reference = true;
  expect_follows(o, "isosurface of the reference");
  o.mode = RenderMode::composite;
  expect_follows(o, "composite of the reference");
}

TEST_F(WeakGradient, IsNoSurfaceInTrailsEither) {
  Trail trail;
  trail.bounds = slice.bounds;
  trail.moments = {{{{0, 1.0f}}, 0, 1, 0}};
  TrailSource source;
  TestContext context;
  source.slice = slice, source.points = make_points(slice, context.get());
  trail.sources.push_back(std::move(source));
  scene.trail = &trail, scene.trail_functions = {white()};
  RenderOptions o;
  for (const auto combine : {TrailCombine::physical, TrailCombine::post}) {
    scene.combine = combine;
    expect_follows(o, "trail");
  }
}

// The splatter and the reference weigh gradients alike.
TEST(GradientNoise, TheSplatterFollowsTheReference) {
  const Slice slice = make_slice({24, 20, 22}, marschner_lobb(24, 2));
  for (const bool perspective : {false, true}) {
    Scene scene =
        make_scene(slice, ramp_function(0.3, 1, 0.3), fit_camera(slice, perspective, 20, 30, 40, 36));
    scene.lights.lights.push_back({{1, 2, -1}, {0.3, 0.4, 0.5}});
    ImageStorage plain(40, 36), exact(40, 36), out(40, 36);
    RenderOptions o;
    o.quality = Quality::best, o.opacity_stop = 1;
    draw(scene, o, plain);
    scene.lights.noise = {0.02, 0.05};
    draw(scene, o, out);
    o.reference = true;
    draw(scene, o, exact);
    EXPECT_GT(compare(out, exact).db(), 40);
    EXPECT_LT(compare(plain, exact).db(), 35); // there is something to follow
  }
}

} // namespace
} // namespace bccsplat

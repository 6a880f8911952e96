// SPDX-License-Identifier: Apache-2.0
// What a file tells of the noise of its gradients, and that pictures of every mode follow it.
#include "shade/gradient_noise.h"

#include <algorithm>
#include <memory>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "scene/trail.h"
#include "shade/surface.h"
#include "tests/support/splat_scene.h"

namespace bccsplat {
namespace {

using namespace test;

TEST(GradientNoise, IsThatOfTheDataAndOfRounding) {
  ValueSurvey s;
  s.kind = ValueKind::solid, s.object = 100;
  s.noise = 3;
  EXPECT_DOUBLE_EQ(gradient_noise(s, 0, 0).constant, 9);
  s = {};
  s.kind = ValueKind::fog, s.mean = 100;
  EXPECT_EQ(gradient_noise(s, 0, 0).constant, 0);
  // Rounding makes terraces; a threshold is off by a standard deviation of itself / sqrt(12).
  EXPECT_DOUBLE_EQ(gradient_noise(s, 1, 0).constant, 2);
  EXPECT_NEAR(gradient_noise(s, 0, 2).constant, 6 / std::sqrt(12), 2e-3);
}

TEST(GradientNoise, HasTheRingingBehindTheEdgeOfASolid) {
  ValueSurvey s;
  s.kind = ValueKind::solid, s.background = 20, s.object = 120;
  EXPECT_DOUBLE_EQ(gradient_noise(s, 0, 0).constant, 4);
  s.kind = ValueKind::fog, s.mean = 100;
  EXPECT_EQ(gradient_noise(s, 0, 0).constant, 0) << "it may be as smooth as it likes";
}

TEST(GradientNoise, EdgesOfThreeVoxelsAreSurfaces) {
  ValueSurvey s;
  s.kind = ValueKind::solid, s.object = 100, s.noise = 20;
  EXPECT_EQ(surface_weight(100 / 3.0, gradient_noise(s, 0, 0).constant), 1);
  // The boundary of a mask, and that between labels that are one apart, though all are rounded to 1.
  s = {};
  s.kind = ValueKind::labels, s.background = 0, s.labels = {2, 3, 7};
  EXPECT_EQ(surface_weight(1 / 3.0, gradient_noise(s, 1, 0).constant), 1);
  s = {};
  s.kind = ValueKind::constant, s.object = 1;
  EXPECT_EQ(surface_weight(1 / 3.0, gradient_noise(s, 1, 0).constant), 1);
}

// A constant field as kernels bring it back: gradients at random points, of which one in a hundred is larger.
class Ripples : public testing::TestWithParam<const char*> {
 protected:
  [[nodiscard]] double found(const std::shared_ptr<const LatticeSums>& sums) const {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> at(8, 12);
    std::vector<Vec3> points(4000), gradients(points.size());
    for (Vec3& p : points) p = {at(random), at(random), at(random)};
    std::vector<float> values(points.size());
    const SurfaceField field(slice, sums);
    field_at(field, points, values, gradients);
    std::vector<double> lengths;
    for (size_t n = 0; n < points.size(); ++n)
      lengths.push_back(length(field.lit_gradient(points[n], values[n], gradients[n])));
    std::sort(lengths.begin(), lengths.end());
    return lengths[lengths.size() * 99 / 100];
  }
  const Slice slice = make_slice(
      {20, 20, 20}, [](double, double, double) { return 1.0; }, GetParam());
};

TEST_P(Ripples, AreThoseOfTheKernelAndSurfacesAreWithout) {
  ASSERT_TRUE(slice.lattice.bcc && slice.base == 0);
  const double with = found(nullptr);
  EXPECT_NEAR(ripple_gradient(slice), with, 0.2 * with);
  EXPECT_LT(found(lattice_sums(slice)), 0.15 * with);
  EXPECT_LT(ripple_of_differences(slice, KernelForm::flat_form), 0.4 * with);
  EXPECT_LE(ripple_of_differences(slice, KernelForm::exact), ripple_gradient(slice));
}

INSTANTIATE_TEST_SUITE_P(Kernels, Ripples, testing::Values("fast", "default", "fine"));

TEST(GradientNoise, HasNoRippleWhereNothingRipples) {
  const Slice paper = make_slice(
      {20, 20, 20}, [](double, double, double) { return 1.0; }, "paper");
  EXPECT_EQ(ripple_gradient(paper), 0) << "divided by the lattice sum";
  EXPECT_EQ(ripple_of_differences(paper, KernelForm::exact), 0);
  EXPECT_FALSE(lattice_sums(paper));
}

// A sphere in a slowly rising field far from the base is lit as what it is.
TEST(GradientNoise, SmoothSurfacesFarFromTheBaseAreLitSmoothly) {
  const Vec3 centre{15.5, 15.5, 15.5};
  const auto falling = [&](double x, double y, double z) {
    const Vec3 d = Vec3{x, y, z} - centre;
    return 20 - 0.02 * dot(d, d);
  };
  const Slice slice = make_slice({32, 32, 32}, falling);
  ASSERT_EQ(slice.base, 0);
  Scene scene = make_scene(slice, {}, fit_camera(slice, false, 20, 30, 96, 96));
  scene.function.colors = {{0, {1, 1, 1}}}, scene.function.opacities = {{0, 1}};
  ImageStorage lit(96, 96), rippled(96, 96), truth(96, 96), reference(96, 96);
  RenderOptions o;
  o.mode = RenderMode::isosurface, o.iso_value = 18, o.quality = Quality::best;
  TestContext context;
  const FieldAt field = [&](const Vec3& p, Vec3* gradient) {
    const Vec3 q = slice.lattice_to_slice.point(p);
    if (gradient) *gradient = slice.lattice_to_slice.transposed(-0.04 * (q - centre));
    return falling(q[0], q[1], q[2]);
  };
  (void)render_reference(scene, o, field, {1.0 / 32}, context.get(), truth.image);
  scene.noise_of_ripple = true;
  draw(scene, o, lit);
  o.without_ripple = false;
  draw(scene, o, rippled);
  o.without_ripple = true, o.reference = true;
  draw(scene, o, reference);
  EXPECT_GT(compare(lit, truth).db(), 24);
  EXPECT_GT(compare(reference, truth).db(), 24);
  EXPECT_LT(compare(rippled, truth).db(), 20) << "lit flat";
}

// Luminance over opacity of grey pixels that are seen.
struct Luminance {
  double mean = 0, rms = 0; // about the mean
};
Luminance luminance(const ImageStorage& picture) {
  double count = 0, sum = 0, squares = 0;
  for (size_t p = 0; p < picture.rgba.size(); p += 4) {
    const double alpha = picture.rgba[p + 3];
    if (alpha < 0.3) continue;
    const double l = picture.rgba[p] / alpha;
    count += 1, sum += l, squares += l * l;
  }
  const double mean = sum / count;
  return {mean, std::sqrt(std::max(squares / count - mean * mean, 0.0))};
}

constexpr int large_picture = 96,
              small_picture = 26; // of 32 voxels: by differences, by the kernel's gradient

// A smooth object far from the base is lit by its gradients, at every quality and size.
TEST(GradientNoise, EveryQualityLightsAlike) {
  const Slice slice = make_slice({32, 32, 32}, [](double x, double y, double z) {
    const Vec3 d = Vec3{x, y, z} - Vec3{15.5, 15.5, 15.5};
    return std::exp(-0.0006 * dot(d, d)); // its gradients are at most 0.03 of it
  });
  Scene scene = make_scene(slice, {}, {});
  scene.function.colors = {{0, {1, 1, 1}}}, scene.function.opacities = {{0.6, 0}, {1, 0.2}};
  scene.lights.specular = 0;
  for (const bool perspective : {false, true}) {
    std::vector<Luminance> all;
    for (const int size : {large_picture, small_picture})
      for (const auto quality : {Quality::draft, Quality::normal, Quality::fine, Quality::best}) {
        scene.camera = fit_camera(slice, perspective, 20, 30, size, size);
        scene.noise_of_ripple = true;
        RenderOptions o;
        o.quality = quality;
        ImageStorage out(size, size);
        draw(scene, o, out);
        all.push_back(luminance(out));
      }
    for (const Luminance& l : all) {
      EXPECT_LT(l.mean, 0.9) << "lit as if it faced the light";
      EXPECT_NEAR(l.mean, all.front().mean, 0.03 * all.front().mean);
    }
  }
}

// What the kernel makes of a constant is no surface, at any quality and size.
TEST(GradientNoise, PlateausDoNotGlitter) {
  const Slice slice = make_slice({32, 32, 32}, [](double, double, double) { return 1.0; });
  Scene scene = make_scene(slice, {}, {});
  scene.function.colors = {{0, {1, 1, 1}}}, scene.function.opacities = {{0, 0.9}};
  scene.noise_of_ripple = true;
  for (const bool perspective : {false, true})
    for (const int size : {large_picture, small_picture}) {
      scene.camera = fit_camera(slice, perspective, 20, 30, size, size);
      ImageStorage out(size, size);
      RenderOptions o;
      for (const auto quality : {Quality::draft, Quality::normal, Quality::fine, Quality::best}) {
        o.quality = quality;
        draw(scene, o, out);
        // Sheets that are not raised along the view have the waves between half a distance and theirs.
        const bool close = perspective && size == large_picture && quality == Quality::best;
        EXPECT_LT(luminance(out).rms, close ? 0.007 : 0.005)
            << size << perspective << static_cast<int>(quality);
      }
      if (size == large_picture) continue;
      o.without_ripple = false;
      draw(scene, o, out);
      EXPECT_GT(luminance(out).rms, 0.01) << "the sums have it";
    }
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
  expect_follows(o, "trail");
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

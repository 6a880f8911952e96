// SPDX-License-Identifier: Apache-2.0
// Trails of magnified pictures: the sheets of stills and layers are raised as a picture's own are.
#include <gtest/gtest.h>

#include "tests/support/larger.h"
#include "tests/unit/scene/trail_picture.h"

namespace bccsplat {
namespace {

using namespace test;

// At 3 pixels to a T, beyond 2, shaded sheets are raised.
class TrailRaised : public TrailPicture {
 protected:
  TrailRaised() {
    options.shading = true;
    camera.ortho_height = 8;
    nothing = solid, nothing.opacities = {{0, 0}};
  }
  // The other camera sees the middle at the same size.
  void look(bool perspective) {
    camera.perspective = perspective;
    camera.position[2] = perspective ? -12 : -50, camera.fovy_degrees = 22.6;
  }
  std::vector<float> draw_with(const Slice& slice, const Trail& trail, TestContext& with) {
    Scene scene;
    scene.slice = &slice, scene.camera = camera, scene.function = solid;
    scene.trail = &trail, scene.trail_functions = {thin};
    ImageStorage image(width, height);
    (void)render(scene, options, with.get(), image.image);
    return image.rgba;
  }
  // How much the trail of a single still, without the slice, differs from the picture of that still.
  double one_still_differs() {
    const Slice s = still(11), then = still(9);
    const auto t = trail(s, {.interval = {-4, 0}, .samples = 1});
    const auto picture = [&](const Slice& slice, const TransferFunction& function, const Trail* of) {
      Scene scene;
      scene.slice = &slice, scene.camera = camera, scene.function = function, scene.lights = lights;
      scene.trail = of, scene.trail_functions = {thin};
      ImageStorage image(width, height);
      (void)render(scene, options, context.get(), image.image);
      return image.rgba;
    };
    return largest_difference(picture(s, nothing, &t), picture(then, thin, nullptr));
  }
  TransferFunction nothing;
  Lights lights;
};

// Eight stills with a slice each, and forty that are mixed out of layers.
constexpr int both[] = {8, 40};

// Trails know the opacity in front of four sheets and not of each: they light some more segments in halves.
TEST_F(TrailRaised, OneStillIsThatStill) {
  EXPECT_LT(one_still_differs(), 1.0 / 255);
  lights.ambient = 1, lights.diffuse = lights.specular = 0;
  EXPECT_LT(one_still_differs(), 2e-5);
}

TEST_F(TrailRaised, IsAsAtThePixels) {
  const Slice s = still(20);
  for (const bool perspective : {false, true})
    for (const int count : both) {
      look(perspective);
      const auto t = trail(s, {.interval = {-12, 0}, .samples = count});
      ASSERT_EQ(t.moments.front().shares.size() > 1, count == 40);
      options.raise = RaiseFilter{};
      const auto at_pixels = draw(s, solid, t);
      options.raise.reset();
      const auto raised = draw(s, solid, t);
      const double difference = largest_difference(raised, at_pixels);
      EXPECT_GT(difference, 0);
      EXPECT_LT(difference, 0.01) << perspective << ' ' << count;
    }
}

// Extinctions average, so that the opacity follows from those of the stills, each integrated along the rays
// with all the weight.
TEST_F(TrailRaised, OpacityIsThatOfTheReference) {
  const Slice s = still(20);
  const auto t = trail(s, {.interval = {-12, 0}, .samples = 5});
  camera.ortho_height = 4; // the middle, still 3 pixels to a T
  const auto picture = [&](const Slice& slice, const TransferFunction& function, const Trail* of) {
    Scene scene;
    scene.slice = &slice, scene.camera = camera, scene.function = function;
    scene.trail = of, scene.trail_functions = {thin};
    ImageStorage image(width / 2, height / 2);
    (void)render(scene, options, context.get(), image.image);
    return image.rgba;
  };
  const auto raised = picture(s, nothing, &t);
  options.raise = RaiseFilter{};
  const auto at_pixels = picture(s, nothing, &t);
  options.reference = true;
  std::vector<double> depth(raised.size());
  for (const TrailMoment& m : t.moments) {
    const auto one = picture(still(m.frame), thin, nullptr);
    for (size_t p = 3; p < one.size(); p += 4)
      depth[p] -= m.weight * std::log1p(-static_cast<double>(one[p]));
  }
  double seen = 0, of_raised = 0, of_pixels = 0;
  for (size_t p = 3; p < depth.size(); p += 4) {
    const double opacity = -std::expm1(-depth[p]);
    seen = std::max(seen, opacity);
    of_raised = larger(of_raised, std::fabs(raised[p] - opacity));
    of_pixels = larger(of_pixels, std::fabs(at_pixels[p] - opacity));
  }
  EXPECT_GT(seen, 0.2);
  EXPECT_LT(of_raised, 0.01);
  EXPECT_LT(of_raised, 1.5 * of_pixels);
}

// A shell that stills cross within a step: by integrals the trail is what much finer sheets show.
TEST_F(TrailRaised, NarrowFunctionsArePreintegrated) {
  const Slice s = still(20);
  thin.opacities = {{0.2, 0}, {0.21, 0.6}, {0.22, 0}};
  options.shading = false;
  for (const int count : both) {
    const auto t = trail(s, {.interval = {-12, 0}, .samples = count});
    const auto with = [&](Preintegrate how, double step) {
      options.preintegrate = how, options.sheet_step = step;
      return draw(s, nothing, t);
    };
    const auto fine = with(Preintegrate::on, 1.0 / 16);
    const double off = largest_difference(with(Preintegrate::off, 0.5), fine),
                 on = largest_difference(with(Preintegrate::on, 0.5), fine);
    EXPECT_LT(on, 0.3 * off) << count;
    EXPECT_EQ(with(Preintegrate::automatic, 0.5), with(Preintegrate::on, 0.5)) << count;
  }
}

// One still by integrals is the picture of that moment by integrals.
TEST_F(TrailRaised, OneStillByIntegralsIsThatStill) {
  options.preintegrate = Preintegrate::on;
  EXPECT_LT(one_still_differs(), 1.0 / 255);
  lights.ambient = 1, lights.diffuse = lights.specular = 0;
  EXPECT_LT(one_still_differs(), 2e-5);
}

// Neither threads, tiles nor what is left out changes a bit.
TEST_F(TrailRaised, ThreadsAndTilesDoNotChangeABit) {
  const Slice s = still(20);
  TestContext alone(1), three(3);
  for (const Preintegrate how : {Preintegrate::off, Preintegrate::on})
    for (const bool perspective : {false, true})
      for (const bool shading : {true, false})
        for (const int count : both) {
          look(perspective);
          options.shading = shading, options.preintegrate = how;
          const auto t = trail(s, {.interval = {-10, 0}, .samples = count});
          const auto one = draw_with(s, t, alone);
          EXPECT_EQ(one, draw_with(s, t, three));
          options.tile_size = 17;
          EXPECT_EQ(one, draw_with(s, t, alone));
          options.disable_skips = 255;
          EXPECT_EQ(one, draw_with(s, t, alone));
          options.tile_size = 0, options.disable_skips = 0;
        }
}

// A surface closes pixels; what lies behind it is left out, and no more than that.
TEST_F(TrailRaised, SurfacesHideWhatIsBehindThem) {
  const Slice s = still(16);
  const auto t = trail(s, {.interval = {-12, 2}, .samples = 8});
  options.mode = RenderMode::isosurface, options.iso_value = 0.4, options.opacity_stop = 0.995;
  for (const double size : {8.0, 16.0}) { // raised, and at the pixels
    camera.ortho_height = size;
    const auto hidden = draw(s, solid, t);
    options.disable_skips = skip_occlusion;
    EXPECT_EQ(hidden, draw(s, solid, t));
    options.disable_skips = 0;
  }
}

// Where memory is short, tiles are smaller and no points are copied, but the picture is the same.
TEST_F(TrailRaised, ShortMemoryDoesNotChangeABit) {
  const Slice s = still(20);
  const auto t = trail(s, {.interval = {-10, 0}, .samples = 40});
  TestContext ample(1);
  const auto picture = draw_with(s, t, ample);
  TestContext tight(1, ample.memory.peak() - 1); // the larger tiles do not fit
  EXPECT_EQ(picture, draw_with(s, t, tight));
}

} // namespace
} // namespace bccsplat

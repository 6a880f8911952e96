// SPDX-License-Identifier: Apache-2.0
// A slice and what moved in one picture, by the GPU's two entries against the CPU, 45 dB at least: each rule
// of combining, stills and means, surfaces and pictures of their own; what is sent, and what is refused.
#include "scene/trail.h"

#include <array>

#include "gpu/shader.h"
#include "tests/unit/gpu/both_pictures.h"

namespace bccsplat {
namespace {

using namespace test;

class GpuTrails : public BothPictures {
 protected:
  Trail trail_of(const Slice& s, const TrailOptions& o, bool later = true) {
    HypersliceOptions like;
    like.merge_later = later;
    return make_trail(series_.coefficients, s, o, like, {}, series_.context.get());
  }
  Scene scene_of(const Slice& s, const Trail& trail, bool perspective = true) {
    Scene scene =
        make_scene(s, ramp_function(0.3, 1, 0.5), fit_camera(s, perspective, 25, 40, pixels, pixels));
    scene.trail = &trail, scene.trail_functions = {ramp_function(0.05, 1, 0.7)};
    scene.drawers = &drawers_;
    return scene;
  }
  void TearDown() override {
    drawers_.forget();
    EXPECT_TRUE(!gpu_ || gpu_->bytes() == 0);
  }

  MovingCloud series_{LatticeKind::d4star};
  Drawers drawers_;
  const TrailOptions stills_{.interval = {-4, 0}, .samples = 20}; // enough for the CPU to mix layers
};

TEST_P(GpuTrails, StillsByEveryRule) {
  const Slice s = series_.cut(7.3, true);
  const Trail trail = trail_of(s, stills_);
  ASSERT_TRUE(trail.by_cpu);
  EXPECT_GT(trail.by_cpu->get(series_.context.get()).moments.front().shares.size(), 1u); // of layers
  for (const TrailCombine combine : {TrailCombine::physical, TrailCombine::interleaved}) {
    Scene scene = scene_of(s, trail, combine != TrailCombine::physical);
    scene.combine = combine;
    RenderOptions o;
    EXPECT_GT(differ(scene, o).db(), least_db) << static_cast<int>(combine);
    EXPECT_GT(alike(cpu->depth, gpu->depth, 0.1), 0.97) << static_cast<int>(combine);
    EXPECT_GT(alike(cpu->value, gpu->value, 0.01), 0.97) << static_cast<int>(combine);
    EXPECT_GT(alike(cpu->time, gpu->time, 0.02), 0.97) << static_cast<int>(combine);
    o.shading = false;
    EXPECT_GT(differ(scene, o).db(), least_db + 10) << static_cast<int>(combine);
    const std::unique_ptr<ImageStorage> with = std::move(gpu);
    scene.trail = nullptr;
    (void)differ(scene, o);
    EXPECT_LT(compare(*with, *gpu).db(), 30); // so that the trail is seen
  }
}

// Narrow functions are classified by integrals.
TEST_P(GpuTrails, StillsByIntegrals) {
  const Slice s = series_.cut(7.3, true);
  const Trail trail = trail_of(s, stills_);
  Scene scene = scene_of(s, trail);
  scene.trail_functions[0].opacities = {{0.3, 0}, {0.31, 0.9}, {0.32, 0}};
  scene.function.opacities = {{0.6, 0}, {0.6, 0.8}};
  RenderOptions o;
  o.shading = false;
  EXPECT_GT(differ(scene, o).db(), least_db);
}

// A mean for each of several sub-intervals, tinted; the layers of all come to the GPU once.
TEST_P(GpuTrails, MeansOfSubIntervals) {
  const Slice s = series_.cut(7.3, true);
  const Trail trail = trail_of(s, {.content = TrailContent::mean, .interval = {-5, 1}, .intervals = 3});
  ASSERT_EQ(trail.moments.size(), 3u);
  Scene scene = scene_of(s, trail);
  scene.trail_functions.resize(3, scene.trail_functions.front());
  for (int n = 0; n < 3; ++n)
    scene.trail_functions[static_cast<size_t>(n)] =
        tinted(scene.trail_functions[static_cast<size_t>(n)], ramp_color(n, 3));
  RenderOptions o;
  EXPECT_GT(differ(scene, o).db(), least_db);
  o.backend = Backend::gpu, o.gpu = gpu_;
  ImageStorage image(pixels, pixels);
  EXPECT_EQ(draw(scene, o, image).drawn.bytes_sent, 0u); // all was there
  for (const TrailSource& source : trail.sources) {
    ASSERT_TRUE(source.slice.coset.moment());
    EXPECT_FALSE(source.slice.coset.moment()->is_merged());
  }
}

TEST_P(GpuTrails, BehindSurfaces) {
  const Slice s = series_.cut(7.3, true);
  const Trail trail = trail_of(s, stills_);
  RenderOptions o;
  o.mode = RenderMode::isosurface, o.iso_value = 0.5;
  (void)differ(scene_of(s, trail), o);
  EXPECT_GT(db_but_grazes(*cpu, *gpu), least_db);
  EXPECT_GT(alike(cpu->depth, gpu->depth, 0.1), 0.97);
  EXPECT_GT(alike(cpu->value, gpu->value, 0.01), 0.97);
}

// Hyperplanes beside one that is none of time are slices of their own.
TEST_P(GpuTrails, OfOtherHyperplanes) {
  HypersliceOptions like;
  const Slice s =
      hyperslice(series_.coefficients, Hyperplane(0.6, 0, 0, 0.8, -9.0), like, {}, series_.context.get());
  ASSERT_FALSE(s.empty());
  const Trail trail = make_trail(series_.coefficients, s, {.interval = {-2, 0}, .samples = 3}, like, {},
                                 series_.context.get());
  ASSERT_EQ(trail.moments.size(), 3u);
  RenderOptions o;
  o.shading = false;
  EXPECT_GT(differ(scene_of(s, trail), o).db(), least_db);
}

TEST_P(GpuTrails, WhatIsRefusedIsNamed) {
  const Slice s = series_.cut(7.3, true);
  const Trail trail = trail_of(s, stills_);
  Scene scene = scene_of(s, trail);
  RenderOptions o;
  o.backend = Backend::gpu, o.gpu = gpu_;
  ImageStorage image(pixels, pixels);
  const auto picture = [&] { (void)draw(scene, o, image); };
  o.mode = RenderMode::isosurface, o.iso_value = 0.5, scene.combine = TrailCombine::interleaved;
  EXPECT_NE(refusal(picture, Code::unsupported).find("a surface that rays go through"), std::string::npos);
  o.mode = RenderMode::composite;
  const Trail layers = trail_of(s, stills_, false);
  scene.trail = &layers;
  EXPECT_NE(refusal(picture, Code::unsupported).find("mixed sheet by sheet"), std::string::npos);
  const Trail many = trail_of(s, {.interval = {-4, 0}, .samples = most_gpu_objects});
  scene.trail = &many;
  EXPECT_NE(refusal(picture, Code::unsupported).find("so many stills"), std::string::npos);
  o.backend = Backend::automatic; // the CPU draws it
  EXPECT_EQ(refusal(picture, Code::ok), "");
}

// Where a GPU fails that nobody insists on the CPU draws its own trail.
TEST_P(GpuTrails, TheCpuDrawsWhatFails) {
  const Slice s = series_.cut(7.3, true), now = series_.cut(7.3, false);
  const Trail later = trail_of(s, stills_), layers = trail_of(now, stills_, false);
  gpu_ = test_gpu(GetParam(), 1000, true);
  RenderOptions o;
  o.gpu = gpu_, o.backend = Backend::automatic;
  ImageStorage image(pixels, pixels), by_cpu(pixels, pixels);
  const RenderStats stats = draw(scene_of(s, later), o, image);
  EXPECT_STREQ(stats.drawer, "sheets");
  EXPECT_NE(stats.gpu_failed.find("the limit of 1000"), std::string::npos) << stats.gpu_failed;
  o.backend = Backend::cpu;
  drawers_.forget();
  (void)draw(scene_of(now, layers), o, by_cpu);
  EXPECT_TRUE(same_bits(image, by_cpu));
}

INSTANTIATE_TEST_SUITE_P(Entries, GpuTrails, testing::Values(GpuEntry::compute, GpuEntry::fragment),
                         entry_name);

} // namespace
} // namespace bccsplat

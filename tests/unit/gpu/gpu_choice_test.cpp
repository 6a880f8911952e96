// SPDX-License-Identifier: Apache-2.0
// What draws: the GPU where it is asked for, with reasons where it does not; the CPU where it fails.
#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "base/error.h"
#include "tests/support/gpu.h"
#include "tests/support/splat_scene.h"

namespace bccsplat {
namespace {

using namespace test;

constexpr int size = 32;

class GpuChoice : public testing::Test {
 protected:
  void SetUp() override {
    gpu_ = test_gpu(GpuEntry::automatic);
    if (!gpu_) GTEST_SKIP() << "no GPU";
    slice_ = make_slice({30, 28, 26}, [](double x, double y, double z) {
      return std::max(0.0, 1 - std::hypot(x - 14, y - 13, z - 12) / 9);
    });
    scene_ = make_scene(slice_, ramp_function(0, 1, 0.4), fit_camera(slice_, false, 20, 30, size, size));
    options_.backend = Backend::gpu, options_.gpu = gpu_;
  }
  // What a picture is refused with.
  std::string refusal(Code code) {
    try {
      ImageStorage image(size, size);
      (void)draw(scene_, options_, image);
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), code);
      return e.message();
    }
    return "";
  }

  std::shared_ptr<GpuDevice> gpu_;
  Slice slice_;
  Scene scene_;
  RenderOptions options_;
};

TEST_F(GpuChoice, WhatItDoesNotDrawIsNamed) {
  options_.mode = RenderMode::isosurface, options_.smooth_edges = true;
  options_.surfaces = {{0.3, 0.5, {}}, {0.6, 1, {}}};
  EXPECT_NE(refusal(Code::unsupported).find("smooth edges of several surfaces"), std::string::npos);
  options_.backend = Backend::automatic; // the CPU draws it
  EXPECT_EQ(refusal(Code::ok), "");
  options_ = {}, options_.backend = Backend::gpu, options_.gpu = gpu_;
  slice_.kernel.space.radius = 3, scene_.slice = &slice_;
  EXPECT_NE(refusal(Code::unsupported).find("a kernel that wide"), std::string::npos);
}

// A rasteriser on the CPU is none that anybody wants unasked.
TEST_F(GpuChoice, AutomaticTakesCardsAlone) {
  options_.backend = Backend::automatic;
  ImageStorage image(size, size);
  const RenderStats stats = draw(scene_, options_, image);
  EXPECT_STREQ(stats.drawer, gpu_->info().software ? "sheets" : "gpu");
}

TEST_F(GpuChoice, SmallMemoryIsSaid) {
  gpu_ = test_gpu(GpuEntry::automatic, 1000);
  options_.gpu = gpu_;
  EXPECT_NE(refusal(Code::missing_feature).find("the limit of 1000 has 1000 left"), std::string::npos);
  EXPECT_EQ(gpu_->bytes(), 0u);
}

// Unasked it is tried picture by picture, and the CPU draws what it does not; what it does not draw at all is
// no failure.
TEST_F(GpuChoice, TheCpuDrawsWhatFails) {
  gpu_ = test_gpu(GpuEntry::automatic, 1000, true);
  options_.gpu = gpu_, options_.backend = Backend::automatic;
  ImageStorage image(size, size), cpu(size, size);
  for (int n = 0; n < 2; ++n) {
    const RenderStats stats = draw(scene_, options_, image);
    EXPECT_STREQ(stats.drawer, "sheets");
    EXPECT_NE(stats.gpu_failed.find("the limit of 1000"), std::string::npos) << stats.gpu_failed;
  }
  options_.backend = Backend::cpu;
  (void)draw(scene_, options_, cpu);
  EXPECT_TRUE(same_bits(image, cpu));

  gpu_ = test_gpu(GpuEntry::automatic, 0, true);
  options_.gpu = gpu_, options_.backend = Backend::automatic;
  EXPECT_STREQ(draw(scene_, options_, image).drawer, "gpu");
  options_.mode = RenderMode::isosurface, options_.smooth_edges = true, options_.surfaces = {{0.3, 0.5, {}}};
  const RenderStats stats = draw(scene_, options_, image);
  EXPECT_STREQ(stats.drawer, "sheets");
  EXPECT_EQ(stats.gpu_failed, "");
}

// Kept slices are counted, and given back.
TEST_F(GpuChoice, KeepsTwoSlices) {
  Drawers drawers;
  scene_.drawers = &drawers;
  ImageStorage image(size, size), again(size, size);
  (void)draw(scene_, options_, image);
  const uint64_t one = gpu_->bytes();
  EXPECT_GT(one, 0u);
  (void)draw(scene_, options_, again);
  EXPECT_EQ(gpu_->bytes(), one);
  EXPECT_TRUE(same_bits(image, again));
  const Slice other = slice_, third = slice_;
  for (const Slice* s : {&other, &third, &std::as_const(slice_)}) {
    scene_.slice = s;
    (void)draw(scene_, options_, again);
    EXPECT_EQ(gpu_->bytes(), 2 * one);
    EXPECT_TRUE(same_bits(image, again));
  }
  drawers.forget();
  EXPECT_EQ(gpu_->bytes(), 0u);
}

TEST_F(GpuChoice, IsCancelled) {
  Progress progress([](double) { return 1; });
  TestContext context(2);
  ImageStorage image(size, size);
  try {
    (void)render(scene_, options_, {context.get().tasks, context.get().memory, progress}, image.image);
    ADD_FAILURE();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), Code::cancelled);
  }
}

// What fails for good fails at once from then on; without being asked for the CPU draws.
TEST_F(GpuChoice, FailedOnceTheCpuDraws) {
  gpu_ = test_gpu(GpuEntry::automatic, 0, true), options_.gpu = gpu_;
  gpu_->give_up("gpu: lost");
  EXPECT_EQ(refusal(Code::missing_feature), "gpu: lost");
  options_.backend = Backend::automatic;
  ImageStorage image(size, size);
  EXPECT_STREQ(draw(scene_, options_, image).drawer, "sheets");
}

} // namespace
} // namespace bccsplat

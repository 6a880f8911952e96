// SPDX-License-Identifier: Apache-2.0
// Several volumes in one picture, by the GPU's two entries against the CPU, 45 dB at least: overlapping, one
// behind the other, of unlike spacing, with clips of their own.
#include "scene/together.h"

#include <array>

#include "tests/unit/gpu/both_pictures.h"

namespace bccsplat {
namespace {

using namespace test;

class GpuTogether : public BothPictures {
 protected:
  static Slice placed(const Vec3& at, double scale = 1, const char* kernel = "default") {
    Affine3 affine;
    affine.offset = at;
    for (size_t a = 0; a < 3; ++a) affine.linear[a][a] = scale;
    return make_slice({40, 36, 33}, ball(), kernel, affine);
  }
  static WorldCamera from_side(bool perspective) {
    WorldCamera c;
    c.perspective = perspective;
    c.forward = normalized(Vec3{1, 0.3, 0.4}), c.right = normalized(Vec3{0.4, 0, -1});
    c.up = cross(c.right, c.forward);
    c.position = Vec3{25, 18, 16} - 120.0 * c.forward;
    c.height = perspective ? 0.6 : 70;
    return c;
  }
  std::vector<Scene> scenes_of(const std::vector<const Slice*>& slices, bool perspective) {
    std::vector<Scene> out;
    for (const Slice* s : slices) {
      Scene scene = make_scene(*s, ramp_function(0.1, 1, 0.3), {});
      scene.sight = make_sight(from_side(perspective), pixels, pixels);
      scene.sight->sheets_meet = Vec3{25, 18, 16};
      scene.drawers = &drawers_;
      out.push_back(std::move(scene));
    }
    return out;
  }
  double db_of(const std::vector<Scene>& scenes, RenderOptions o) {
    TestContext context(2);
    cpu = std::make_unique<ImageStorage>(pixels, pixels, true),
    gpu = std::make_unique<ImageStorage>(pixels, pixels, true);
    o.backend = Backend::cpu;
    EXPECT_STREQ(render_together(scenes, o, context.get(), cpu->image).drawer, "sheets");
    o.backend = Backend::gpu, o.gpu = gpu_;
    EXPECT_STREQ(render_together(scenes, o, context.get(), gpu->image).drawer, "gpu");
    return compare(*cpu, *gpu).db();
  }
  void TearDown() override {
    drawers_.forget();
    EXPECT_TRUE(!gpu_ || gpu_->bytes() == 0);
  }
  Drawers drawers_;
};

TEST_P(GpuTogether, OverlappingAndBehindEachOther) {
  const Slice near = placed({0, 0, 0}), overlapping = placed({9, 4, 3}), behind = placed({45, 10, 18});
  for (const bool perspective : {false, true})
    for (const Slice* other : {&overlapping, &behind}) {
      std::vector<Scene> scenes = scenes_of({&near, other}, perspective);
      scenes[1].function.colors = {{0, {1, 0.1, 0.1}}};
      EXPECT_GT(db_of(scenes, {}), least_db) << perspective;
      EXPECT_GT(alike(cpu->depth, gpu->depth, 0.1), 0.97);
      RenderOptions o;
      o.shading = false;
      EXPECT_GT(db_of(scenes, o), least_db + 10) << perspective;
      std::swap(scenes[0], scenes[1]); // their order does not matter
      const std::unique_ptr<ImageStorage> one = std::move(gpu);
      EXPECT_GT(db_of(scenes, o), least_db + 10);
      EXPECT_GT(compare(*one, *gpu).db(), 80);
    }
}

TEST_P(GpuTogether, OfUnlikeSpacing) {
  const Slice fine = placed({0, 0, 0}), coarse = placed({10, -10, -5}, 1.7);
  RenderOptions o;
  o.shading = false;
  EXPECT_GT(db_of(scenes_of({&fine, &coarse}, true), o), least_db);
}

// A clip of one volume leaves the other whole.
TEST_P(GpuTogether, WithClipsOfTheirOwn) {
  const Slice a = placed({0, 0, 0}), b = placed({14, 4, 3});
  std::vector<Scene> scenes = scenes_of({&a, &b}, true);
  RenderOptions o;
  o.shading = false;
  (void)db_of(scenes, o);
  const std::unique_ptr<ImageStorage> whole = std::move(gpu);
  scenes[1].sight->clip = {{normalized(Vec3{0.2, 1, 0}), -22}};
  EXPECT_GT(db_of(scenes, o), least_db);
  EXPECT_LT(compare(*whole, *gpu).db(), 30);
}

// The host's depths end the rays of all.
TEST_P(GpuTogether, AgainstAHostsDepths) {
  const Slice a = placed({0, 0, 0}), b = placed({14, 4, 3});
  std::vector<Scene> scenes = scenes_of({&a, &b}, true);
  std::vector<float> depths(size_t{pixels} * pixels);
  for (size_t p = 0; p < depths.size(); ++p) depths[p] = 110 + static_cast<float>(p % pixels) / 4;
  for (Scene& s : scenes) s.sight->ends = {depths.data(), pixels};
  RenderOptions o;
  o.shading = false;
  EXPECT_GT(db_of(scenes, o), least_db);
}

TEST_P(GpuTogether, WhatIsRefusedIsNamed) {
  const Slice a = placed({0, 0, 0}), other = placed({9, 4, 3}, 1, "fine");
  TestContext context(2);
  ImageStorage image(pixels, pixels);
  RenderOptions o;
  o.backend = Backend::gpu, o.gpu = gpu_;
  std::vector<Scene> scenes = scenes_of({&a, &other}, false);
  const auto picture = [&] { (void)render_together(scenes, o, context.get(), image.image); };
  EXPECT_NE(refusal(picture, Code::unsupported).find("unlike kernels"), std::string::npos);
  scenes = scenes_of({&a, &a}, false);
  o.mode = RenderMode::isosurface, o.iso_value = 0.5;
  EXPECT_NE(refusal(picture, Code::unsupported).find("several instances in this mode"), std::string::npos);
  o.backend = Backend::automatic; // the CPU draws them
  EXPECT_EQ(refusal(picture, Code::ok), "");
}

// Unasked the CPU draws what a card has no room for, and says so.
TEST_P(GpuTogether, TheCpuDrawsWhatFails) {
  const Slice a = placed({0, 0, 0}), b = placed({9, 4, 3});
  const std::vector<Scene> scenes = scenes_of({&a, &b}, false);
  (void)db_of(scenes, {});
  gpu_ = test_gpu(GetParam(), 1000, true);
  RenderOptions o;
  o.backend = Backend::automatic, o.gpu = gpu_;
  TestContext context(2);
  ImageStorage image(pixels, pixels, true);
  const RenderStats stats = render_together(scenes, o, context.get(), image.image);
  EXPECT_STREQ(stats.drawer, "sheets");
  EXPECT_NE(stats.gpu_failed.find("the limit of 1000"), std::string::npos) << stats.gpu_failed;
  EXPECT_TRUE(same_bits(image, *cpu));
}

INSTANTIATE_TEST_SUITE_P(Entries, GpuTogether, testing::Values(GpuEntry::compute, GpuEntry::fragment),
                         entry_name);

} // namespace
} // namespace bccsplat

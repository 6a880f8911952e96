// SPDX-License-Identifier: Apache-2.0
// What may go wrong with a GPU, or last long: a lost context, a shader that its compiler refuses, a fork,
// devices beside each other, a thousand pictures.
#include <gtest/gtest.h>

#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <string>
#include <thread>
#include <vector>

#include "base/error.h"
#include "gpu/gl.h"
#include "gpu/gpu_programs.h"
#include "tests/support/gpu.h"
#include "tests/support/splat_scene.h"

namespace bccsplat {
namespace {

using namespace test;

constexpr int edge = 24;

class GpuRobust : public testing::TestWithParam<GpuEntry> {
 protected:
  void SetUp() override {
    gpu_ = test_gpu(GetParam(), 0, true);
    if (!gpu_) GTEST_SKIP() << "no GPU";
    slice_ = make_slice({30, 28, 26}, [](double x, double y, double z) {
      return std::max(0.0, 1 - std::hypot(x - 14, y - 13, z - 12) / 9);
    });
    scene_ = make_scene(slice_, ramp_function(0, 1, 0.4), fit_camera(slice_, false, 20, 30, edge, edge));
    options_.backend = Backend::gpu, options_.gpu = gpu_;
  }
  std::shared_ptr<GpuDevice> gpu_;
  Slice slice_;
  Scene scene_;
  RenderOptions options_;
};

TEST_P(GpuRobust, ALostContextIsTheCpusTurn) {
  Drawers drawers;
  scene_.drawers = &drawers;
  ImageStorage image(edge, edge), cpu(edge, edge);
  options_.backend = Backend::automatic;
  EXPECT_STREQ(draw(scene_, options_, image).drawer, "gpu");
  gpu_->run([] { next_gl_error = [] { return GLenum{GL_CONTEXT_LOST}; }; }); // of the device's thread
  const RenderStats lost = draw(scene_, options_, image);
  EXPECT_STREQ(lost.drawer, "sheets");
  EXPECT_NE(lost.gpu_failed.find("its context was lost"), std::string::npos) << lost.gpu_failed;
  const RenderStats after = draw(scene_, options_, image);
  EXPECT_STREQ(after.drawer, "sheets");
  EXPECT_EQ(after.gpu_failed, ""); // it is not tried again
  Scene fresh = scene_;
  fresh.drawers = nullptr;
  options_.backend = Backend::cpu;
  (void)draw(fresh, options_, cpu);
  EXPECT_TRUE(same_bits(image, cpu));
  drawers.forget();
  EXPECT_EQ(gpu_->bytes(), 0u);
}

TEST_P(GpuRobust, ARefusedShaderIsSaid) {
  gpu_->run([&] {
    ShaderKind kind;
    kind.entry = GetParam(), kind.kernel = make_kernel("default").space;
    EXPECT_NO_THROW((void)gpu_->programs().find(kind));
    kind.gather = "Sum gather(vec3 p) { return nonsense; }";
    try {
      (void)gpu_->programs().find(kind);
      ADD_FAILURE();
    } catch (const GpuFailure& e) {
      EXPECT_NE(e.message().find("its compiler refuses the shader"), std::string::npos);
      EXPECT_NE(e.message().find("nonsense"), std::string::npos) << e.message();
    }
  });
  ImageStorage image(edge, edge); // another one compiles
  EXPECT_STREQ(draw(scene_, options_, image).drawer, "gpu");
}

// Two devices, each used by two threads: every picture is the same.
TEST_P(GpuRobust, DevicesAndThreadsBesideEachOther) {
  const auto other = test_gpu(GetParam());
  ImageStorage alone(edge, edge);
  (void)draw(scene_, options_, alone);
  std::vector<std::unique_ptr<ImageStorage>> images;
  for (int n = 0; n < 4; ++n) images.push_back(std::make_unique<ImageStorage>(edge, edge));
  std::vector<std::thread> threads;
  for (size_t n = 0; n < images.size(); ++n)
    threads.emplace_back([&, n] {
      RenderOptions o = options_;
      o.gpu = n % 2 == 0 ? gpu_ : other;
      for (int turn = 0; turn < 5; ++turn) (void)draw(scene_, o, *images[n]);
    });
  for (std::thread& t : threads) t.join();
  for (const auto& image : images) EXPECT_TRUE(same_bits(*image, alone));
}

uint64_t resident_bytes() {
  uint64_t pages = 0;
  if (std::FILE* const file = std::fopen("/proc/self/statm", "r")) {
    if (std::fscanf(file, "%*u %lu", &pages) != 1) pages = 0;
    std::fclose(file);
  }
  return pages * static_cast<uint64_t>(::sysconf(_SC_PAGESIZE));
}

// Slices come and go, and with them what is on the GPU.
TEST_P(GpuRobust, AThousandPicturesLeaveNothing) {
  constexpr int pictures = 1000, warm = 50;
  constexpr uint64_t room = 32 << 20;
  ImageStorage image(8, 8);
  const std::array<Slice, 3> slices{slice_, slice_, slice_};
  uint64_t before = 0;
  {
    Drawers drawers;
    scene_.drawers = &drawers;
    for (int n = 0; n < pictures; ++n) {
      scene_.slice = &slices[static_cast<size_t>(n) % slices.size()];
      options_.mode = n % 2 == 0 ? RenderMode::composite : RenderMode::xray;
      ASSERT_STREQ(draw(scene_, options_, image, 1).drawer, "gpu");
      if (n == warm) before = resident_bytes();
    }
    EXPECT_LT(resident_bytes(), before + room);
  }
  EXPECT_EQ(gpu_->bytes(), 0u);
}

// In a fork's child the GPU says so, the CPU draws, and what the parent has is left alone.
TEST_P(GpuRobust, AForksChildIsTheCpus) {
  ImageStorage image(edge, edge);
  Drawers drawers;
  scene_.drawers = &drawers;
  (void)draw(scene_, options_, image, 1);
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    int wrong = 0;
    try {
      (void)draw(scene_, options_, image, 1);
      wrong = 1;
    } catch (const Error& e) {
      if (e.message().find("was forked") == std::string::npos) wrong = 2;
    }
    options_.backend = Backend::automatic;
    if (std::string("sheets") != draw(scene_, options_, image, 1).drawer) wrong = 3;
    drawers.forget();
    options_.gpu.reset(), gpu_.reset();
    ::_exit(wrong);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
  EXPECT_STREQ(draw(scene_, options_, image, 1).drawer, "gpu");
}

INSTANTIATE_TEST_SUITE_P(Entries, GpuRobust, testing::Values(GpuEntry::compute, GpuEntry::fragment),
                         [](const auto& p) { return p.param == GpuEntry::compute ? "compute" : "fragment"; });

} // namespace
} // namespace bccsplat

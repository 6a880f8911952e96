// SPDX-License-Identifier: Apache-2.0
// Pictures by a GPU through the C ABI: who draws is chosen by device and by picture, refusals say why, and a
// GPU that fails is told of once while the CPU draws.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "../../support/larger.h"
#include "../support.h"

using namespace host;

namespace {

constexpr uint32_t picture_width = 60, picture_height = 50;

struct Logged {
  std::vector<std::string> warnings;
  static void log(void* user, int32_t level, const char* message) {
    if (level == BCCSPLAT_LOG_WARNING) static_cast<Logged*>(user)->warnings.emplace_back(message);
  }
};

Device device_by(bccsplat_backend backend, uint64_t gpu_memory = 0, Logged* log = nullptr) {
  auto o = sized<bccsplat_device_options>();
  o.thread_count = 2, o.backend = backend, o.gpu_memory = gpu_memory;
  if (log) o.log = Logged::log, o.log_user = log;
  bccsplat_device* d = nullptr;
  EXPECT_OK(bccsplat_device_create(&o, &d));
  return Device(d);
}

class Gpu : public testing::Test {
 protected:
  void SetUp() override {
    device_ = device_by(BCCSPLAT_BACKEND_DEFAULT);
    info_ = sized<bccsplat_gpu_info>();
    if (bccsplat_device_get_gpu_info(device_.get(), &info_) == BCCSPLAT_OK) return;
    std::fprintf(stderr, "NOT TESTED, no GPU: %s\n", bccsplat_last_error());
    GTEST_SKIP() << "no GPU";
  }
  // A renderer of a slice of a small series.
  struct Drawn {
    Device device;
    Volume volume;
    Slice slice;
    Renderer renderer;
  };
  Drawn renderer_of(Device device) {
    Series s;
    s.nx = s.ny = s.nz = 26;
    const std::string file = folder_.file("s.bcc4");
    if (!std::filesystem::exists(file)) write_series(device, file, s);
    Volume volume = open(device, file);
    Slice slice = cut_time(volume, 1.5);
    bccsplat_renderer* created = nullptr;
    EXPECT_OK(bccsplat_renderer_create(device.get(), &created));
    EXPECT_OK(bccsplat_renderer_set_slice(created, slice.get()));
    return {std::move(device), std::move(volume), std::move(slice), Renderer(created)};
  }
  // Draws; returns the pixels, and what drew them.
  std::vector<float> draw(const Drawn& d, bccsplat_backend& by, bccsplat_status expected = BCCSPLAT_OK) {
    bccsplat_frame* created = nullptr;
    EXPECT_OK(bccsplat_frame_create(d.device.get(), picture_width, picture_height, 0, &created));
    const Frame frame(created);
    EXPECT_EQ(bccsplat_renderer_render(d.renderer.get(), created), expected) << bccsplat_last_error();
    if (expected != BCCSPLAT_OK) return {};
    auto stats = sized<bccsplat_render_stats>();
    EXPECT_OK(bccsplat_renderer_get_stats(d.renderer.get(), &stats));
    by = stats.backend;
    auto plane = sized<bccsplat_plane>();
    EXPECT_OK(bccsplat_frame_get_channel(created, BCCSPLAT_FRAME_RGBA, &plane));
    return {plane.pixels, plane.pixels + size_t{4} * picture_width * picture_height};
  }
  void ask(const Drawn& d, bccsplat_backend backend, bccsplat_mode mode = 0) {
    auto o = sized<bccsplat_render_options>();
    o.backend = backend, o.mode = mode;
    ASSERT_OK(bccsplat_renderer_set_options(d.renderer.get(), &o));
  }

  const Folder folder_;
  Device device_; // whose texts `info_` has
  bccsplat_gpu_info info_{};
  bccsplat_backend by_ = 0;
};

TEST_F(Gpu, IsToldByName) {
  EXPECT_NE(std::string(info_.renderer), "");
  EXPECT_NE(std::string(info_.version), "");
  EXPECT_TRUE(info_.software == 0 || info_.software == 1);
  EXPECT_EQ(info_.memory_used, 0u);
}

TEST_F(Gpu, DevicesAndPicturesChoose) {
  const Drawn asked = renderer_of(device_by(BCCSPLAT_BACKEND_GPU)),
              cpu = renderer_of(device_by(BCCSPLAT_BACKEND_CPU)),
              any = renderer_of(device_by(BCCSPLAT_BACKEND_DEFAULT));
  const std::vector<float> gpus = draw(asked, by_);
  EXPECT_EQ(by_, BCCSPLAT_BACKEND_GPU);
  const std::vector<float> cpus = draw(cpu, by_);
  EXPECT_EQ(by_, BCCSPLAT_BACKEND_CPU);
  double squares = 0, alpha = 0;
  for (size_t n = 0; n < gpus.size(); ++n)
    squares += std::pow(static_cast<double>(gpus[n]) - cpus[n], 2), alpha += n % 4 == 3 ? gpus[n] : 0;
  EXPECT_GT(alpha, 50);
  EXPECT_LT(std::sqrt(squares / static_cast<double>(gpus.size())), std::pow(10, -45.0 / 20));
  (void)draw(any, by_);
  EXPECT_EQ(by_, info_.software ? BCCSPLAT_BACKEND_CPU : BCCSPLAT_BACKEND_GPU);
  // A picture's choice is stronger.
  ask(cpu, BCCSPLAT_BACKEND_GPU);
  // A device merges moments on the GPU, in another order, where it is to draw by it.
  constexpr double rounding = 1e-4;
  EXPECT_LT(largest_difference(draw(cpu, by_), gpus), rounding);
  EXPECT_EQ(by_, BCCSPLAT_BACKEND_GPU);
  ask(asked, BCCSPLAT_BACKEND_CPU);
  EXPECT_LT(largest_difference(draw(asked, by_), cpus), rounding);
  ask(asked, BCCSPLAT_BACKEND_DEFAULT); // back to the device's
  EXPECT_EQ(draw(asked, by_), gpus);
}

TEST_F(Gpu, HoldsSlicesWhileTheRendererLooksAtThem) {
  const Drawn d = renderer_of(device_by(BCCSPLAT_BACKEND_GPU));
  (void)draw(d, by_);
  auto info = sized<bccsplat_gpu_info>();
  ASSERT_OK(bccsplat_device_get_gpu_info(d.device.get(), &info));
  EXPECT_GT(info.memory_used, 10000u);
  ASSERT_OK(bccsplat_renderer_set_slice(d.renderer.get(), nullptr));
  ASSERT_OK(bccsplat_device_get_gpu_info(d.device.get(), &info));
  EXPECT_EQ(info.memory_used, 0u);
}

TEST_F(Gpu, RefusesWhatItDoesNotDraw) {
  const Drawn d = renderer_of(device_by(BCCSPLAT_BACKEND_GPU));
  auto trail = sized<bccsplat_trail>();
  trail.interval[0] = -1;
  ASSERT_OK(bccsplat_renderer_set_trail(d.renderer.get(), &trail));
  (void)draw(d, by_);
  EXPECT_EQ(by_, BCCSPLAT_BACKEND_GPU);
  trail.intervals = 100;
  ASSERT_OK(bccsplat_renderer_set_trail(d.renderer.get(), &trail));
  (void)draw(d, by_, BCCSPLAT_ERROR_UNSUPPORTED);
  EXPECT_NE(std::string(bccsplat_last_error()).find("trail"), std::string::npos) << bccsplat_last_error();
  ask(d, BCCSPLAT_BACKEND_AUTO);
  (void)draw(d, by_);
  EXPECT_EQ(by_, BCCSPLAT_BACKEND_CPU);
}

TEST_F(Gpu, TooLittleMemoryIsRefusedWhereItIsAskedFor) {
  Logged log;
  const Drawn d = renderer_of(device_by(BCCSPLAT_BACKEND_GPU, 5000, &log));
  (void)draw(d, by_, BCCSPLAT_ERROR_MISSING_FEATURE);
  EXPECT_NE(std::string(bccsplat_last_error()).find("limit of 5000"), std::string::npos)
      << bccsplat_last_error();
  ask(d, BCCSPLAT_BACKEND_AUTO);
  for (int n = 0; n < 3; ++n) (void)draw(d, by_);
  EXPECT_EQ(by_, BCCSPLAT_BACKEND_CPU);
  EXPECT_EQ(log.warnings.size(), info_.software ? 0u : 1u); // a rasteriser was not tried
}

TEST_F(Gpu, AScenesStatusSaysWhoDrew) {
  const Drawn d = renderer_of(device_by(BCCSPLAT_BACKEND_GPU));
  bccsplat_scene* created = nullptr;
  ASSERT_OK(bccsplat_scene_create(d.device.get(), &created));
  const Handle<bccsplat_scene> scene(created);
  const auto instance = sized<bccsplat_instance>();
  uint64_t id = 0;
  ASSERT_OK(bccsplat_scene_add(created, d.volume.get(), &instance, &id));
  auto camera = sized<bccsplat_camera>();
  ASSERT_OK(bccsplat_scene_fit_camera(created, BCCSPLAT_PROJECTION_PERSPECTIVE, 20, 30, picture_width,
                                      picture_height, &camera));
  auto view = sized<bccsplat_view>();
  view.camera = &camera;
  bccsplat_frame* frame = nullptr;
  ASSERT_OK(
      bccsplat_frame_create(d.device.get(), picture_width, picture_height, BCCSPLAT_FRAME_DEPTH, &frame));
  const Frame held(frame);
  auto status = sized<bccsplat_scene_status>();
  ASSERT_OK(bccsplat_scene_render(created, &view, frame, nullptr, 0, &status));
  EXPECT_EQ(status.backend, BCCSPLAT_BACKEND_GPU);
  ASSERT_OK(bccsplat_scene_add(created, d.volume.get(), &instance, &id)); // two are drawn together
  ASSERT_OK(bccsplat_scene_render(created, &view, frame, nullptr, 0, &status));
  EXPECT_EQ(status.backend, BCCSPLAT_BACKEND_GPU);
  auto lights = sized<bccsplat_lights>(); // but not with light through what is there
  lights.occlusion = 1;
  ASSERT_OK(bccsplat_scene_set_lights(created, &lights));
  EXPECT_EQ(bccsplat_scene_render(created, &view, frame, nullptr, 0, &status), BCCSPLAT_ERROR_UNSUPPORTED);
  auto o = sized<bccsplat_render_options>();
  o.backend = BCCSPLAT_BACKEND_AUTO;
  ASSERT_OK(bccsplat_scene_render(created, &view, frame, &o, 0, &status));
  EXPECT_EQ(status.backend, BCCSPLAT_BACKEND_CPU);
}

TEST(GpuOptions, AreChecked) {
  auto o = sized<bccsplat_device_options>();
  bccsplat_device* device = nullptr;
  o.backend = 4;
  EXPECT_EQ(bccsplat_device_create(&o, &device), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  EXPECT_NE(std::string(bccsplat_last_error()).find("bccsplat_device_options.backend"), std::string::npos);
  o.backend = 0, o.reserved2 = 1;
  EXPECT_EQ(bccsplat_device_create(&o, &device), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  const Device made = make_device();
  bccsplat_renderer* created = nullptr;
  ASSERT_OK(bccsplat_renderer_create(made.get(), &created));
  const Renderer renderer(created);
  auto r = sized<bccsplat_render_options>();
  r.backend = -1;
  EXPECT_EQ(bccsplat_renderer_set_options(created, &r), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(bccsplat_device_get_gpu_info(nullptr, nullptr), BCCSPLAT_ERROR_INVALID_ARGUMENT);
}

} // namespace

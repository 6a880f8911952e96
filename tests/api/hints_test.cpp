// SPDX-License-Identifier: Apache-2.0
// The log tells, once per device, of what a host hardly meant.
#include "support.h"

namespace host {
namespace {

struct HintLog {
  std::vector<std::string> warnings;
  static void add(void* user, bccsplat_log_level level, const char* message) {
    if (level == BCCSPLAT_LOG_WARNING) static_cast<HintLog*>(user)->warnings.emplace_back(message);
  }
  [[nodiscard]] size_t of(const std::string& word) const {
    size_t count = 0;
    for (const std::string& w : warnings) count += w.find(word) != std::string::npos ? 1 : 0;
    return count;
  }
};

class Hints : public testing::Test {
 protected:
  void SetUp() override {
    auto o = sized<bccsplat_device_options>();
    o.thread_count = 1, o.log = HintLog::add, o.log_user = &log_;
    bccsplat_device* d = nullptr;
    ASSERT_OK(bccsplat_device_create(&o, &d));
    device_.reset(d);
    bccsplat_renderer* r = nullptr;
    ASSERT_OK(bccsplat_renderer_create(d, &r));
    renderer_.reset(r);
    camera_.projection = BCCSPLAT_PROJECTION_PERSPECTIVE;
    camera_.position[2] = -10, camera_.up[1] = 1;
  }
  HintLog log_;
  Device device_;
  Renderer renderer_;
  bccsplat_camera camera_ = sized<bccsplat_camera>();
};

TEST_F(Hints, AnAngleInRadians) {
  camera_.fovy_degrees = 30;
  ASSERT_OK(bccsplat_renderer_set_camera(renderer_.get(), &camera_));
  auto flat = camera_;
  flat.projection = BCCSPLAT_PROJECTION_ORTHOGRAPHIC, flat.fovy_degrees = 0.7, flat.ortho_height = 3;
  ASSERT_OK(bccsplat_renderer_set_camera(renderer_.get(), &flat));
  EXPECT_TRUE(log_.warnings.empty());
  camera_.fovy_degrees = 0.785;
  auto view = sized<bccsplat_view>();
  view.camera = &camera_;
  for (int n = 0; n < 3; ++n) {
    ASSERT_OK(bccsplat_renderer_set_camera(renderer_.get(), &camera_));
    ASSERT_OK(bccsplat_renderer_set_view(renderer_.get(), &view));
  }
  EXPECT_EQ(log_.of("radians"), 1u);
  EXPECT_EQ(log_.warnings.size(), 1u);
}

TEST_F(Hints, SurfacesOfAnotherMode) {
  bccsplat_iso_surface surface{};
  surface.value = 20, surface.opacity = 1;
  auto options = sized<bccsplat_render_options>();
  options.surfaces = &surface, options.surface_count = 1, options.mode = BCCSPLAT_MODE_ISOSURFACE;
  ASSERT_OK(bccsplat_renderer_set_options(renderer_.get(), &options));
  EXPECT_TRUE(log_.warnings.empty());
  options.mode = BCCSPLAT_MODE_DEFAULT;
  for (int n = 0; n < 3; ++n) ASSERT_OK(bccsplat_renderer_set_options(renderer_.get(), &options));
  EXPECT_EQ(log_.of("BCCSPLAT_MODE_ISOSURFACE"), 1u);
}

TEST_F(Hints, ScenesGiveThemAsWell) {
  const Folder folder;
  write_series(device_, folder.file("s.bcc4"));
  const Volume volume = open(device_, folder.file("s.bcc4"));
  log_.warnings.clear();
  bccsplat_scene* created = nullptr;
  ASSERT_OK(bccsplat_scene_create(device_.get(), &created));
  const Handle<bccsplat_scene> scene(created);
  uint64_t id = 0;
  ASSERT_OK(bccsplat_scene_add(created, volume.get(), nullptr, &id));
  bccsplat_frame* f = nullptr;
  ASSERT_OK(bccsplat_frame_create(device_.get(), 16, 16, 0, &f));
  const Frame frame(f);
  bccsplat_iso_surface surface{};
  surface.value = 20, surface.opacity = 1;
  auto options = sized<bccsplat_render_options>();
  options.surfaces = &surface, options.surface_count = 1;
  camera_.fovy_degrees = 1;
  auto view = sized<bccsplat_view>();
  view.camera = &camera_;
  for (int n = 0; n < 2; ++n) ASSERT_OK(bccsplat_scene_render(created, &view, f, &options, 0, nullptr));
  EXPECT_EQ(log_.of("radians"), 1u);
  EXPECT_EQ(log_.of("surfaces"), 1u);
}

} // namespace
} // namespace host

// SPDX-License-Identifier: Apache-2.0
// What is refused before it begins leaves frames as they were, and says why in words of the header.
#include <limits>

#include "support.h"

namespace host {
namespace {

class RefusedPicture : public testing::Test {
 protected:
  static constexpr uint32_t size = 24;
  Folder folder_;
  Device device_ = make_device();
  Volume volume_;
  Slice slice_;
  Renderer renderer_;
  Frame frame_;

  void SetUp() override {
    (void)write_series(device_, folder_.file("s.bcc4"));
    volume_ = open(device_, folder_.file("s.bcc4"));
    slice_ = cut_time(volume_, 3);
    bccsplat_renderer* r = nullptr;
    ASSERT_OK(bccsplat_renderer_create(device_.get(), &r));
    renderer_ = Renderer(r);
    ASSERT_OK(bccsplat_renderer_set_slice(r, slice_.get()));
    bccsplat_frame* f = nullptr;
    ASSERT_OK(
        bccsplat_frame_create(device_.get(), size, size, BCCSPLAT_FRAME_RGBA | BCCSPLAT_FRAME_DEEP, &f));
    frame_ = Frame(f);
  }

  // Pixels and deep samples, and the file, which has camera and attributes.
  struct Held {
    std::vector<float> pixels, samples;
    std::vector<uint8_t> file;
    bool operator==(const Held& o) const {
      return pixels == o.pixels && samples == o.samples && file == o.file;
    }
  };
  [[nodiscard]] Held held() const {
    Held h;
    auto plane = sized<bccsplat_plane>();
    EXPECT_OK(bccsplat_frame_get_channel(frame_.get(), BCCSPLAT_FRAME_RGBA, &plane));
    h.pixels.assign(plane.pixels, plane.pixels + size_t{4} * size * size);
    auto deep = sized<bccsplat_deep>();
    EXPECT_OK(bccsplat_frame_get_deep(frame_.get(), &deep));
    if (deep.samples) h.samples.assign(deep.samples, deep.samples + deep.sample_count * deep.components);
    h.file.resize(1 << 20);
    uint64_t bytes = 0;
    EXPECT_OK(bccsplat_frame_save_memory(frame_.get(), BCCSPLAT_IMAGE_EXR, nullptr, h.file.data(),
                                         h.file.size(), &bytes));
    h.file.resize(bytes);
    return h;
  }
  [[nodiscard]] bccsplat_status render() { return bccsplat_renderer_render(renderer_.get(), frame_.get()); }
  void set(const bccsplat_render_options& o) {
    ASSERT_OK(bccsplat_renderer_set_options(renderer_.get(), &o));
  }
};

TEST_F(RefusedPicture, LeavesTheFrame) {
  ASSERT_OK(render());
  const Held before = held();
  ASSERT_GT(before.samples.size(), 0u);
  const auto expect_refused = [&](bccsplat_status status, const char* why) {
    EXPECT_EQ(render(), status) << why;
    EXPECT_TRUE(held() == before) << why;
  };
  auto o = sized<bccsplat_render_options>();
  o.mode = BCCSPLAT_MODE_XRAY;
  set(o);
  expect_refused(BCCSPLAT_ERROR_UNSUPPORTED, "deep samples of an X-ray");
  o = sized<bccsplat_render_options>();
  o.reference = 1;
  set(o);
  expect_refused(BCCSPLAT_ERROR_UNSUPPORTED, "deep samples of the reference");
  bccsplat_cancel_token* t = nullptr;
  ASSERT_OK(bccsplat_cancel_token_create(&t));
  const Handle<bccsplat_cancel_token> token(t);
  ASSERT_OK(bccsplat_cancel_token_cancel(t));
  o = sized<bccsplat_render_options>();
  o.cancel_token = t;
  set(o);
  expect_refused(BCCSPLAT_CANCELLED, "cancelled before");
  set(sized<bccsplat_render_options>());
  auto camera = sized<bccsplat_camera>();
  camera.position[2] = -1e20, camera.up[1] = 1, camera.ortho_height = 40;
  ASSERT_OK(bccsplat_renderer_set_camera(renderer_.get(), &camera));
  expect_refused(BCCSPLAT_ERROR_INVALID_ARGUMENT, "a camera that is too far away");
  ASSERT_OK(bccsplat_renderer_set_camera(renderer_.get(), nullptr));
  ASSERT_OK(bccsplat_renderer_set_slice(renderer_.get(), nullptr));
  expect_refused(BCCSPLAT_ERROR_WRONG_STATE, "no slice");
}

TEST_F(RefusedPicture, WhatIsCancelledWhileItIsDrawnLosesTheSamplesAlone) {
  ASSERT_OK(render());
  auto o = sized<bccsplat_render_options>();
  o.progress = [](void*, double) { return 1; };
  set(o);
  EXPECT_EQ(render(), BCCSPLAT_CANCELLED);
  auto deep = sized<bccsplat_deep>();
  EXPECT_EQ(bccsplat_frame_get_deep(frame_.get(), &deep), BCCSPLAT_ERROR_WRONG_STATE);
}

// A perspective camera within the volume has nothing behind it.
TEST_F(RefusedPicture, DeepSamplesAreInFrontOfACameraInTheVolume) {
  auto o = sized<bccsplat_render_options>();
  o.opacity_stop = 1;
  set(o);
  auto camera = sized<bccsplat_camera>();
  camera.projection = BCCSPLAT_PROJECTION_PERSPECTIVE, camera.fovy_degrees = 50, camera.up[1] = 1;
  size_t samples = 0;
  for (const double z : {8.0, 8.7, 9.1, 9.35}) {
    camera.position[0] = camera.target[0] = 9.3, camera.position[1] = camera.target[1] = 10;
    camera.position[2] = z, camera.target[2] = 17;
    ASSERT_OK(bccsplat_renderer_set_camera(renderer_.get(), &camera));
    ASSERT_OK(render());
    auto deep = sized<bccsplat_deep>();
    ASSERT_OK(bccsplat_frame_get_deep(frame_.get(), &deep));
    for (uint64_t i = 0; i < deep.sample_count; ++i)
      ASSERT_GE(deep.samples[deep.components * i], 0) << "camera at " << z << ", sample " << i;
    samples += deep.sample_count;
  }
  EXPECT_GT(samples, 100u);
}

TEST_F(RefusedPicture, DeepFramesHaveNoPlaneOfIt) {
  auto plane = sized<bccsplat_plane>();
  EXPECT_EQ(bccsplat_frame_get_channel(frame_.get(), BCCSPLAT_FRAME_DEEP, &plane),
            BCCSPLAT_ERROR_INVALID_ARGUMENT);
  EXPECT_NE(std::string(bccsplat_last_error()).find("bccsplat_frame_get_deep"), std::string::npos);
}

// Texts name what the host knows, not the parts of the library that found it.
TEST_F(RefusedPicture, TextsAreOfTheHeadersWords) {
  std::vector<std::string> texts;
  const auto expect_failed = [&](bccsplat_status status) {
    EXPECT_NE(status, BCCSPLAT_OK);
    texts.emplace_back(bccsplat_last_error());
  };
  bccsplat_slice* s = nullptr;
  auto h = sized<bccsplat_hyperplane>();
  auto o = sized<bccsplat_slice_options>();
  h.d = 1, h.e = -99;
  expect_failed(bccsplat_slice_create(volume_.get(), &h, &o, &s)); // no such time
  h.e = -3, o.spacing = 1e-9;
  expect_failed(bccsplat_slice_create(volume_.get(), &h, &o, &s)); // too fine
  const Writer writer = make_writer(device_, folder_.file("w.bcc4"), options_of({}));
  ASSERT_OK(bccsplat_writer_add_frame(writer.get(), 0, 0, nullptr, 0));
  expect_failed(bccsplat_writer_finish(writer.get(), nullptr)); // too early
  auto large = options_of({});
  large.dims[0] = large.dims[1] = large.dims[2] = 1 << 20;
  bccsplat_writer* w = nullptr;
  const std::string path = folder_.file("l.bcc4");
  bccsplat_status status = bccsplat_writer_create(device_.get(), path.c_str(), &large, &w);
  if (status == BCCSPLAT_OK) status = bccsplat_writer_add_frame(w, 0, 0, nullptr, 0);
  bccsplat_writer_release(w);
  expect_failed(status); // too large
  auto fine = options_of({});
  fine.scale = 1e-9;
  expect_failed(bccsplat_writer_create(device_.get(), path.c_str(), &fine, &w)); // too many planes
  for (const std::string& text : texts)
    for (const char* part :
         {"fit:", "lattice:", "plane slice:", "time slice:", "turned volume:", "extraction:"})
      EXPECT_EQ(text.find(part), std::string::npos) << text;
}

} // namespace
} // namespace host

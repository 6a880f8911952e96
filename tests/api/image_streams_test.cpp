// SPDX-License-Identifier: Apache-2.0
// Images in memory and in streams of a host: the bytes are those of files.
#include "host_streams.h"

namespace host {
namespace {

class Images : public testing::Test {
 protected:
  void SetUp() override {
    if (std::string(bccsplat_build_info()).find("image=none") != std::string::npos)
      GTEST_SKIP() << "built without image files";
    (void)write_series(device, folder.file("s.bcc4"));
    const Volume volume = open(device, folder.file("s.bcc4"));
    const Slice slice = cut_time(volume, 3);
    bccsplat_renderer* r = nullptr;
    ASSERT_OK(bccsplat_renderer_create(device.get(), &r));
    const Renderer renderer(r);
    ASSERT_OK(bccsplat_renderer_set_slice(r, slice.get()));
    bccsplat_frame* f = nullptr;
    ASSERT_OK(bccsplat_frame_create(device.get(), 75, 53, BCCSPLAT_FRAME_DEPTH | BCCSPLAT_FRAME_DEEP, &f));
    frame = Frame(f);
    ASSERT_OK(bccsplat_renderer_render(r, f));
  }
  struct Format {
    int32_t number;
    bccsplat_status (*save)(const bccsplat_frame*, const char*, const bccsplat_image_options*);
  };
  static constexpr Format formats[] = {{BCCSPLAT_IMAGE_PNG, bccsplat_frame_save_png},
                                       {BCCSPLAT_IMAGE_EXR, bccsplat_frame_save_exr},
                                       {BCCSPLAT_IMAGE_DEEP_EXR, bccsplat_frame_save_deep_exr}};
  const Folder folder;
  const Device device = make_device();
  Frame frame;
};

TEST_F(Images, InMemoryAndInStreamsAreThoseOfFiles) {
  for (const Format& format : formats)
    for (const bool background : {false, true}) {
      auto o = sized<bccsplat_image_options>();
      o.overwrite = 1, o.use_background = background, o.background[1] = 0.4;
      o.frames_per_second[0] = 24, o.frames_per_second[1] = 1, o.comments = "made by a test";
      const std::string path = folder.file("image");
      ASSERT_OK(format.save(frame.get(), path.c_str(), &o));
      const std::vector<char> expected = file_bytes(path);
      ASSERT_GT(expected.size(), 500u);
      Sink sink;
      const auto stream = sink.stream();
      ASSERT_OK(bccsplat_frame_save_stream(frame.get(), format.number, &stream, &o));
      EXPECT_EQ(sink.bytes, expected);
      EXPECT_EQ(sink.flushes, 1u);
      uint64_t size = 0;
      ASSERT_OK(bccsplat_frame_save_memory(frame.get(), format.number, &o, nullptr, 0, &size));
      ASSERT_EQ(size, expected.size());
      std::vector<char> bytes(size + 8, 'x');
      ASSERT_OK(
          bccsplat_frame_save_memory(frame.get(), format.number, &o, bytes.data(), bytes.size(), &size));
      EXPECT_EQ(std::vector<char>(bytes.begin(), bytes.end() - 8), expected);
      EXPECT_EQ(bytes.back(), 'x');
      bytes.assign(bytes.size(), 'x');
      ASSERT_OK(bccsplat_frame_save_memory(frame.get(), format.number, &o, bytes.data(), 100, &size));
      EXPECT_TRUE(std::equal(expected.begin(), expected.begin() + 100, bytes.begin()));
      EXPECT_EQ(bytes[100], 'x');
      EXPECT_EQ(size, expected.size());
      for (uint64_t n = 0; n < sink.calls; ++n)
        for (const bool part : {false, true}) {
          Sink failing{.fail_at = n, .part_of_it = part};
          const auto to = failing.stream();
          EXPECT_EQ(bccsplat_frame_save_stream(frame.get(), format.number, &to, &o), BCCSPLAT_ERROR_IO) << n;
        }
    }
}

TEST_F(Images, TellHowFarTheyAreAndCanBeCancelled) {
  struct Heard {
    double last = -1;
    int calls = 0, cancel_at = -1;
    static int32_t progress(void* user, double fraction) {
      auto& h = *static_cast<Heard*>(user);
      EXPECT_GE(fraction, h.last);
      h.last = fraction;
      return h.calls++ == h.cancel_at;
    }
  };
  bccsplat_cancel_token* t = nullptr;
  ASSERT_OK(bccsplat_cancel_token_create(&t));
  const Handle<bccsplat_cancel_token> token(t);
  for (const Format& format : formats) {
    Heard all, stopped;
    auto o = sized<bccsplat_image_options>();
    o.overwrite = 1, o.progress = Heard::progress, o.progress_user = &all;
    const std::string path = folder.file("image");
    ASSERT_OK(format.save(frame.get(), path.c_str(), &o));
    EXPECT_EQ(all.last, 1);
    EXPECT_GE(all.calls, 2);
    const std::vector<char> before = file_bytes(path);
    stopped.cancel_at = 0, o.progress_user = &stopped;
    EXPECT_EQ(format.save(frame.get(), path.c_str(), &o), BCCSPLAT_CANCELLED);
    EXPECT_EQ(file_bytes(path), before) << "the old one stays";
    EXPECT_FALSE(std::filesystem::exists(path + ".partial"));
    o.progress = nullptr, o.cancel_token = t;
    ASSERT_OK(bccsplat_cancel_token_cancel(t));
    uint64_t size = 7;
    EXPECT_EQ(bccsplat_frame_save_memory(frame.get(), format.number, &o, nullptr, 0, &size),
              BCCSPLAT_CANCELLED);
    EXPECT_EQ(size, 7u);
    ASSERT_OK(bccsplat_cancel_token_reset(t));
    EXPECT_OK(bccsplat_frame_save_memory(frame.get(), format.number, &o, nullptr, 0, &size));
  }
}

} // namespace
} // namespace host

// SPDX-License-Identifier: Apache-2.0
// A host hears of the parts of a picture as they are final: each pixel once, never two calls at once, and
// what it reads there is what the finished frame holds.
#include <algorithm>
#include <atomic>
#include <cstring>

#include "support.h"

namespace host {
namespace {

constexpr uint32_t picture_width = 200, picture_height = 150;

// A host's window: what it copied of each part, as it came.
struct TileWindow {
  const bccsplat_frame* frame = nullptr;
  std::vector<float> seen = std::vector<float>(size_t{4} * picture_width * picture_height, -1);
  std::vector<int> times = std::vector<int>(size_t{picture_width} * picture_height);
  std::vector<std::array<uint32_t, 4>> parts;
  std::atomic<int> at_once{0};
  int most_at_once = 0, stop_after = 1 << 30;

  static int32_t tile(void* user, uint32_t x, uint32_t y, uint32_t w, uint32_t h) {
    return static_cast<TileWindow*>(user)->take(x, y, w, h);
  }
  int32_t take(uint32_t x, uint32_t y, uint32_t w, uint32_t h) {
    most_at_once = std::max(most_at_once, ++at_once);
    const size_t first = size_t{picture_width} * y + x;
    EXPECT_OK(bccsplat_frame_copy_part(frame, BCCSPLAT_FRAME_RGBA, BCCSPLAT_PIXELS_F32, x, y, w, h,
                                       seen.data() + 4 * first, int64_t{16} * picture_width));
    for (uint32_t row = 0; row < h; ++row)
      for (uint32_t column = 0; column < w; ++column) ++times[first + size_t{picture_width} * row + column];
    parts.push_back({x, y, w, h});
    --at_once;
    return static_cast<int>(parts.size()) >= stop_after;
  }
};

class Tiles : public testing::Test {
 protected:
  void SetUp() override {
    write_series(device_, folder_.file("s.bcc4"));
    volume_ = open(device_, folder_.file("s.bcc4"));
    slice_ = cut_time(volume_, 3.5);
    bccsplat_renderer* r = nullptr;
    ASSERT_OK(bccsplat_renderer_create(device_.get(), &r));
    renderer_.reset(r);
    ASSERT_OK(bccsplat_renderer_set_slice(r, slice_.get()));
    ASSERT_OK(bccsplat_slice_fit_camera(slice_.get(), BCCSPLAT_PROJECTION_PERSPECTIVE, 20, 30, picture_width,
                                        picture_height, &camera_));
    bccsplat_scene* s = nullptr;
    ASSERT_OK(bccsplat_scene_create(device_.get(), &s));
    scene_.reset(s);
    ASSERT_OK(bccsplat_scene_set_time(s, 3.5));
    view_.camera = &camera_, view_.background = behind_.data();
  }
  void add_instance(double x = 0) {
    auto i = sized<bccsplat_instance>();
    for (size_t n = 0; n < 4; ++n) i.placement[5 * n] = 1;
    i.placement[3] = x;
    uint64_t id = 0;
    ASSERT_OK(bccsplat_scene_add(scene_.get(), volume_.get(), &i, &id));
  }
  [[nodiscard]] Frame frame(uint32_t channels = 0) const {
    bccsplat_frame* f = nullptr;
    EXPECT_OK(bccsplat_frame_create(device_.get(), picture_width, picture_height, channels, &f));
    return Frame(f);
  }
  [[nodiscard]] static std::vector<float> pixels(const Frame& f) {
    std::vector<float> out(size_t{4} * picture_width * picture_height);
    EXPECT_OK(bccsplat_frame_copy(f.get(), BCCSPLAT_FRAME_RGBA, BCCSPLAT_PIXELS_F32, out.data(), 0));
    return out;
  }
  // Tells the window of the frame's parts.
  void watch(TileWindow& window, const Frame& f) {
    window.frame = f.get();
    options_.tile = TileWindow::tile, options_.tile_user = &window;
  }
  static void expect_whole(const TileWindow& window, const Frame& f) {
    EXPECT_EQ(std::count(window.times.begin(), window.times.end(), 1),
              int64_t{picture_width} * picture_height);
    EXPECT_EQ(window.most_at_once, 1);
    EXPECT_EQ(window.seen, pixels(f));
  }

  const Folder folder_;
  Device device_ = make_device(4);
  Volume volume_;
  Slice slice_;
  Renderer renderer_;
  Handle<bccsplat_scene> scene_;
  bccsplat_camera camera_ = sized<bccsplat_camera>();
  bccsplat_view view_ = sized<bccsplat_view>();
  bccsplat_render_options options_ = sized<bccsplat_render_options>();
  std::vector<float> behind_ = std::vector<float>(size_t{4} * picture_width * picture_height, 0.25f);
};

TEST_F(Tiles, OfEveryModeCoverThePicture) {
  struct Way {
    const char* name;
    bccsplat_mode mode;
    bccsplat_smooth_edges edges;
    int reference;
    size_t least;
  };
  for (const Way& way : std::initializer_list<Way>{
           {"composite", BCCSPLAT_MODE_COMPOSITE, 0, 0, 4},
           {"maximum", BCCSPLAT_MODE_MAXIMUM, 0, 0, 4},
           {"smooth surface", BCCSPLAT_MODE_ISOSURFACE, BCCSPLAT_SMOOTH_EDGES_ON, 0, 4},
           {"surface", BCCSPLAT_MODE_ISOSURFACE, BCCSPLAT_SMOOTH_EDGES_OFF, 0, 4},
           {"reference", BCCSPLAT_MODE_MAXIMUM, 0, 1, 1}}) {
    SCOPED_TRACE(way.name);
    options_.mode = way.mode, options_.smooth_edges = way.edges, options_.reference = way.reference;
    options_.set_mask = BCCSPLAT_RENDER_SET_ISO, options_.iso_value = 30, options_.tile_size = 64;
    for (const bool with_background : {false, true}) {
      const Frame f = frame(BCCSPLAT_FRAME_DEPTH), plain = frame(BCCSPLAT_FRAME_DEPTH);
      auto view = view_;
      auto wide = camera_; // the reference takes its time for each pixel that shows something
      wide.fovy_degrees = 150;
      if (way.reference) view.camera = &wide;
      if (!with_background) view.background = nullptr;
      ASSERT_OK(bccsplat_renderer_set_view(renderer_.get(), &view));
      options_.tile = nullptr;
      ASSERT_OK(bccsplat_renderer_set_options(renderer_.get(), &options_));
      ASSERT_OK(bccsplat_renderer_render(renderer_.get(), plain.get()));
      TileWindow window;
      watch(window, f);
      ASSERT_OK(bccsplat_renderer_set_options(renderer_.get(), &options_));
      ASSERT_OK(bccsplat_renderer_render(renderer_.get(), f.get()));
      expect_whole(window, f);
      EXPECT_GE(window.parts.size(), way.least);
      EXPECT_EQ(pixels(f), pixels(plain)) << "whoever looks on changes nothing";
    }
  }
}

TEST_F(Tiles, OfScenesWithAnyNumberOfInstances) {
  for (int instances = 0; instances < 3; ++instances) {
    if (instances > 0) add_instance(6.0 * (instances - 1));
    for (const bccsplat_mode mode : {BCCSPLAT_MODE_COMPOSITE, BCCSPLAT_MODE_ISOSURFACE}) {
      SCOPED_TRACE(testing::Message() << instances << " in mode " << mode);
      options_.mode = mode, options_.set_mask = BCCSPLAT_RENDER_SET_ISO, options_.iso_value = 30;
      const Frame f = frame();
      TileWindow window;
      watch(window, f);
      ASSERT_OK(bccsplat_scene_render(scene_.get(), &view_, f.get(), &options_, 0, nullptr));
      expect_whole(window, f);
    }
  }
}

// The whole frame first, coarse, then bands; each call begins with all that there is.
TEST_F(Tiles, OfABudgetBeginWithWhatThereIs) {
  add_instance();
  const Frame f = frame();
  auto status = sized<bccsplat_scene_status>();
  int calls = 0;
  uint32_t finished = 0; // rows
  do {
    TileWindow window;
    watch(window, f);
    const std::vector<float> before = pixels(f);
    ASSERT_OK(bccsplat_scene_render(scene_.get(), &view_, f.get(), &options_, 1e-3, &status));
    if (window.parts.empty()) {
      EXPECT_EQ(status.progress, 0);
      EXPECT_EQ(pixels(f), before);
      continue;
    }
    EXPECT_EQ(window.parts.front(), (std::array<uint32_t, 4>{0, 0, picture_width, picture_height}));
    for (size_t n = 1; n < window.parts.size(); ++n) {
      EXPECT_EQ(window.parts[n][1], finished);
      EXPECT_EQ(window.parts[n][2], picture_width);
      finished += window.parts[n][3];
    }
    EXPECT_EQ(window.most_at_once, 1);
    EXPECT_EQ(window.seen, pixels(f));
    ASSERT_LT(++calls, 100);
  } while (!status.complete);
  EXPECT_EQ(finished, picture_height);
  const Frame whole = frame();
  options_.tile = nullptr;
  ASSERT_OK(bccsplat_scene_render(scene_.get(), &view_, whole.get(), &options_, 0, nullptr));
  EXPECT_LT(largest_difference(pixels(f), pixels(whole)), 1e-4);
}

TEST_F(Tiles, AnAnswerOtherThanZeroCancels) {
  add_instance();
  options_.tile_size = 32;
  const Frame f = frame();
  for (const double budget : {0.0, 1e6}) {
    TileWindow window;
    watch(window, f);
    window.stop_after = 2;
    EXPECT_EQ(bccsplat_scene_render(scene_.get(), &view_, f.get(), &options_, budget, nullptr),
              BCCSPLAT_CANCELLED);
    EXPECT_EQ(window.parts.size(), 2u);
    // What it was told of is there.
    const std::vector<float> now = pixels(f);
    for (size_t p = 0; p < window.times.size(); ++p)
      for (size_t c = 0; window.times[p] > 0 && c < 4; ++c)
        ASSERT_EQ(now[4 * p + c], window.seen[4 * p + c]) << p;
    bccsplat_scene* s = nullptr; // another one has no picture under way
    ASSERT_OK(bccsplat_scene_create(device_.get(), &s));
    scene_.reset(s);
    ASSERT_OK(bccsplat_scene_set_time(s, 3.5));
    add_instance();
  }
}

TEST_F(Tiles, PartsAreCopiedAsTheWholeIs) {
  const Frame f = frame(BCCSPLAT_FRAME_DEPTH);
  ASSERT_OK(bccsplat_renderer_render(renderer_.get(), f.get()));
  for (const bccsplat_pixel_format format : {BCCSPLAT_PIXELS_F32, BCCSPLAT_PIXELS_F16, BCCSPLAT_PIXELS_SRGB8,
                                             BCCSPLAT_PIXELS_SRGB8_PREMULTIPLIED}) {
    const size_t pixel = format == BCCSPLAT_PIXELS_F32 ? 16 : format == BCCSPLAT_PIXELS_F16 ? 8 : 4;
    const size_t row = pixel * picture_width;
    std::vector<unsigned char> whole(row * picture_height), parts(row * picture_height);
    // Rows from the bottom up, as OpenGL has them.
    unsigned char* const top = whole.data() + row * (picture_height - 1);
    ASSERT_OK(bccsplat_frame_copy(f.get(), BCCSPLAT_FRAME_RGBA, format, top, -static_cast<int64_t>(row)));
    for (uint32_t y = 0; y < picture_height; y += 40)
      for (uint32_t x = 0; x < picture_width; x += 70)
        ASSERT_OK(bccsplat_frame_copy_part(
            f.get(), BCCSPLAT_FRAME_RGBA, format, x, y, std::min(70u, picture_width - x),
            std::min(40u, picture_height - y), parts.data() + row * (picture_height - 1 - y) + pixel * x,
            -static_cast<int64_t>(row)));
    EXPECT_EQ(parts, whole) << format;
  }
}

} // namespace
} // namespace host

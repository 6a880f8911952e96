// SPDX-License-Identifier: Apache-2.0
// What a picture tells of the work it was spared, each count by what makes it rise; and what the log is told.
#include <algorithm>

#include "support.h"

using namespace host;

namespace {

struct Told {
  std::vector<std::string> infos, warnings;
  [[nodiscard]] bool info_with(const std::string& words) const {
    return std::any_of(infos.begin(), infos.end(),
                       [&](const std::string& s) { return s.find(words) != std::string::npos; });
  }
};

Device listening_device(Told& told, uint64_t budget = 0) {
  auto o = sized<bccsplat_device_options>();
  o.thread_count = 1, o.log_user = &told, o.memory_budget = budget;
  o.log = [](void* user, int32_t level, const char* message) {
    auto* const t = static_cast<Told*>(user);
    (level == BCCSPLAT_LOG_INFO ? t->infos : t->warnings).emplace_back(message);
  };
  bccsplat_device* d = nullptr;
  EXPECT_OK(bccsplat_device_create(&o, &d));
  return Device(d);
}

class Counters : public testing::Test {
 protected:
  // Values rise along z, 0 to 100, with waves across; two coarser levels.
  Counters() {
    series.nx = series.ny = series.nz = 64, series.nt = 6;
    series.field = [](double x, double y, double z, double t) {
      return 1.5 * z + 3 * std::sin(0.3 * x + 0.2 * y + t);
    };
    auto o = options_of(series);
    o.levels = 2;
    const Writer w = make_writer(device, path, o);
    EXPECT_OK(add_frames(w.get(), series));
    EXPECT_OK(bccsplat_writer_finish(w.get(), nullptr));
    volume = open(device, path);
    slice = cut_time(volume, 2.5);
    bccsplat_renderer* r = nullptr;
    EXPECT_OK(bccsplat_renderer_create(device.get(), &r));
    renderer.reset(r);
    options.disable_skips = BCCSPLAT_SKIP_UNCHANGED;
    set_function(0, 0.01);
    EXPECT_OK(bccsplat_slice_fit_camera(slice.get(), 0, 0, 0, size, size, &camera)); // along z
  }
  // Opaque from a value on.
  void set_function(double from, double opacity) {
    const double colors[] = {0, 1, 1, 1, 100, 1, 1, 1};
    const double opacities[] = {from - 1, 0, from, opacity};
    auto f = sized<bccsplat_transfer_function>();
    f.color_count = f.opacity_count = 2, f.colors = colors, f.opacities = opacities;
    EXPECT_OK(bccsplat_renderer_set_transfer_function(renderer.get(), &f));
  }
  bccsplat_render_stats draw(uint32_t pixels = size) {
    bccsplat_frame* f = nullptr;
    EXPECT_OK(bccsplat_frame_create(device.get(), pixels, pixels, BCCSPLAT_FRAME_RGBA, &f));
    const Frame frame(f);
    EXPECT_OK(bccsplat_renderer_set_slice(renderer.get(), slice.get()));
    EXPECT_OK(bccsplat_renderer_set_camera(renderer.get(), &camera));
    EXPECT_OK(bccsplat_renderer_set_options(renderer.get(), &options));
    EXPECT_OK(bccsplat_renderer_render(renderer.get(), f));
    auto stats = sized<bccsplat_render_stats>();
    EXPECT_OK(bccsplat_renderer_get_stats(renderer.get(), &stats));
    EXPECT_LE(stats.bricks_invisible + stats.bricks_outside, stats.bricks_total);
    EXPECT_LE(stats.visits_hidden + stats.visits_unread, stats.brick_visits);
    return stats;
  }

  static constexpr uint32_t size = 160;
  Folder folder;
  Told told;
  Device device = listening_device(told);
  Series series;
  std::string path = folder.file("s.bcc4");
  Volume volume;
  Slice slice;
  Renderer renderer;
  bccsplat_render_options options = sized<bccsplat_render_options>();
  bccsplat_camera camera = sized<bccsplat_camera>();
};

TEST_F(Counters, BricksAreInvisibleByTheFunction) {
  set_function(-100, 0.01);
  const auto all = draw();
  EXPECT_GT(all.bricks_total, 0u);
  EXPECT_EQ(all.bricks_invisible, 0u);
  EXPECT_EQ(all.bricks_outside, 0u);
  EXPECT_EQ(all.visits_hidden, 0u);
  EXPECT_GE(all.brick_visits, all.bricks_total);
  set_function(60, 0.01);
  const auto some = draw();
  EXPECT_EQ(some.bricks_total, all.bricks_total);
  EXPECT_GT(some.bricks_invisible, all.bricks_total / 4);
  EXPECT_LT(some.brick_visits, all.brick_visits);
  EXPECT_GT(some.points_invisible, 0u);
  EXPECT_GT(some.sheets_skipped, all.sheets_skipped);
  options.disable_skips |= BCCSPLAT_SKIP_TRANSFER_FUNCTION;
  EXPECT_EQ(draw().bricks_invisible, 0u);
}

TEST_F(Counters, BricksAreOutsideTheView) {
  camera.ortho_height /= 4;
  const auto near = draw();
  EXPECT_GT(near.bricks_outside, near.bricks_total / 4);
  EXPECT_EQ(near.bricks_invisible, 0u);
}

TEST_F(Counters, BricksAreHiddenByOpaqueOnes) {
  set_function(0, 0.9);
  options.tile_size = 64;
  const auto opaque = draw();
  EXPECT_GT(opaque.visits_hidden + opaque.visits_unread, opaque.brick_visits / 4);
  set_function(0, 0.0001);
  const auto clear = draw();
  EXPECT_EQ(clear.visits_hidden, 0u);
  EXPECT_LT(clear.visits_unread, opaque.visits_unread);
}

TEST_F(Counters, LevelsOfTheVolumeAndOfThePicture) {
  EXPECT_EQ(draw().level, 0u);
  auto h = sized<bccsplat_hyperplane>();
  h.d = 1, h.e = -2.5;
  auto o = sized<bccsplat_slice_options>();
  o.level = 2;
  bccsplat_slice* s = nullptr;
  ASSERT_OK(bccsplat_slice_create(volume.get(), &h, &o, &s));
  slice.reset(s);
  EXPECT_EQ(draw().level, 2u);
  slice = cut_time(volume, 2.5);
  EXPECT_FALSE(told.info_with("times the lattice distance"));
  const auto small = draw(16);
  EXPECT_GT(small.coarse_level, 0);
  EXPECT_EQ(small.level, 0u);
  EXPECT_TRUE(told.info_with("times the lattice distance"));
  const size_t lines = told.infos.size();
  (void)draw(16);
  EXPECT_EQ(told.infos.size(), lines); // once
  (void)draw();
  EXPECT_TRUE(told.info_with("the slice itself"));
}

TEST_F(Counters, BytesAreReadForTrails) {
  volume = open(device, path);
  slice = cut_time(volume, 0);
  const auto still = draw();
  EXPECT_EQ(still.bytes_read, 0u);
  auto trail = sized<bccsplat_trail>();
  trail.interval[1] = 5, trail.samples = 4;
  ASSERT_OK(bccsplat_renderer_set_trail(renderer.get(), &trail));
  const auto with_trail = draw();
  EXPECT_GT(with_trail.bytes_read, 0u);
  EXPECT_GT(with_trail.bricks_total, still.bricks_total);
  EXPECT_EQ(draw().bytes_read, 0u); // the trail is kept
}

TEST_F(Counters, StepsTooFineForTheRingAreDrawnAsFineAsItHolds) {
  options.sheet_step = 0.001;
  options.disable_skips |= BCCSPLAT_SKIP_FINE_DETAIL;
  const auto stats = draw(24);
  EXPECT_GT(stats.sheet_step, 0.01);
  EXPECT_LT(stats.sheet_step, 0.02);
  options.sheet_step = 0.0009;
  EXPECT_EQ(bccsplat_renderer_set_options(renderer.get(), &options), BCCSPLAT_ERROR_INVALID_ARGUMENT);
}

TEST_F(Counters, TheLogIsToldOnceOfWorkThatIsRepeatedAndOfTheCacheThatSparesIt) {
  EXPECT_TRUE(told.info_with("caches of"));
  const auto play = [&](uint64_t cache_bytes) {
    auto o = sized<bccsplat_volume_options>();
    o.cache_bytes = cache_bytes;
    bccsplat_volume* v = nullptr;
    ASSERT_OK(bccsplat_volume_open_file(device.get(), path.c_str(), &o, &v));
    volume.reset(v);
    for (double t = 0; t <= 5; t += 0.5) (void)cut_time(volume, t);
  };
  const auto times_told = [&] {
    return std::count_if(told.infos.begin(), told.infos.end(),
                         [](const std::string& s) { return s.find("made again") != std::string::npos; });
  };
  play(100000); // far too little
  ASSERT_EQ(times_told(), 1);
  const std::string said = *std::find_if(told.infos.begin(), told.infos.end(), [](const std::string& s) {
    return s.find("made again") != std::string::npos;
  });
  // Nor is it told again of what is looked at anew.
  const size_t all_told = told.infos.size();
  for (int i = 0; i < 2; ++i) {
    bccsplat_volume* newer = nullptr;
    ASSERT_OK(bccsplat_volume_reopen(volume.get(), nullptr, &newer));
    volume.reset(newer);
    for (double t = 0; t <= 2; t += 0.5) (void)cut_time(volume, t);
  }
  EXPECT_EQ(told.infos.size(), all_told);
  const std::string before = "cache_bytes of ";
  const uint64_t enough = std::stoull(said.substr(said.find(before) + before.size()));
  EXPECT_GT(enough, 100000u);
  play(enough);
  EXPECT_EQ(times_told(), 1) << "with what it said";
  (void)cut_time(volume, 0); // back, which the cache need not hold
  EXPECT_LE(times_told(), 2);
  EXPECT_TRUE(told.warnings.empty());
}

} // namespace

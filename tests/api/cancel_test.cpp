// SPDX-License-Identifier: Apache-2.0
// Cancel tokens: calls under way end soon, keep what they have, and leave their objects as they were.
#include <algorithm>
#include <chrono>
#include <random>
#include <thread>

#include "support.h"

using namespace host;

namespace {

using Token = Handle<bccsplat_cancel_token>;
using Clock = std::chrono::steady_clock;

Token make_token() {
  bccsplat_cancel_token* t = nullptr;
  EXPECT_OK(bccsplat_cancel_token_create(&t));
  return Token(t);
}

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// Runs a call to its end, then cancels it at several moments: it ends within a quarter of a second, or of
// what it takes where the machine is slow, once at least within a tenth of that, and works afterwards.
template<class Call> void expect_prompt(const Token& token, const Call& call) {
  const auto start = Clock::now();
  ASSERT_OK(call());
  const double whole = seconds_since(start), bound = std::max(0.25, 0.25 * whole);
  double quickest = whole;
  int ended = 0;
  for (const double share : {0.1, 0.3, 0.5, 0.7, 0.9}) {
    ASSERT_OK(bccsplat_cancel_token_reset(token.get()));
    Clock::time_point asked;
    std::thread canceller([&] {
      std::this_thread::sleep_for(std::chrono::duration<double>(share * whole));
      asked = Clock::now();
      EXPECT_OK(bccsplat_cancel_token_cancel(token.get()));
    });
    const bccsplat_status status = call();
    const auto returned = Clock::now();
    canceller.join();
    ASSERT_TRUE(status == BCCSPLAT_OK || status == BCCSPLAT_CANCELLED) << bccsplat_last_error();
    if (status == BCCSPLAT_CANCELLED) {
      ++ended;
      const double taken = std::chrono::duration<double>(returned - asked).count();
      EXPECT_LT(taken, bound) << share << " of " << whole;
      quickest = std::min(quickest, taken);
    }
  }
  EXPECT_GT(ended, 0);
  EXPECT_LT(quickest, 0.1 * whole + 0.002) << "of " << whole;
  ASSERT_OK(bccsplat_cancel_token_reset(token.get()));
  EXPECT_OK(call());
}

class Cancel : public testing::Test {
 protected:
  Cancel() {
    series.nx = series.ny = series.nz = 48, series.nt = 4;
    series.field = [](double x, double y, double z, double t) {
      return 100 + 50 * std::sin(0.4 * x + 0.3 * t) * std::cos(0.3 * y) + 40 * std::sin(0.2 * z);
    };
    (void)write_series(device, path, series);
  }
  [[nodiscard]] Volume open_with(bccsplat_cancel_token* t) const {
    auto o = sized<bccsplat_volume_options>();
    o.cancel_token = t;
    bccsplat_volume* v = nullptr;
    EXPECT_OK(bccsplat_volume_open_file(device.get(), path.c_str(), &o, &v));
    return Volume(v);
  }

  Folder folder;
  Device device = make_device(2);
  Token token = make_token();
  Series series;
  std::string path = folder.file("s.bcc4");
};

TEST_F(Cancel, EvaluationOfManyPointsEndsSoon) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(0, 47), moment(0, 3);
  std::vector<double> at;
  for (int i = 0; i < 600000; ++i)
    at.insert(at.end(), {place(random), place(random), place(random), moment(random)});
  std::vector<float> values(at.size() / 4);
  const Volume volume = open_with(token.get());
  expect_prompt(token, [&] {
    return bccsplat_volume_evaluate(volume.get(), values.size(), at.data(), values.data(), nullptr);
  });
}

TEST_F(Cancel, SlicesEndSoon) {
  auto h = sized<bccsplat_hyperplane>();
  h.a = 0.3, h.b = 0.1, h.d = 1, h.e = -10;
  auto o = sized<bccsplat_slice_options>();
  o.cancel_token = token.get(), o.spacing = 0.5;
  expect_prompt(token, [&] {
    const Volume volume = open(device, path);
    bccsplat_slice* s = nullptr;
    const auto status = bccsplat_slice_create(volume.get(), &h, &o, &s);
    EXPECT_EQ(s != nullptr, status == BCCSPLAT_OK);
    bccsplat_slice_release(s);
    return status;
  });
}

TEST_F(Cancel, PicturesEndSoon) {
  const Slice slice = cut_time(open(device, path), 1.5);
  auto trail = sized<bccsplat_trail>();
  trail.interval[0] = -1;
  for (const bool with_trail : {false, true})
    for (const uint32_t more : {0u, uint32_t{BCCSPLAT_FRAME_DEEP}})
      expect_prompt(token, [&] {
        bccsplat_renderer* r = nullptr;
        EXPECT_OK(bccsplat_renderer_create(device.get(), &r));
        const Renderer renderer(r);
        EXPECT_OK(bccsplat_renderer_set_slice(r, slice.get()));
        EXPECT_OK(bccsplat_renderer_set_trail(r, with_trail ? &trail : nullptr));
        auto o = sized<bccsplat_render_options>();
        o.cancel_token = token.get(), o.quality = BCCSPLAT_QUALITY_FINE;
        EXPECT_OK(bccsplat_renderer_set_options(r, &o));
        bccsplat_frame* f = nullptr;
        EXPECT_OK(bccsplat_frame_create(device.get(), 256, 256, BCCSPLAT_FRAME_RGBA | more, &f));
        const Frame frame(f);
        return bccsplat_renderer_render(r, f);
      });
}

TEST_F(Cancel, WritersEndSoonAndLeaveNoFile) {
  const std::string other = folder.file("other.bcc4");
  expect_prompt(token, [&] {
    auto o = options_of(series);
    o.cancel_token = token.get(), o.overwrite = 1;
    bccsplat_writer* w = nullptr;
    std::filesystem::remove(other);
    bccsplat_status status = bccsplat_writer_create(device.get(), other.c_str(), &o, &w);
    const Writer writer(w);
    if (status == BCCSPLAT_OK) status = add_frames(w, series);
    if (status == BCCSPLAT_OK) status = bccsplat_writer_finish(w, nullptr);
    EXPECT_EQ(std::filesystem::exists(other), status == BCCSPLAT_OK);
    return status;
  });
}

struct Picture {
  Picture(const Device& device, const Slice& slice) {
    bccsplat_renderer* r = nullptr;
    EXPECT_OK(bccsplat_renderer_create(device.get(), &r));
    renderer.reset(r);
    EXPECT_OK(bccsplat_renderer_set_slice(r, slice.get()));
    bccsplat_frame* f = nullptr;
    EXPECT_OK(bccsplat_frame_wrap(device.get(), 200, 200, pixels.data(), 0, &f));
    frame.reset(f);
    options.tile_size = 32, options.disable_skips = BCCSPLAT_SKIP_UNCHANGED;
  }
  bccsplat_status draw() {
    EXPECT_OK(bccsplat_renderer_set_options(renderer.get(), &options));
    return bccsplat_renderer_render(renderer.get(), frame.get());
  }
  std::vector<float> pixels = std::vector<float>(200 * 200 * 4, -7);
  bccsplat_render_options options = sized<bccsplat_render_options>();
  Renderer renderer;
  Frame frame;
};

TEST_F(Cancel, APictureKeepsTheTilesThatAreDone) {
  const Slice slice = cut_time(open(device, path), 1.5);
  Picture whole(device, slice), part(device, slice);
  ASSERT_OK(whole.draw());
  part.options.cancel_token = token.get(), part.options.progress_user = token.get();
  part.options.progress = [](void* user, double fraction) -> int32_t {
    return fraction > 0 ? bccsplat_cancel_token_cancel(static_cast<bccsplat_cancel_token*>(user)) : 0;
  };
  EXPECT_EQ(part.draw(), BCCSPLAT_CANCELLED);
  size_t done = 0, before = 0;
  for (size_t i = 0; i < whole.pixels.size(); ++i) {
    const bool drawn = part.pixels[i] != -7;
    ++(drawn ? done : before);
    ASSERT_TRUE(!drawn || part.pixels[i] == whole.pixels[i]) << i;
  }
  EXPECT_GT(done, 0u);
  EXPECT_GT(before, 0u);
  ASSERT_OK(bccsplat_cancel_token_reset(token.get()));
  part.options.progress = nullptr;
  ASSERT_OK(part.draw());
  EXPECT_EQ(part.pixels, whole.pixels);
}

// A cancel that is taken back at once ends what was under way, and nothing else.
TEST_F(Cancel, WhatWasUnderWayEndsAfterAReset) {
  const Slice slice = cut_time(open(device, path), 1.5);
  Picture picture(device, slice);
  picture.options.cancel_token = token.get(), picture.options.progress_user = token.get();
  picture.options.progress = [](void* user, double) -> int32_t {
    auto* const t = static_cast<bccsplat_cancel_token*>(user);
    EXPECT_OK(bccsplat_cancel_token_cancel(t));
    EXPECT_OK(bccsplat_cancel_token_reset(t));
    return 0;
  };
  EXPECT_EQ(picture.draw(), BCCSPLAT_CANCELLED);
  picture.options.progress = nullptr;
  EXPECT_OK(picture.draw());
}

} // namespace

// SPDX-License-Identifier: Apache-2.0
// A stream whose bytes are on their way: calls end, nothing is harmed, and made again they give what they
// would have given at once.
#include <thread>

#include "host_streams.h"

namespace host {
namespace {

[[nodiscard]] std::vector<Range> lacking() {
  uint64_t count = 0;
  EXPECT_OK(bccsplat_last_lacking(nullptr, 0, &count));
  std::vector<uint64_t> pairs(2 * count);
  EXPECT_OK(bccsplat_last_lacking(pairs.data(), count, nullptr));
  std::vector<Range> ranges;
  for (size_t i = 0; i < count; ++i) ranges.emplace_back(pairs[2 * i], pairs[2 * i + 1]);
  return ranges;
}

// Makes a call again until it has what it needs; it has to wait at least once where `waits` is set.
template<class Call> int until_done(FarFile& file, const Call& call) {
  for (int waits = 0;; ++waits) {
    {
      const std::scoped_lock lock(file.mutex);
      file.refused.clear();
    }
    const bccsplat_status status = call();
    if (status == BCCSPLAT_OK) return waits;
    EXPECT_EQ(status, BCCSPLAT_ERROR_WOULD_BLOCK) << bccsplat_last_error();
    if (status != BCCSPLAT_ERROR_WOULD_BLOCK || waits == 1000) {
      ADD_FAILURE() << "it does not come to an end";
      return waits;
    }
    const std::vector<Range> lacks = lacking();
    EXPECT_FALSE(lacks.empty());
    const std::scoped_lock lock(file.mutex);
    EXPECT_TRUE(covers(merged(file.refused), lacks)) << "it lacks what it was refused";
  }
}

struct Seen {
  std::vector<float> values, frame, at_points, picture, oblique;
  uint64_t corrections = 0, damages = 0;
  int waits = 0; // calls that had to be made again
  bool operator==(const Seen& o) const {
    return values == o.values && frame == o.frame && at_points == o.at_points && picture == o.picture &&
           oblique == o.oblique && corrections == o.corrections && damages == o.damages;
  }
};

void draw(FarFile& file, const Device& device, const Slice& slice, Seen& seen) {
  bccsplat_renderer* r = nullptr;
  ASSERT_OK(bccsplat_renderer_create(device.get(), &r));
  const Renderer renderer(r);
  ASSERT_OK(bccsplat_renderer_set_slice(r, slice.get()));
  auto trail = sized<bccsplat_trail>();
  trail.interval[0] = -3, trail.samples = 3;
  ASSERT_OK(bccsplat_renderer_set_trail(r, &trail));
  seen.picture.resize(32 * 32 * 4);
  bccsplat_frame* f = nullptr;
  ASSERT_OK(bccsplat_frame_wrap(device.get(), 32, 32, seen.picture.data(), 0, &f));
  const Frame frame(f);
  seen.waits += until_done(file, [&] { return bccsplat_renderer_render(r, f); });
}

[[nodiscard]] Seen look_at(FarFile& file, bool blocks, int threads, const bccsplat_volume_options& options) {
  const Device device = make_device(threads);
  file.blocks = blocks;
  file.there.clear();
  const bccsplat_read_stream stream = file.stream();
  Seen seen;
  bccsplat_volume* v = nullptr;
  seen.waits += until_done(file, [&] {
    const bccsplat_status status = bccsplat_volume_open_stream(device.get(), &stream, &options, &v);
    EXPECT_EQ(status == BCCSPLAT_OK, v != nullptr);
    return status;
  });
  const Volume volume(v);
  EXPECT_EQ(seen.waits > 0, blocks);
  const auto cut = [&](const bccsplat_hyperplane& plane, std::vector<float>& values) {
    bccsplat_slice* s = nullptr;
    seen.waits += until_done(file, [&] { return bccsplat_slice_create(v, &plane, nullptr, &s); });
    Slice slice(s);
    auto info = sized<bccsplat_slice_info>();
    EXPECT_OK(bccsplat_slice_get_info(s, &info));
    values.resize(info.dims[0] * info.dims[1] * info.dims[2]);
    seen.waits += until_done(file, [&] { return bccsplat_slice_sample_grid(s, nullptr, values.data()); });
    return slice;
  };
  const Slice slice = cut(plane_of(0, 0, 0, 1, -4.4), seen.values);
  draw(file, device, slice, seen);
  // Where nothing stays each block of an oblique slice decodes its tiles anew: a minute for a blink.
  if (options.cache_bytes != 1) (void)cut(plane_of(0.5, 0.2, 0.3, 1, -14), seen.oblique);
  seen.frame.resize(seen.values.size());
  seen.waits += until_done(
      file, [&] { return bccsplat_volume_read_frame(v, 0, 9, nullptr, nullptr, seen.frame.data()); });
  std::vector<double> points;
  for (double t = 0; t < 13; t += 0.7) points.insert(points.end(), {10 + t, 12, 13.5, t});
  seen.at_points.resize(points.size() / 4);
  seen.waits += until_done(file, [&] {
    return bccsplat_volume_evaluate(v, seen.at_points.size(), points.data(), seen.at_points.data(), nullptr);
  });
  auto channel = sized<bccsplat_channel_info>();
  seen.waits += until_done(file, [&] { return bccsplat_volume_get_channel_info(v, 0, &channel); });
  seen.corrections = channel.corrections;
  auto report = sized<bccsplat_verify_report>();
  seen.waits += until_done(file, [&] { return bccsplat_volume_verify(v, nullptr, nullptr, &report); });
  seen.damages = report.damages;
  // NaN, of which there are none but in a corner, would differ from itself.
  for (auto* list : {&seen.values, &seen.oblique, &seen.frame})
    for (float& x : *list)
      if (std::isnan(x)) x = -1e9f;
  return seen;
}

[[nodiscard]] FarFile noise_file(const std::function<void(bccsplat_writer_options&)>& set, bool holes) {
  NoiseSeries series;
  series.nx = 36, series.ny = 20, series.nz = 18, series.holes = holes;
  auto o = series.options();
  set(o);
  return FarFile(written(make_device(), series, o));
}

void expect_same(FarFile&& file) {
  auto o = sized<bccsplat_volume_options>();
  Seen at_once = look_at(file, false, 2, o);
  EXPECT_EQ(at_once.waits, 0);
  EXPECT_EQ(at_once.damages, 0u);
  const auto waiting = [&](int threads) {
    const Seen seen = look_at(file, true, threads, o);
    EXPECT_GE(seen.waits, 3); // for the head and the tables, and for what is cut first
    EXPECT_TRUE(seen == at_once) << threads << " threads";
  };
  waiting(1), waiting(4);
  o.salvage = 1; // bytes that are late are not lost
  waiting(3);
  o.salvage = 0, o.cache_bytes = 1; // nothing stays
  at_once.oblique.clear();
  waiting(2);
}

TEST(WouldBlock, SamplesAreTheSameLater) {
  expect_same(noise_file([](auto&) {}, false));
}
TEST(WouldBlock, WaveletsAndLevelsAreTheSameLater) {
  expect_same(noise_file(
      [](bccsplat_writer_options& o) { o.store = BCCSPLAT_STORE_WAVELETS, o.abs_error = 3, o.levels = 1; },
      false));
}
TEST(WouldBlock, FramesOfTheSourcesOwnGridAreTheSameLater) {
  expect_same(noise_file(
      [](bccsplat_writer_options& o) {
        o.lattice = BCCSPLAT_LATTICE_CC, o.recommended_kernel = "exact", o.store = BCCSPLAT_STORE_WAVELETS,
        o.abs_error = 3;
      },
      true));
}
TEST(WouldBlock, MasksAndCorrectionsAreTheSameLater) {
  expect_same(noise_file([](bccsplat_writer_options& o) { o.abs_error = 3; }, true));
}

// A host that fetches what it is told of in advance waits for nothing.
TEST(WouldBlock, NotAfterTheRangesAreThere) {
  FarFile file = noise_file([](bccsplat_writer_options& o) { o.abs_error = 3; }, true);
  file.blocks = true;
  const Device device = make_device();
  const bccsplat_read_stream stream = file.stream();
  const auto plane = plane_of(0, 0, 0, 1, -6.5);
  bccsplat_volume* v = nullptr;
  const int opening =
      until_done(file, [&] { return bccsplat_volume_open_stream(device.get(), &stream, nullptr, &v); });
  EXPECT_LE(opening, 2); // its head, and what that refers to
  const Volume volume(v);
  uint64_t count = 0;
  const int asking =
      until_done(file, [&] { return bccsplat_volume_get_ranges(v, &plane, nullptr, 0, nullptr, 0, &count); });
  EXPECT_LE(asking, 1);
  std::vector<uint64_t> pairs(2 * count);
  ASSERT_OK(bccsplat_volume_get_ranges(v, &plane, nullptr, 0, pairs.data(), count, nullptr));
  for (size_t i = 0; i < count; ++i) file.fetch({{pairs[2 * i], pairs[2 * i + 1]}});
  bccsplat_slice* s = nullptr;
  EXPECT_OK(bccsplat_slice_create(v, &plane, nullptr, &s));
  const Slice slice(s);
}

// A host hears at once of all that a call is about to read, as far as it is known where that stands: first of
// tables, then of all else; not of one table or brick of corrections after the other.
struct CorrectedFarFile {
  FarFile file = noise_file([](bccsplat_writer_options& o) { o.abs_error = 3; }, true);
  Device device = make_device();
  Volume volume;
  CorrectedFarFile() {
    const bccsplat_read_stream stream = file.stream();
    bccsplat_volume* v = nullptr;
    EXPECT_OK(bccsplat_volume_open_stream(device.get(), &stream, nullptr, &v));
    volume.reset(v);
    file.blocks = true;
  }
};

TEST(WouldBlock, LayersAreNamedTogether) {
  FarFile file = noise_file([](auto&) {}, false);
  const Device device = make_device(1);
  const bccsplat_read_stream stream = file.stream();
  bccsplat_volume* v = nullptr;
  ASSERT_OK(bccsplat_volume_open_stream(device.get(), &stream, nullptr, &v));
  const Volume volume(v);
  file.blocks = true;
  const auto plane = plane_of(0, 0, 0, 1, -4.4);
  bccsplat_slice* s = nullptr;
  // Of all samples that coefficients are made of, and not of the first layer of them before the others.
  EXPECT_EQ(until_done(file, [&] { return bccsplat_slice_create(v, &plane, nullptr, &s); }), 1);
  const Slice slice(s);
}

TEST(WouldBlock, CorrectionsAreNamedTogether) {
  CorrectedFarFile far;
  FarFile& file = far.file;
  const Device& device = far.device;
  bccsplat_slice* s = nullptr;
  const auto plane = plane_of(0, 0, 0, 1, -6.5);
  EXPECT_LE(until_done(file, [&] { return bccsplat_slice_create(far.volume.get(), &plane, nullptr, &s); }),
            3);
  const Slice slice(s);
  bccsplat_renderer* r = nullptr;
  ASSERT_OK(bccsplat_renderer_create(device.get(), &r));
  const Renderer renderer(r);
  ASSERT_OK(bccsplat_renderer_set_slice(r, s));
  auto trail = sized<bccsplat_trail>();
  trail.interval[0] = -5, trail.interval[1] = 5;
  ASSERT_OK(bccsplat_renderer_set_trail(r, &trail));
  bccsplat_frame* f = nullptr;
  ASSERT_OK(bccsplat_frame_create(device.get(), 16, 16, BCCSPLAT_FRAME_RGBA, &f));
  const Frame frame(f);
  EXPECT_LE(until_done(file, [&] { return bccsplat_renderer_render(r, f); }), 3);
}
TEST(WouldBlock, CorrectionsOfPointsAreNamedTogether) {
  CorrectedFarFile far;
  std::vector<double> points;
  for (double t = 0; t < 13; t += 0.7) points.insert(points.end(), {10 + t, 12, 13.5, t});
  std::vector<float> values(points.size() / 4);
  EXPECT_LE(until_done(far.file,
                       [&] {
                         return bccsplat_volume_evaluate(far.volume.get(), values.size(), points.data(),
                                                         values.data(), nullptr);
                       }),
            3);
}

// An oblique slice asks for the layers of its time few times, also where none of them stays: not once for
// each plane that is corrected or layer of bricks that is made.
TEST(FarReads, AnObliqueSliceAsksForItsLayersFewTimes) {
  const auto reads_of = [](uint64_t cache_bytes) {
    NoiseSeries series;
    series.nx = 20, series.ny = 18, series.nz = 80;
    auto o = series.options();
    o.abs_error = 3;
    const Device device = make_device(1);
    FarFile file(written(device, series, o));
    const bccsplat_read_stream stream = file.stream();
    auto options = sized<bccsplat_volume_options>();
    options.cache_bytes = cache_bytes;
    bccsplat_volume* v = nullptr;
    EXPECT_OK(bccsplat_volume_open_stream(device.get(), &stream, &options, &v));
    const Volume volume(v);
    file.forget();
    const auto plane = plane_of(0.1, 0.2, 0, 1, -14);
    bccsplat_slice* s = nullptr;
    EXPECT_OK(bccsplat_slice_create(v, &plane, nullptr, &s));
    const Slice slice(s);
    return file.reads.size();
  };
  const size_t kept = reads_of(0), anew = reads_of(1);
  EXPECT_LE(anew, 300 * kept); // 183; plane by plane it was 513
}

// Calls of several threads on one volume, each of which hears of what it lacks itself.
TEST(WouldBlock, InSeveralThreads) {
  FarFile file = noise_file([](auto&) {}, false);
  const Device device = make_device(3);
  const auto stream = file.stream();
  bccsplat_volume* v = nullptr;
  ASSERT_OK(bccsplat_volume_open_stream(device.get(), &stream, nullptr, &v));
  const Volume volume(v);
  std::vector<std::vector<float>> got(4), expected(4);
  const auto cut = [&](size_t i, std::vector<float>& values) {
    const auto plane = plane_of(0, 0, 0, 1, -3.0 * static_cast<double>(i) - 0.5);
    bccsplat_slice* s = nullptr;
    int tries = 0;
    bccsplat_status status;
    while ((status = bccsplat_slice_create(v, &plane, nullptr, &s)) == BCCSPLAT_ERROR_WOULD_BLOCK) {
      EXPECT_FALSE(lacking().empty());
      if (++tries == 1000) break;
    }
    ASSERT_EQ(status, BCCSPLAT_OK) << bccsplat_last_error();
    const Slice slice(s);
    values.resize(36 * 20 * 18);
    ASSERT_OK(bccsplat_slice_sample_grid(s, nullptr, values.data()));
  };
  file.blocks = true;
  std::vector<std::thread> threads;
  for (size_t i = 0; i < 4; ++i) threads.emplace_back([&, i] { cut(i, got[i]); });
  for (std::thread& t : threads) t.join();
  file.blocks = false;
  for (size_t i = 0; i < 4; ++i) {
    cut(i, expected[i]);
    EXPECT_EQ(got[i], expected[i]) << i;
  }
}

} // namespace
} // namespace host

// SPDX-License-Identifier: Apache-2.0
// A series written with coarser levels: what they hold, and that the bytes do not depend on how it is
// written.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>

#include <unistd.h>

#include "field/coefficients/coefficients.h"
#include "field/evaluate.h"
#include "formats/bcc4/read/samples.h"
#include "store/join.h"
#include "store/volume_writer.h"
#include "tests/unit/fit/fit_series.h"

namespace bccsplat {
namespace {

using test::Bench;
using test::Series;

namespace fs = std::filesystem;

class Levels : public testing::Test {
 protected:
  static constexpr std::array<uint32_t, 4> dims{30, 22, 24, 28};

  Levels() { fs::create_directories(folder_); }
  ~Levels() override { fs::remove_all(folder_); }

  static WriterSettings some_levels() {
    WriterSettings settings;
    settings.dims = dims, settings.levels = 2;
    settings.channels[0].range = Range{-0.3, 0.3}, settings.channels[0].value_type = ValueType::u8;
    return settings;
  }
  [[nodiscard]] std::string file(const std::string& name) const { return (folder_ / name).string(); }
  // Noise, which leaves the range here and there, so that samples of all levels are clamped.
  [[nodiscard]] FrameBox box(uint32_t t) const { return series_.box(t); }

  // Adds the frames up to `stop`, and finishes when those are all.
  void write(WriterSettings settings, const std::string& name, uint64_t stop = UINT64_MAX,
             int threads = 2) const {
    settings.path = file(name), settings.overwrite = true;
    Bench bench(threads);
    VolumeWriter writer(settings, nullptr, bench.context);
    const auto [first, end] = writer.given_frames();
    for (auto t = static_cast<uint32_t>(first); t < std::min(end, stop); ++t)
      for (uint32_t c = 0; c < settings.channels.size(); ++c) {
        const FrameBox frame = box(t);
        writer.add_frame(c, t, {&frame, 1});
      }
    if (stop >= end) (void)writer.finish();
  }
  static PartSettings part(uint32_t first, uint32_t end) {
    PartSettings part{SeriesBlock::of_frames(first, end), 0, {}};
    for (uint32_t t = 0; t < dims[3]; ++t) part.times.push_back(t);
    return part;
  }
  [[nodiscard]] std::vector<char> bytes(const std::string& name) const {
    std::ifstream in(file(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  [[nodiscard]] std::shared_ptr<Bcc4Reader> open(const std::string& name) const {
    return Bcc4Reader::open(open_file_source(file(name)));
  }

 private:
  const Series series_ = test::noise(dims, 3);
  const fs::path folder_ = fs::temp_directory_path() / ("bccsplat-levels-" + std::to_string(getpid()));
};

TEST_F(Levels, AreTheSeriesAtTwiceTheDistance) {
  write(some_levels(), "x");
  const auto reader = open("x");
  const VolumeInfo& info = reader->info();
  ASSERT_EQ(info.level_count(), 3);
  for (int l = 1; l < 3; ++l) {
    const Lattice4 &own = info.level(l).lattice, &finer = info.level(l - 1).lattice;
    EXPECT_EQ(own.dims, info.lattice.dims);
    EXPECT_EQ(own.last_layer, info.lattice.last_layer);
    EXPECT_EQ(own.lead, info.lattice.lead);
    for (size_t a = 0; a < 3; ++a) EXPECT_NEAR(own.space_step[a] / finer.space_step[a], 2, 0.3);
    const LevelChannel& counts = info.levels[static_cast<size_t>(l) - 1].channels[0];
    EXPECT_GT(static_cast<double>(counts.sites_kept), 0.98 * static_cast<double>(own.sites())) << "dense";
  }
  EXPECT_LT(reader->level_bytes(1) * 3, reader->level_bytes(0));
  Bench bench(2);
  for (const Bcc4Damage& d : reader->verify_all(bench.context).damage) ADD_FAILURE() << d.message;
}

// A wave of 24 samples is there at every level of 1, 2 and 4 samples, a constant exactly.
TEST_F(Levels, HoldWhatTheirLatticeCan) {
  const std::array<uint32_t, 4> n{48, 48, 48, 3};
  std::vector<float> wave(size_t{48} * 48 * 48);
  const auto value = [](double x, double y) { return 100 + 50 * std::sin(0.26 * x) * std::cos(0.2 * y); };
  for (size_t i = 0; i < wave.size(); ++i)
    wave[i] = static_cast<float>(value(static_cast<double>(i % 48), static_cast<double>(i / 48 % 48)));
  const std::vector<float> constant(wave.size(), 70.0f);
  WriterSettings settings;
  settings.dims = n, settings.levels = 2, settings.channels.resize(2);
  settings.channels[1].name = "constant";
  std::vector<std::byte> file;
  Bench bench(2);
  VolumeWriter writer(settings, create_memory_sink(file), bench.context);
  for (uint32_t t = 0; t < 3; ++t)
    for (uint32_t c = 0; c < 2; ++c) {
      FrameBox frame;
      frame.data = c == 0 ? wave.data() : constant.data(), frame.dims = {48, 48, 48};
      writer.add_frame(c, t, {&frame, 1});
    }
  (void)writer.finish();
  const auto reader = Bcc4Reader::open(open_memory_source(file));
  for (int l = 0; l < 3; ++l) {
    SCOPED_TRACE(l);
    const Bcc4Samples samples(reader, bench.memory, 64 << 20, RelativeTo::base, l);
    std::vector<Vec4> points;
    for (double x = 6; x < 42; x += 1.7) points.push_back({x, 47 - x, 0.5 * x + 7, 1});
    for (int c = 0; c < 2; ++c) {
      const Coefficients coefficients(samples, c, make_kernel(""), 0, 64 << 20);
      std::vector<float> out(points.size());
      const EvaluateMisses misses = evaluate4(coefficients, points, out, {}, bench.context);
      EXPECT_EQ(misses.outside + misses.holes, 0u);
      for (size_t i = 0; i < points.size(); ++i) {
        const double expected = c == 0 ? value(points[i][0], points[i][1]) : 70;
        EXPECT_NEAR(out[i], expected, c == 1 ? 0.01 : l == 2 ? 2.0 : 0.5) << points[i][0];
      }
    }
  }
}

TEST_F(Levels, NoneLeaveTheFileAsItWas) {
  WriterSettings settings = some_levels();
  settings.levels = 0;
  write(settings, "none");
  const auto none = open("none");
  EXPECT_EQ(none->info().level_count(), 1);
  write(some_levels(), "some");
  Bench bench(1);
  const Bcc4Samples a(none, bench.memory), b(open("some"), bench.memory);
  for (int32_t m = 0; m < a.lattice().layers(); m += 7) {
    const BrickLayer x = a.read_layer(0, m, {}, bench.context), y = b.read_layer(0, m, {}, bench.context);
    for (size_t s = 0; s < x.brick_slots(); ++s) ASSERT_EQ(x.brick(s)->value, y.brick(s)->value) << m;
  }
}

TEST_F(Levels, ResumedPartsAndAppendedTheBytesAreTheSame) {
  WriterSettings settings = some_levels();
  settings.channels.push_back(settings.channels[0]);
  settings.channels[1].name = "other";
  write(settings, "whole");
  const auto whole = bytes("whole");
  EXPECT_GT(open("whole")->info().levels[0].channels[0].clamped, 0u) << "what the tail has to tell of";
  write(settings, "one", UINT64_MAX, 1);
  EXPECT_EQ(bytes("one"), whole) << "one thread";

  WriterSettings again = settings;
  again.continuity = Continuity::journal;
  write(again, "resumed", 18);
  again.continuity = Continuity::resume;
  write(again, "resumed");
  EXPECT_EQ(bytes("resumed"), whole) << "resumed";

  std::vector<std::string> names;
  for (const uint32_t first : {0u, 9u, 18u}) {
    WriterSettings one = settings;
    one.part = part(first, first == 0 ? 9 : first == 9 ? 18 : dims[3]);
    names.push_back("part" + std::to_string(first));
    write(one, names.back());
  }
  Bench bench(1);
  for (std::string& name : names) name = file(name);
  (void)join_parts(open_parts(names), file("joined"), true, false, bench.context);
  EXPECT_EQ(bytes("joined"), whole) << "joined";

  WriterSettings shorter = settings;
  shorter.dims[3] = 22;
  write(shorter, "series");
  write(shorter, "series2");
  WriterSettings longer = settings;
  longer.levels = 0; // those of the file
  longer.continuity = Continuity::append;
  write(longer, "series2");
  EXPECT_EQ(bytes("series2"), whole) << "appended, all frames again";
  longer.part = part(22, dims[3]);
  write(longer, "series");
  EXPECT_EQ(bytes("series"), whole) << "appended, new frames alone";
}

// What the file says a level is off by is what a reader finds there.
TEST_F(Levels, ErrorsAreThoseOfTheLevel) {
  WriterSettings settings = some_levels();
  settings.measure = Measure::some;
  write(settings, "x");
  const auto reader = open("x");
  const VolumeInfo& info = reader->info();
  ASSERT_EQ(info.errors.size(), 3u);
  Bench bench(2);
  for (const MeasuredError& e : info.errors) {
    const int level = e.level;
    SCOPED_TRACE(level);
    EXPECT_EQ(e.level, static_cast<uint32_t>(&e - info.errors.data()));
    EXPECT_EQ(e.kind, MeasuredError::stored);
    EXPECT_EQ(e.frames, 3u);
    const uint32_t every = level == 0 ? 1 : (1u << level) + 1;
    const Bcc4Samples samples(reader, bench.memory, 64 << 20, RelativeTo::base, level);
    const Coefficients field(samples, 0, make_kernel(info.recommended_kernel), 0, 64 << 20);
    std::vector<Vec4> points;
    std::vector<double> source;
    for (const uint32_t t : {4u, 14u, 23u})
      for (uint32_t z = 0; z < dims[2]; z += every)
        for (uint32_t y = 0; y < dims[1]; y += every)
          for (uint32_t x = 0; x < dims[0]; x += every) {
            points.push_back({static_cast<double>(x), static_cast<double>(y), static_cast<double>(z),
                              static_cast<double>(t)});
            const FrameBox frame = box(t);
            source.push_back(static_cast<const float*>(frame.data)[(size_t{z} * dims[1] + y) * dims[0] + x]);
          }
    std::vector<float> values(points.size());
    (void)evaluate4(field, points, values, {}, bench.context);
    ErrorSum sum;
    for (size_t i = 0; i < values.size(); ++i) sum.add(values[i] - source[i]);
    EXPECT_EQ(e.samples, sum.count);
    EXPECT_NEAR(e.rmse, sum.rms(), 2e-3 * sum.rms());
    EXPECT_NEAR(e.largest, sum.largest, 2e-3 * sum.largest);
  }
  EXPECT_GT(info.errors[1].rmse, 0.02) << "noise, which levels do not hold";
}

TEST_F(Levels, PartsTellTheErrorsOfTheSeries) {
  WriterSettings settings = some_levels();
  settings.measure = Measure::some;
  write(settings, "whole");
  std::vector<std::string> names;
  for (const uint32_t first : {0u, 9u, 18u}) {
    WriterSettings one = settings;
    one.part = part(first, first == 0 ? 9 : first == 9 ? 18 : dims[3]);
    names.push_back(file("part" + std::to_string(first)));
    write(one, "part" + std::to_string(first));
  }
  Bench bench(1);
  (void)join_parts(open_parts(names), file("joined"), true, false, bench.context);
  ASSERT_EQ(open("whole")->info().errors.size(), 3u);
  EXPECT_EQ(bytes("joined"), bytes("whole"));
}

TEST_F(Levels, WhatWasMeasuredStaysWhenFramesComeBehind) {
  WriterSettings settings = some_levels();
  settings.measure = Measure::some, settings.dims[3] = 22;
  write(settings, "series");
  const auto before = open("series")->info().errors;
  ASSERT_EQ(before.size(), 3u);
  settings.dims[3] = dims[3], settings.continuity = Continuity::append;
  settings.part = part(22, dims[3]);
  write(settings, "series");
  EXPECT_EQ(open("series")->info().errors, before);
}

TEST_F(Levels, PartsOfAnotherNumberOfLevelsAreNotJoined) {
  WriterSettings settings = some_levels();
  settings.part = part(0, 20);
  write(settings, "a");
  settings.levels = 1, settings.part = part(20, dims[3]);
  write(settings, "b");
  EXPECT_THROW((void)open_parts({file("a"), file("b")}), Error);
}

TEST_F(Levels, MasksAreToldOnce) {
  Bench bench(2);
  std::vector<std::byte> out;
  WriterSettings settings;
  settings.dims = {20, 21, 22, 4}, settings.levels = 2, settings.nonfinite = NonFinite::hole;
  VolumeWriter writer(settings, create_memory_sink(out), bench.context);
  std::vector<float> values(size_t{20} * 21 * 22, 5.0f);
  std::fill_n(values.begin(), 700, std::numeric_limits<float>::quiet_NaN());
  for (uint32_t t = 0; t < 4; ++t) {
    FrameBox frame;
    frame.data = values.data(), frame.dims = {20, 21, 22};
    writer.add_frame(0, t, {&frame, 1});
  }
  (void)writer.finish();
  const auto reader = Bcc4Reader::open(open_memory_source(out));
  uint64_t missing = 0;
  reader->mask_runs(0, 2, [&](uint64_t begin, uint64_t end) { missing += end - begin; });
  EXPECT_EQ(missing, 700u);
  for (const LevelInfo& level : reader->info().levels) EXPECT_EQ(level.channels[0].holes, 0u);
  for (const Bcc4Damage& d : reader->verify_all(bench.context).damage) ADD_FAILURE() << d.message;
}

TEST_F(Levels, WhatHasNoFramesIsRefused) {
  Bench bench(1);
  const auto refused = [&](const WriterSettings& settings, const char* text, bool layers) {
    std::vector<std::byte> out;
    try {
      VolumeWriter writer(settings, create_memory_sink(out), bench.context);
      if (layers) writer.add_layer(0, 0, std::vector<float>(8));
      ADD_FAILURE() << "was accepted";
    } catch (const Error& e) {
      EXPECT_NE(e.message().find(text), std::string::npos) << e.message();
    }
  };
  WriterSettings settings;
  settings.dims = {8, 8, 8, 3}, settings.levels = 1;
  refused(settings, "coarser levels are made of frames", true);
  settings.levels = 16;
  refused(settings, "16 coarser levels, not 0 to 15", false);
}

} // namespace
} // namespace bccsplat

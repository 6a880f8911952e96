// SPDX-License-Identifier: Apache-2.0
// The order of a writer's calls, and settings that contradict each other.
#include "store/volume_writer.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/fit/fit_series.h"

namespace bccsplat {
namespace {

using test::Bench;
using test::noise;
using test::Series;

template<class Body> Code code_of(const Body& body) {
  try {
    body();
    return Code::ok;
  } catch (const Error& e) {
    return e.code();
  }
}

struct Writing : Bench {
  explicit Writing(const Series& source) : series(source) { settings.dims = source.dims; }

  // The writer of a stream into `bytes`.
  VolumeWriter& writer() {
    if (!made) made = std::make_unique<VolumeWriter>(settings, create_memory_sink(bytes), context);
    return *made;
  }
  Code create() {
    return code_of([&] { (void)writer(); });
  }
  Code add_frame(uint32_t t, double time, uint32_t channel = 0) {
    const FrameBox box = series.box(t);
    return code_of([&] { writer().add_frame(channel, time, {&box, 1}); });
  }
  Code add_layer(int64_t layer) {
    const Int3 n = Lattice4::fit(LatticeKind::d4star, series.dims).space.dims(0);
    const std::vector<float> ones(static_cast<size_t>(n[0]) * n[1] * n[2], 1.0f);
    return code_of([&] { writer().add_layer(0, layer, ones); });
  }
  Code finish() {
    return code_of([&] { (void)writer().finish(); });
  }

  const Series& series;
  WriterSettings settings;
  std::vector<std::byte> bytes;
  std::unique_ptr<VolumeWriter> made;
};

class VolumeWriterOrder : public testing::Test {
 protected:
  const Series series = noise({6, 6, 6, 3}, 1);
};

TEST_F(VolumeWriterOrder, FramesInOrderMakeAFile) {
  Writing w(series);
  for (uint32_t t = 0; t < 3; ++t) EXPECT_EQ(w.add_frame(t, t), Code::ok);
  const WriteReport report = w.writer().finish();
  EXPECT_EQ(report.frames, 3u);
  EXPECT_EQ(report.cc_samples, 6u * 6 * 6 * 3);
  EXPECT_EQ(report.bytes.file, w.bytes.size());
  EXPECT_EQ(Bcc4Reader::open(open_memory_source(w.bytes))->info().lattice.dims, series.dims);
  // A finished writer takes nothing more.
  EXPECT_EQ(w.add_frame(2, 3), Code::wrong_state);
  EXPECT_EQ(w.finish(), Code::wrong_state);
  EXPECT_EQ(code_of([&] { w.writer().set_times(0, 1); }), Code::wrong_state);
}

TEST_F(VolumeWriterOrder, FramesAndLayersDoNotMix) {
  Writing frames(series), layers(series);
  EXPECT_EQ(frames.add_frame(0, 0), Code::ok);
  EXPECT_EQ(frames.add_layer(1), Code::wrong_state);
  EXPECT_EQ(layers.add_layer(0), Code::ok);
  EXPECT_EQ(layers.add_frame(0, 0), Code::wrong_state);
}

TEST_F(VolumeWriterOrder, AFrameTooManyOrTooFew) {
  Writing many(series), few(series), none(series);
  for (uint32_t t = 0; t < 3; ++t) EXPECT_EQ(many.add_frame(t, t), Code::ok);
  EXPECT_EQ(many.add_frame(0, 3), Code::wrong_state);
  EXPECT_EQ(few.add_frame(0, 0), Code::ok);
  EXPECT_EQ(few.finish(), Code::wrong_state);
  EXPECT_EQ(none.finish(), Code::wrong_state);
}

TEST_F(VolumeWriterOrder, TimesRiseAndChannelsAgree) {
  for (const double second : {0.0, -1.0, std::nan(""), static_cast<double>(INFINITY)}) {
    Writing w(series);
    EXPECT_EQ(w.add_frame(0, 0), Code::ok);
    EXPECT_EQ(w.add_frame(1, second), Code::invalid_argument) << second;
    EXPECT_EQ(w.add_frame(1, 1), Code::ok); // the writer is as it was
  }
  Writing two(series);
  two.settings.channels.resize(2);
  two.settings.channels[1].name = "other";
  EXPECT_EQ(two.add_frame(0, 7), Code::ok);
  EXPECT_EQ(two.add_frame(0, 7, 2), Code::not_found);
  EXPECT_EQ(two.add_frame(0, 7, 1), Code::ok); // naming no channel has harmed nothing
  EXPECT_EQ(two.add_frame(1, 8), Code::ok);
  EXPECT_EQ(two.add_frame(1, 9, 1), Code::invalid_argument);
}

TEST_F(VolumeWriterOrder, LayersComeOneByOne) {
  Writing w(series), twice(series);
  EXPECT_EQ(w.add_layer(0), Code::ok);
  EXPECT_EQ(w.add_layer(2), Code::wrong_state);
  const Field constant = [](std::span<const double>, std::span<float> values) {
    std::fill(values.begin(), values.end(), 2.0f);
    return true;
  };
  twice.writer().add_field(0, constant);
  const int64_t layers = twice.writer().layer_geometry(0).layers;
  EXPECT_EQ(twice.add_layer(layers), Code::wrong_state); // one too many
  Writing again(series);
  again.writer().add_field(0, constant);
  EXPECT_EQ(code_of([&] { again.writer().add_field(0, constant); }), Code::wrong_state);
  EXPECT_EQ(code_of([&] { (void)again.writer().layer_geometry(layers); }), Code::not_found);
  Writing unknown(series);
  unknown.settings.dims[3] = 0;
  EXPECT_EQ(unknown.add_layer(0), Code::wrong_state);
}

TEST_F(VolumeWriterOrder, APartTakesItsFrames) {
  const Series longer = noise({6, 6, 6, 40}, 2);
  Writing w(longer);
  PartSettings part{SeriesBlock::of_frames(0, 20), 0, {}};
  for (int t = 0; t < 40; ++t) part.times.push_back(t);
  w.settings.part = part;
  const auto [first, end] = w.writer().given_frames();
  EXPECT_EQ(first, 0u);
  ASSERT_GT(end, 20u); // frames in reach of its last layers
  for (auto t = static_cast<uint32_t>(first); t < end; ++t) ASSERT_EQ(w.add_frame(t, t), Code::ok);
  EXPECT_EQ(w.add_frame(30, static_cast<double>(end)), Code::wrong_state);
}

TEST_F(VolumeWriterOrder, WhatTheHostSaysComesBack) {
  Writing w(series);
  w.writer().set_attribute("key", "first");
  EXPECT_EQ(w.add_frame(0, 10), Code::ok);
  w.writer().set_attribute("key", "second"); // at any time before finish
  w.writer().add_source({"source", 5, 6});
  for (uint32_t t = 1; t < 3; ++t) EXPECT_EQ(w.add_frame(t, 10 + 2 * t), Code::ok);
  EXPECT_EQ(w.finish(), Code::ok);
  const auto reader = Bcc4Reader::open(open_memory_source(w.bytes));
  ASSERT_EQ(reader->info().attributes.size(), 1u);
  EXPECT_EQ(reader->info().attributes[0].second, "second");
  ASSERT_EQ(reader->info().sources.size(), 1u);
  EXPECT_EQ(reader->info().sources[0], (SourceInfo{"source", 5, 6}));
  EXPECT_TRUE(reader->info().time.uniform);
  EXPECT_EQ(reader->info().time.at(2), 14);
}

TEST_F(VolumeWriterOrder, TextsFitIntoWhatReadersTake) {
  Writing w(series);
  const std::string large(12u << 20, 'x');
  const auto attribute = [&](const char* key, const std::string& value) {
    return code_of([&] { w.writer().set_attribute(key, value); });
  };
  EXPECT_EQ(attribute("a", large), Code::ok);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(attribute("b", large), Code::ok); // one counts
  EXPECT_EQ(attribute("c", large), Code::limit_exceeded);
  EXPECT_EQ(attribute("b", large + large), Code::limit_exceeded);
  EXPECT_EQ(code_of([&] { w.writer().add_source({large, 5, 6}); }), Code::limit_exceeded);
  EXPECT_EQ(attribute("b", ""), Code::ok);
  EXPECT_EQ(attribute("c", large), Code::ok);
  for (uint32_t t = 0; t < 3; ++t) EXPECT_EQ(w.add_frame(t, t), Code::ok); // the writer is as it was
  EXPECT_EQ(w.finish(), Code::ok);
  const auto reader = Bcc4Reader::open(open_memory_source(w.bytes));
  EXPECT_EQ(reader->info().attributes.size(), 3u);
  EXPECT_TRUE(reader->info().sources.empty());
}

TEST_F(VolumeWriterOrder, ErrorsAreKnownAfterFinish) {
  Writing w(series);
  w.settings.measure = Measure::all;
  for (uint32_t t = 0; t < 3; ++t) EXPECT_EQ(w.add_frame(t, t), Code::ok);
  EXPECT_EQ(code_of([&] { (void)w.writer().measured(0, -1); }), Code::wrong_state);
  EXPECT_EQ(w.finish(), Code::ok);
  EXPECT_EQ(w.writer().measured(0, -1).errors.all.count, 6u * 6 * 6 * 3);
  EXPECT_EQ(w.writer().measured(0, 2).frame, 2u);
  EXPECT_EQ(code_of([&] { (void)w.writer().measured(0, 3); }), Code::not_found);
  EXPECT_EQ(code_of([&] { (void)w.writer().measured(1, 0); }), Code::not_found);
}

TEST_F(VolumeWriterOrder, SettingsThatContradict) {
  const auto refused = [&](const auto& change) {
    Writing w(series);
    change(w.settings);
    return w.create() == Code::invalid_argument;
  };
  EXPECT_FALSE(refused([](WriterSettings&) {}));
  EXPECT_TRUE(refused([](WriterSettings& s) { s.dims[1] = 0; }));
  EXPECT_TRUE(refused([](WriterSettings& s) { s.lattice = LatticeKind::bcc; })); // three frames
  EXPECT_TRUE(refused([](WriterSettings& s) { s.lattice = LatticeKind::cc, s.lowpass = true; }));
  EXPECT_TRUE(refused([](WriterSettings& s) { s.channels[0].abs_error = -1; }));
  EXPECT_TRUE(refused([](WriterSettings& s) { s.psnr = std::nan(""); }));
  EXPECT_TRUE(refused([](WriterSettings& s) { s.dims[3] = 0, s.psnr = 40; }));
  EXPECT_TRUE(refused([](WriterSettings& s) { s.dims[3] = 0, s.wavelets = true; }));
  EXPECT_TRUE(refused([](WriterSettings& s) { s.channels.resize(2); })); // of one name
  EXPECT_TRUE(refused([](WriterSettings& s) { s.channels[0].name.clear(); }));
  EXPECT_TRUE(refused([](WriterSettings& s) { s.channels[0].threshold = -1; }));
  EXPECT_TRUE(refused([](WriterSettings& s) { s.channels[0].range = Range{1, 1}; }));
  EXPECT_TRUE(refused([](WriterSettings& s) {
    s.part = PartSettings{SeriesBlock::of_frames(0, 4), 0, {0, 1, 2}};
  }));
  EXPECT_TRUE(refused([](WriterSettings& s) {
    s.part = PartSettings{SeriesBlock::of_frames(0, 2), 0, {0, 1, 1}};
  }));
}

} // namespace
} // namespace bccsplat

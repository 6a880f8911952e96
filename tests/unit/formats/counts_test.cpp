// SPDX-License-Identifier: Apache-2.0
// Files whose checksums are right and whose counts are not: they are refused when they are opened, or where
// the count is read, and nothing is allocated for what cannot be there.
#include <gtest/gtest.h>

#include "formats/bcc4/coding/tile.h"
#include "formats/bcc4/counts.h"
#include "slice/turned_samples.h"
#include "tests/unit/formats/rebuild.h"
#include "tests/unit/formats/test_data.h"

namespace bccsplat {
namespace {

using namespace test;

Bytes series_file(LatticeKind kind = LatticeKind::cc) {
  return write_file(volume(kind, {20, 18, 16, 6}, {channel("a", ValueType::u8)}), ball);
}

void expect_refused(const Bytes& file, Code code, const std::string& text) {
  try {
    (void)Bcc4Reader::open(open_memory_source(file));
    ADD_FAILURE() << "opened in spite of: " << text;
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), code) << e.message();
    EXPECT_NE(e.message().find(text), std::string::npos) << text << " expected: " << e.message();
  }
}

TEST(Bcc4Counts, LayersFollowFromFramesAndDistance) {
  for (const LatticeKind kind : {LatticeKind::cc, LatticeKind::d4star}) {
    const Bytes good = series_file(kind);
    const auto layers = [&](Code code, const char* text, const std::function<void(Lattice4&)>& change) {
      expect_refused(rebuild(good, with_info([&](VolumeInfo& v) { change(v.lattice); })), code, text);
    };
    const Lattice4 was = Bcc4Reader::open(open_memory_source(good))->info().lattice;
    layers(Code::corrupt, "the last frame is 5", [](Lattice4& l) { l.last_layer = 268'435'461; });
    layers(Code::corrupt, "the last frame is 5",
           [&](Lattice4& l) { l.last_layer = static_cast<int32_t>(6 / was.time_step) + most_beyond + 2; });
    layers(Code::corrupt, "distance of layers",
           [](Lattice4& l) { l.time_step = 1e-8, l.last_layer = 500'000'000; });
    // As many frames may be; no reader goes through so many layers.
    layers(Code::limit_exceeded, "along an axis, the limit is", [&](Lattice4& l) {
      l.dims[3] = 400'000'000, l.last_layer = static_cast<int32_t>(4e8 / was.time_step) + 2;
    });
    // What a lead takes before the first frame is as good behind the last one.
    const Bytes more =
        rebuild(good, with_info([](VolumeInfo& v) { v.lattice.last_layer += most_beyond - 1; }));
    EXPECT_NO_THROW((void)Bcc4Reader::open(open_memory_source(more)));
  }
}

TEST(Bcc4Counts, NoWriterMakesASeriesThatReadersRefuse) {
  VolumeInfo info = volume(LatticeKind::cc, {4, 4, 4, 20'000'000}, {channel("a", ValueType::u8)});
  Bench bench;
  Bytes bytes;
  Bcc4Writer writer(create_memory_sink(bytes), info);
  try {
    writer.finish(bench.context);
    ADD_FAILURE() << "written";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), Code::limit_exceeded) << e.message();
  }
}

TEST(Bcc4Counts, PlanesFollowFromSamplesAndDistance) {
  const Bytes good = write_file(volume(LatticeKind::cc, {20, 1, 16, 6}, {channel("a", ValueType::u8)}), ball);
  const auto planes = [&](const char* text, const std::function<void(Lattice4&)>& change) {
    expect_refused(rebuild(good, with_info([&](VolumeInfo& v) { change(v.lattice); })), Code::corrupt, text);
  };
  planes("which has one sample", [](Lattice4& l) { l.space.last[1] = 1'000'000; });
  planes("distance of planes", [](Lattice4& l) { l.space_step[1] = 1e9; });
  planes("distance of planes",
         [](Lattice4& l) { l.space_step[0] = 19 / 2e8, l.space.last[0] = 200'000'000; });
}

// Lists that have an element for each of something, told with another number of them.
TEST(Bcc4Counts, ListsAreWholeOrEmpty) {
  const Bytes good = series_file();
  const auto refused = [&](const char* text, const std::function<void(VolumeInfo&)>& change) {
    expect_refused(rebuild(good, with_info(change)), Code::corrupt, text);
  };
  refused("7 times for 6 frames",
          [](VolumeInfo& v) { v.time.uniform = false, v.time.times = {1, 2, 3, 4, 5, 6, 7}; });
  refused("5 ranges for 6 frames", [](VolumeInfo& v) { v.channels[0].frames.resize(5); });
  refused("255 counts for 256 bins", [](VolumeInfo& v) { v.channels[0].histogram.resize(255); });
  refused("19 coordinates for 20 samples", [](VolumeInfo& v) {
    for (int i = 0; i < 19; ++i) v.axes[0].coordinates.push_back(i * i);
  });
  refused("7 blocks for 6 frames", [](VolumeInfo& v) { v.channels[0].masks.resize(7); });
  refused("4 measured errors, there are at most 3", [](VolumeInfo& v) { v.errors.resize(4); });
  refused("stands twice", [](VolumeInfo& v) {
    for (int i = 0; i < 1000; ++i) v.attributes.emplace_back("key", "");
  });
}

TEST(Bcc4Counts, ChunksAndPagesHaveBytes) {
  const Bytes good = series_file();
  const auto root = [&](const char* text, const std::function<void(Root&)>& change) {
    expect_refused(rebuild(good, {.root = change}), Code::corrupt, text);
  };
  root("chunks of", [](Root& r) { r.chunks = r.values_bytes + 1; });
  root("chunks of", [](Root& r) { r.chunks = r.file_bytes; });
  root("pages of 0 chunks", [](Root& r) { r.chunks = 0; });
}

TEST(Bcc4Counts, DeflatedPartsHaveEnoughBytes) {
  const Bytes good = series_file();
  for (const auto& change : std::vector<std::function<void(Bcc4Chunk&)>>{
           [](Bcc4Chunk& c) { c.values_bytes = (c.kept - 1) / 1032, c.coding = 1; },
           [](Bcc4Chunk& c) { c.runs_bytes = 1, c.runs_decoded = 2000, c.coding |= 16; }}) {
    const Bytes bad = rebuild(good, {.entries = [&](std::vector<Bcc4Chunk>& page) { change(page[0]); }});
    const auto reader = Bcc4Reader::open(open_memory_source(bad));
    EXPECT_THROW((void)reader->chunks(0, 0), Error);
  }
}

// A mask, corrections and their tables decode to no more than their frame has a use for.
TEST(Bcc4Counts, BlocksOfFramesAreNoLargerThanFrames) {
  EXPECT_EQ(most_run_bytes(100), 101u);
  EXPECT_EQ(most_run_bytes(100, 50, 3), 152u);
  const Bytes good = corrected_file();
  const uint64_t size = good.size();
  // Zeros in place of corrections, more of them than any brick has.
  const PackedBlock zeros = pack_block(Bytes(64 << 20));
  Bytes longer = good;
  longer.insert(longer.end(), zeros.bytes.begin(), zeros.bytes.end());
  for (const bool mask : {false, true}) {
    const Bytes bad = rebuild(longer, with_info([&](VolumeInfo& v) {
                                BlockRef ref = zeros.ref;
                                ref.offset = size;
                                ChannelInfo& c = v.channels[0];
                                if (mask) c.masks.assign(3, ref);
                                c.residuals.tables[0] = ref;
                              }));
    const auto reader = Bcc4Reader::open(open_memory_source(bad));
    try {
      if (mask)
        reader->mask_runs(0, 0, [](uint64_t, uint64_t) {});
      else
        (void)reader->correction_bricks(0, 0);
      ADD_FAILURE() << "read";
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), Code::corrupt);
      EXPECT_NE(e.message().find("at most"), std::string::npos) << e.message();
    }
  }
}

// One value everywhere: 2 million sites in some dozen bytes.
Bytes tile_of_one_value() {
  VolumeInfo info = volume(LatticeKind::cc, {64, 64, 64, 8}, {channel("a", ValueType::u16)});
  info.tile_edge = 4, info.slab_layers = 8;
  info.channels[0].wavelet_error = .2;
  return write_file(info, [](int, double, double, double, double) { return Sample{100, true, false}; });
}

TEST(Bcc4Counts, ATileTakesWhatItDecodesToFromTheBudget) {
  const Bytes file = tile_of_one_value();
  EXPECT_LT(file.size(), 14'000u);
  const auto reader = Bcc4Reader::open(open_memory_source(file));
  const uint64_t needed = reader->decoding_bytes(0, reader->chunks(0, 0).at(0));
  EXPECT_GT(needed, 64u * 64 * 64 * 8 * sizeof(float));
  const auto code_of = [&](uint64_t budget, const auto& look) {
    Bench bench(2, budget);
    try {
      look(bench);
      EXPECT_GE(bench.memory.peak(), needed);
      return Code::ok;
    } catch (const Error& e) {
      return e.code();
    }
  };
  const auto verify = [&](Bench& bench) { EXPECT_TRUE(reader->verify_all(bench.context).damage.empty()); };
  const auto read = [&](Bench& bench) {
    const Bcc4Samples samples(reader, bench.memory);
    (void)samples.read_layer(0, 3, {}, bench.context);
  };
  EXPECT_EQ(code_of(needed - 1, verify), Code::memory_budget);
  EXPECT_EQ(code_of(needed, verify), Code::ok);
  EXPECT_EQ(code_of(needed - 1, read), Code::memory_budget);
  EXPECT_EQ(code_of(2 * needed, read), Code::ok);
}

// Whoever decodes a tile rounds into the range that the index tells, so that a wider one shows only in what
// no code reaches.
TEST(Bcc4Counts, TheRangeOfATileIsItsOwn) {
  VolumeInfo info = volume(LatticeKind::cc, {70, 41, 37, 9}, {channel("a", ValueType::u16, 3)});
  info.tile_edge = 2, info.slab_layers = 6, info.channels[0].wavelet_error = .2;
  const Bytes good = write_file(info, dense);
  for (const bool low : {false, true}) {
    const Bytes bad = rebuild(good, {.entries = [&](std::vector<Bcc4Chunk>& page) {
                                if (low)
                                  page[1].min_code -= 2000;
                                else
                                  page[1].max_code += 2000;
                              }});
    Bench bench;
    bool found = false;
    for (const auto& d : Bcc4Reader::open(open_memory_source(bad))->verify_all(bench.context).damage)
      found |= d.message.find("the index says") != std::string::npos;
    EXPECT_TRUE(found) << low;
  }
}

// The planes that a cut across an axis is made of take their slots from the budget before they are there.
TEST(Bcc4Counts, ALongSeriesIsCutWithinTheBudget) {
  VolumeInfo info = volume(LatticeKind::cc, {20, 18, 16, 60'000}, {channel("a", ValueType::u8)});
  Bytes bytes;
  Bench bench;
  Bcc4Writer writer(create_memory_sink(bytes), info);
  VolumeInfo first = info;
  first.lattice.dims[3] = 8, first.lattice.last_layer = 7;
  writer.write_slab(0, 0, make_layers(first, 0, ball), bench.context);
  writer.finish(bench.context);
  const auto reader = Bcc4Reader::open(open_memory_source(bytes));
  const auto cut = [&](uint64_t budget) {
    Bench small(1, budget);
    const Bcc4Samples samples(reader, small.memory, 1 << 20);
    const TurnedSamples turned(samples, 0, 0, 3, 8, small.context);
    EXPECT_TRUE(turned.read_layer(0, 5, {}, small.context).bricks() > 0);
  };
  EXPECT_THROW(cut(1 << 20), Error);
  EXPECT_NO_THROW(cut(64 << 20));
}

} // namespace
} // namespace bccsplat

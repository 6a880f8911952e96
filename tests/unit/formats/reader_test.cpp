// SPDX-License-Identifier: Apache-2.0
// Reading only what is needed, caches, large offsets, many threads, and the writer's own rules.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <map>
#include <random>
#include <thread>

#include "formats/bcc4/layout.h"
#include "formats/bcc4/page.h"
#include "tests/unit/formats/test_data.h"

namespace bccsplat {
namespace {

using namespace test;

// A few kept sites in every brick, anywhere.
BrickLayer specks(const Lattice4& lattice, int32_t m, std::mt19937& random) {
  BrickLayer layer(lattice.space, lattice.coset(m));
  for (size_t s = 0; s < layer.brick_slots(); ++s) {
    auto brick = std::make_shared<Brick>();
    for (int i = 0; i < 5; ++i) brick->value[random() % 16] = static_cast<float>(1 + random() % 100);
    brick->keep_above(0);
    layer.set(s, std::move(brick));
  }
  return layer;
}

TEST(Bcc4Reader, OpeningReadsRootsAndMetadataOnly) {
  VolumeInfo info = volume(LatticeKind::d4star, {180, 180, 180, 80}, {channel("a", ValueType::u8)});
  info.slab_layers = 4;
  Bench bench;
  std::vector<std::byte> file;
  Bcc4Writer writer(create_memory_sink(file), info);
  std::mt19937 random(9);
  for (int32_t s = 0; s < info.slabs(); ++s) {
    std::vector<BrickLayer> layers;
    for (int32_t m = 4 * s; m < std::min(4 * s + 4, info.lattice.layers()); ++m)
      layers.push_back(specks(info.lattice, m, random));
    writer.write_slab(s, 0, layers, bench.context);
  }
  const Bcc4Report report = writer.finish(bench.context);
  ASSERT_GT(report.chunks, 2 * page_entries); // several pages
  const auto reader = Bcc4Reader::open(open_memory_source(file));
  // What is read at once does not hold the entries of chunks.
  const uint64_t opened = reader->bytes_read();
  EXPECT_LT(opened, preamble_bytes + 1000);
  EXPECT_GT(report.bytes.index, opened + 20'000);

  const auto chunks = reader->chunks(0, 7);
  EXPECT_GT(chunks.size(), 300u);
  const uint64_t page = reader->bytes_read() - opened;
  EXPECT_LT(page, report.bytes.index / 2); // one page, or two
  static_cast<void>(reader->chunks(0, 7));
  EXPECT_EQ(reader->bytes_read() - opened, page); // at hand now
}

TEST(Bcc4Reader, ALayerReadsTheChunksOfItsSlabOnly) {
  const VolumeInfo info = volume(LatticeKind::d4star, {60, 40, 40, 40},
                                 {channel("a", ValueType::u16), channel("b", ValueType::u16)});
  const auto file = write_file(info, dense);
  const auto reader = Bcc4Reader::open(open_memory_source(file));
  Bench bench;
  const Bcc4Samples samples(reader, bench.memory);
  uint64_t wanted = 0;
  for (const Bcc4Chunk& c : reader->chunks(1, 3)) wanted += c.stored();
  const uint64_t before = reader->bytes_read();
  static_cast<void>(samples.read_layer(1, 3 * 8 + 5, {}, bench.context));
  EXPECT_EQ(reader->bytes_read() - before, wanted);
  EXPECT_LT(wanted, file.size() / 8);
  // Another layer of the slab is there already.
  static_cast<void>(samples.read_layer(1, 3 * 8 + 2, {}, bench.context));
  EXPECT_EQ(reader->bytes_read() - before, wanted);
  EXPECT_EQ(samples.chunks_decoded(), reader->chunks(1, 3).size());
}

// Of codes, what was handed over is held by those who have it.
TEST(Bcc4Reader, LayersThatWereHandedOverAreNotHeldAsWell) {
  const VolumeInfo info = volume(LatticeKind::d4star, {60, 40, 40, 40}, {channel("a", ValueType::u8)});
  const auto file = write_file(info, dense);
  const auto reader = Bcc4Reader::open(open_memory_source(file));
  Bench bench;
  const Bcc4Samples samples(reader, bench.memory);
  const auto hand_over = [&](int32_t layer) {
    samples.read_samples(0, std::span(&layer, 1), {}, bench.context, [](int32_t, SampleLayer&&) {});
    return bench.memory.used();
  };
  const uint64_t seven = hand_over(8), sites = info.lattice.space.sites(0);
  EXPECT_GT(seven, 7 * sites);
  uint64_t before = seven;
  for (int32_t layer = 9; layer < 15; ++layer) {
    const uint64_t held = hand_over(layer);
    EXPECT_LT(held + sites, before) << layer;
    before = held;
  }
  EXPECT_EQ(hand_over(15), 0u);
  EXPECT_EQ(samples.chunks_decoded(), reader->chunks(0, 1).size());
  // Who did not keep one asks for it again.
  EXPECT_EQ(hand_over(8), seven);
  EXPECT_EQ(samples.chunks_decoded(), 2 * reader->chunks(0, 1).size());
}

TEST(Bcc4Reader, ARegionReadsItsChunksOnly) {
  const VolumeInfo info = volume(LatticeKind::d4star, {90, 60, 40, 9}, {channel("a", ValueType::u16)});
  const Layers layers = make_volume(info, dense);
  const auto file = write_file(info, layers);
  const auto reader = Bcc4Reader::open(open_memory_source(file));
  Bench bench;
  const Bcc4Samples samples(reader, bench.memory);
  const BrickBox region{{1, 0, 1}, {3, 2, 2}};
  const BrickLayer part = samples.read_layer(0, 4, region, bench.context);
  const BrickLayer whole = read_all(file)[0][4];
  EXPECT_EQ(samples.chunks_decoded(), 4u);
  for (size_t s = 0; s < whole.brick_slots(); ++s) {
    const bool inside = region.contains(whole.slot_position(s));
    ASSERT_EQ(part.brick(s) != nullptr, inside && whole.brick(s)) << s;
    if (inside) {
      EXPECT_EQ(part.brick(s)->value, whole.brick(s)->value);
    }
  }
}

TEST(Bcc4Reader, ChunkRangesHoldTheSamples) {
  const VolumeInfo info = volume(LatticeKind::d4star, {40, 40, 40, 9},
                                 {channel("a", ValueType::u8, 3), channel("b", ValueType::f16, -1)});
  const auto file = write_file(info, ball);
  const auto reader = Bcc4Reader::open(open_memory_source(file));
  Bench bench;
  for (int c = 0; c < 2; ++c)
    for (int32_t s = 0; s < info.slabs(); ++s)
      for (const Bcc4Chunk& chunk : reader->chunks(c, s)) {
        const auto data = reader->read_chunks(c, std::span(&chunk, 1), bench.context);
        const Range range = reader->sample_range(c, chunk);
        double low = INFINITY, high = -INFINITY;
        uint32_t kept = 0, holes = 0;
        for (int m = 0; m < std::min(8, info.lattice.layers() - 8 * s); ++m) {
          const auto brick = reader->brick(c, *data[0], m);
          for (int i = 0; brick && i < brick_sites; ++i) {
            if (!(brick->kept[i / 16] >> (i % 16) & 1)) continue;
            ++kept, holes += brick->is_hole(i);
            low = std::min<double>(low, brick->value[i]);
            high = std::max<double>(high, brick->value[i]);
          }
        }
        EXPECT_EQ(range.low, low);
        EXPECT_EQ(range.high, high);
        EXPECT_EQ(chunk.kept, kept);
        EXPECT_EQ(chunk.holes, holes);
      }
}

TEST(Bcc4Reader, TheCacheKeepsToItsBudget) {
  const VolumeInfo info = volume(LatticeKind::d4star, {40, 40, 20, 20}, {channel("a", ValueType::f32)});
  const auto file = write_file(info, dense);
  const Layers expected = read_all(file);
  for (const uint64_t budget : {uint64_t{0}, uint64_t{150'000}, uint64_t{1} << 30})
    for (const uint64_t cache : {uint64_t{0}, uint64_t{150'000}, uint64_t{1} << 30}) {
      Bench bench(2, budget);
      {
        const Bcc4Samples samples(Bcc4Reader::open(open_memory_source(file)), bench.memory, cache);
        for (int32_t m = 0; m < info.lattice.layers(); ++m) {
          EXPECT_FALSE(difference(expected[0][m], samples.read_layer(0, m, {}, bench.context)));
          EXPECT_LE(bench.memory.used(), std::min(budget, cache));
        }
        uint64_t chunks = 0;
        for (int32_t s = 0; s < info.slabs(); ++s) chunks += samples.reader().chunks(0, s).size();
        if (budget > 1'000'000 && cache > 1'000'000) {
          EXPECT_EQ(samples.chunks_decoded(), chunks);
        } else {
          EXPECT_GT(samples.chunks_decoded(), chunks);
        }
      }
      EXPECT_EQ(bench.memory.used(), 0u);
    }
}

TEST(Bcc4Reader, ManyThreadsReadOneFile) {
  const VolumeInfo info = volume(LatticeKind::d4star, {40, 40, 40, 20}, {channel("a", ValueType::u16)});
  const auto file = write_file(info, ball);
  const Layers expected = read_all(file);
  Bench bench(2);
  const Bcc4Samples samples(Bcc4Reader::open(open_memory_source(file)), bench.memory, 300'000);
  std::atomic<int> wrong{0};
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&, t] {
      for (int i = 0; i < 60; ++i) {
        const int32_t m = (i * (t + 3)) % info.lattice.layers();
        if (difference(expected[0][m], samples.read_layer(0, m, {}, bench.context))) ++wrong;
      }
    });
  for (auto& t : threads) t.join();
  EXPECT_EQ(wrong, 0);
}

// Holds what was written and zeros elsewhere, of any size.
struct SparseFile {
  std::map<uint64_t, std::vector<std::byte>> parts;
  uint64_t size = 0;

  std::unique_ptr<ByteSink> sink() {
    return create_stream_sink([this](uint64_t offset, std::span<const std::byte> bytes) {
      parts[offset].assign(bytes.begin(), bytes.end());
      size = std::max(size, offset + bytes.size());
      return static_cast<int64_t>(bytes.size());
    });
  }
  std::unique_ptr<ByteSource> source() const {
    return open_stream_source(size, [this](uint64_t offset, std::span<std::byte> out) {
      std::fill(out.begin(), out.end(), std::byte{0});
      for (const auto& [at, bytes] : parts) {
        const uint64_t first = std::max(at, offset), end = std::min(at + bytes.size(), offset + out.size());
        if (first < end)
          std::copy_n(bytes.begin() + (first - at), end - first, out.begin() + (first - offset));
      }
      return static_cast<int64_t>(out.size());
    });
  }
};

TEST(Bcc4Reader, OffsetsBeyondFourGigabytes) {
  const VolumeInfo info = volume(LatticeKind::d4star, {40, 30, 30, 20}, {channel("a", ValueType::u16)});
  const Layers layers = make_volume(info, ball);
  const Layers expected = read_all(write_file(info, layers));
  SparseFile file;
  Bench bench;
  const uint64_t start = 6'000'000'000'000;
  const Bcc4Report report = write_to(file.sink(), info, layers, bench, {.data_offset = start});
  EXPECT_GT(report.bytes.file, start);
  EXPECT_EQ(report.bytes.unused, start - preamble_bytes);
  const auto reader = Bcc4Reader::open(file.source());
  EXPECT_LT(reader->bytes_read(), 20'000u);
  EXPECT_GE(reader->chunks(0, 0).front().offset, start);
  EXPECT_FALSE(difference(expected, read_all(reader, bench)));
  EXPECT_TRUE(reader->verify_all(bench.context).damage.empty());
}

TEST(Bcc4Reader, AFileOnDiskNeedsFinish) {
  const std::string path = testing::TempDir() + "bcc4_reader_test.bcc4";
  std::remove(path.c_str());
  const VolumeInfo info = volume(LatticeKind::d4star, {20, 20, 20, 9}, {channel("a", ValueType::u16)});
  const Layers layers = make_volume(info, ball);
  Bench bench;
  {
    Bcc4Writer writer(create_file_sink(path, false), info);
    writer.write_slab(0, 0, std::span(layers[0]).first(8), bench.context);
  }
  EXPECT_THROW(open_file_source(path), Error);
  EXPECT_THROW(open_file_source(path + ".partial"), Error);
  write_to(create_file_sink(path, false), info, layers, bench);
  EXPECT_FALSE(difference(read_all(write_file(info, layers)),
                          read_all(Bcc4Reader::open(open_file_source(path)), bench)));
  std::remove(path.c_str());
}

template<class Call> void expect_code(Code code, const char* text, const Call& call) {
  try {
    call();
    ADD_FAILURE() << text << ": no error";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), code) << e.message();
    EXPECT_NE(e.message().find(text), std::string::npos) << e.message();
  }
}

TEST(Bcc4Writer, RefusesWhatDoesNotFit) {
  const VolumeInfo info = volume(LatticeKind::d4star, {20, 20, 20, 14},
                                 {channel("a", ValueType::u8), channel("b", ValueType::u8)});
  const Layers layers = make_volume(info, ball);
  Bench bench;
  std::vector<std::byte> bytes;
  const auto slab = [&](size_t first, size_t count) { return std::span(layers[0]).subspan(first, count); };
  const auto make = [&] { return Bcc4Writer(create_memory_sink(bytes), info); };
  expect_code(Code::invalid_argument, "no such channel",
              [&] { make().write_slab(0, 2, slab(0, 8), bench.context); });
  expect_code(Code::invalid_argument, "9 layers",
              [&] { make().write_slab(0, 0, slab(0, 9), bench.context); });
  expect_code(Code::invalid_argument, "not of coset",
              [&] { make().write_slab(0, 0, slab(1, 8), bench.context); });
  {
    Bcc4Writer w(create_memory_sink(bytes), info);
    w.write_slab(1, 0, slab(8, 8), bench.context);
    expect_code(Code::invalid_argument, "slabs must rise",
                [&] { w.write_slab(0, 0, slab(0, 8), bench.context); });
    w.write_slab(0, 1, slab(0, 8), bench.context); // channels are independent
    w.info().channels[0].scale = 2;
    expect_code(Code::wrong_state, "changed", [&] { w.write_slab(2, 0, slab(16, 4), bench.context); });
  }
  {
    Bcc4Writer w(create_memory_sink(bytes), info);
    w.write_slab(0, 0, slab(0, 8), bench.context);
    w.write_slab(2, 0, slab(16, 3), bench.context); // the lattice has 20 layers
    expect_code(Code::wrong_state, "ends after 3 layers", [&] { w.finish(bench.context); });
    expect_code(Code::wrong_state, "failed before", [&] { w.finish(bench.context); });
  }
  { // what no reader would open is not finished
    Bcc4Writer w(create_memory_sink(bytes), info);
    w.write_slab(0, 0, slab(0, 8), bench.context);
    w.info().attributes.emplace_back("a", std::string(Bcc4Limits{}.metadata_bytes, 'x'));
    expect_code(Code::limit_exceeded, "metadata of", [&] { w.finish(bench.context); });
  }
  expect_code(Code::nonfinite_value, "not finite", [&] {
    const auto bad = make_layers(info, 0, [](int, double x, double, double, double) {
      return Sample{x > 5 ? NAN : 1, true, false};
    });
    make().write_slab(0, 0, std::span(bad).first(8), bench.context);
  });
  const auto with = [&](const auto& change) {
    VolumeInfo other = info;
    change(other);
    Bcc4Writer(create_memory_sink(bytes), other);
  };
  expect_code(Code::invalid_argument, "offset = air", [&] {
    with([](VolumeInfo& v) { v.channels[0].type = ValueType::f32, v.channels[0].offset = 1; });
  });
  expect_code(Code::invalid_argument, "scale", [&] { with([](VolumeInfo& v) { v.channels[0].scale = 0; }); });
  expect_code(Code::invalid_argument, "2^22 steps",
              [&] { with([](VolumeInfo& v) { v.channels[0].offset = 1e9; }); });
  expect_code(Code::invalid_argument, "two channels",
              [&] { with([](VolumeInfo& v) { v.channels[1].name = "a"; }); });
  expect_code(Code::invalid_argument, "no channels",
              [&] { with([](VolumeInfo& v) { v.channels.clear(); }); });
}

TEST(Bcc4Writer, CancelStops) {
  const VolumeInfo info = volume(LatticeKind::d4star, {20, 20, 20, 9}, {channel("a", ValueType::u8)});
  const Layers layers = make_volume(info, ball);
  Bench bench;
  std::vector<std::byte> bytes;
  Bcc4Writer writer(create_memory_sink(bytes), info);
  bench.progress.cancel();
  expect_code(Code::cancelled, "cancelled",
              [&] { writer.write_slab(0, 0, std::span(layers[0]).first(8), bench.context); });
}

TEST(Bcc4Writer, AFullDiskIsReported) {
  const VolumeInfo info = volume(LatticeKind::d4star, {40, 40, 40, 9}, {channel("a", ValueType::u16)});
  const Layers layers = make_volume(info, dense);
  const size_t size = write_file(info, layers).size();
  Bench bench;
  for (const uint64_t room : {uint64_t{0}, uint64_t{size / 2}, uint64_t{size - 1}})
    expect_code(Code::io_error, "could not write", [&] {
      write_to(create_stream_sink([room](uint64_t offset, std::span<const std::byte> b) {
                 return offset + b.size() <= room ? static_cast<int64_t>(b.size()) : -1;
               }),
               info, layers, bench);
    });
}

} // namespace
} // namespace bccsplat

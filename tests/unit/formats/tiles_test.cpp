// SPDX-License-Identifier: Apache-2.0
// Files of tiles: samples as near as asked, air exact, holes where they were; parts of them alone, damaged
// ones, and what breaks their rules.
#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>

#include "formats/bcc4/coding/deflate.h"
#include "formats/bcc4/coding/tile.h"
#include "formats/bcc4/encode/encode_tile.h"
#include "formats/bcc4/write/journal.h"
#include "tests/unit/formats/rebuild.h"
#include "tests/unit/formats/test_data.h"

namespace bccsplat {
namespace {

using namespace test;
namespace fs = std::filesystem;

VolumeInfo tiled(LatticeKind kind, ValueType type, double error, int edge) {
  const auto dims = kind == LatticeKind::bcc ? std::array<uint32_t, 4>{70, 41, 37, 1}
                                             : std::array<uint32_t, 4>{70, 41, 37, 9};
  VolumeInfo info = volume(kind, dims, {channel("a", type, 3)});
  info.tile_edge = edge, info.slab_layers = 6;
  info.channels[0].wavelet_error = error;
  return info;
}

struct SiteDifference {
  double squares = 0, sites = 0;
  int64_t air_lost = 0; // kept before, air now
  int64_t holes = 0, other_holes = 0;
};

bool is_kept(const Brick& brick, int site) {
  return (brick.kept[site / brick_edge] >> (site % brick_edge) & 1) != 0;
}

void compare_bricks(const Brick* a, const Brick* b, SiteDifference& d) {
  for (int i = 0; i < brick_sites; ++i) {
    const bool was = a && is_kept(*a, i), stays = b && is_kept(*b, i);
    d.air_lost += was && !stays;
    const double off = double{was ? a->value[i] : 0} - (stays ? b->value[i] : 0);
    d.squares += off * off, ++d.sites;
    const bool hole = a && a->is_hole(i), found = b && b->is_hole(i);
    d.holes += hole, d.other_holes += hole != found;
  }
}

SiteDifference compare_sites(const Layers& a, const Layers& b) {
  SiteDifference d;
  for (size_t m = 0; m < a[0].size(); ++m)
    for (size_t s = 0; s < a[0][m].brick_slots(); ++s) compare_bricks(a[0][m].brick(s), b[0][m].brick(s), d);
  return d;
}

class Tiles : public testing::TestWithParam<std::tuple<LatticeKind, ValueType, int>> {};

TEST_P(Tiles, KeepTheErrorAndWhatIsAir) {
  const auto [kind, type, edge] = GetParam();
  const double error = type == ValueType::u8 ? 1 : .2;
  const VolumeInfo info = tiled(kind, type, error, edge);
  const Layers layers = make_volume(info, ball);
  const Bytes file = write_file(info, layers);
  const auto reader = Bcc4Reader::open(open_memory_source(file));
  EXPECT_EQ(reader->info().tile_edge, edge);
  Bench bench;
  for (const auto& damage : reader->verify_all(bench.context).damage) ADD_FAILURE() << damage.message;
  const Layers back = read_all(file);
  const SiteDifference d = compare_sites(layers, back);
  EXPECT_EQ(d.air_lost, 0);
  EXPECT_GT(d.holes, 0);
  EXPECT_EQ(d.other_holes, 0);
  EXPECT_GT(d.squares, 0);
  EXPECT_LE(std::sqrt(d.squares / d.sites), error + .3 * info.channels[0].scale); // and the type's own steps
  // The bytes are the same again, whoever writes them.
  EXPECT_EQ(write_file(info, layers, 3), file);
}

INSTANTIATE_TEST_SUITE_P(
    AllLattices, Tiles,
    testing::Combine(testing::Values(LatticeKind::d4star, LatticeKind::bcc, LatticeKind::cc),
                     testing::Values(ValueType::u8, ValueType::u16), testing::Values(2, 4)));

// The layers are rounded before they come: what a slab has left is told, or that nothing is.
TEST(TilesAlone, SmallErrorsAreKeptInEverySlab) {
  for (const LatticeKind kind : {LatticeKind::d4star, LatticeKind::cc})
    for (const ValueType type : {ValueType::u8, ValueType::u16})
      for (const double codes : {20., 2., .2, .02, .002}) {
        VolumeInfo info = tiled(kind, type, 1, 2);
        ChannelInfo& c = info.channels[0];
        c.offset = 0, c.air = 0, c.scale = 1, c.wavelet_error = codes;
        const double top = type == ValueType::u8 ? 250 : 65000;
        const Layers layers = make_volume(info, [&](int, double x, double y, double z, double t) {
          const double wave = std::sin(.4 * x + .2 * y - t) * std::cos(.3 * z);
          return Sample{static_cast<float>(std::floor(top - 4 * codes * (1 + wave))), x + y > 20, false};
        });
        const Layers back = read_all(write_file(info, layers));
        for (int32_t s = 0; s < info.slabs(); ++s) {
          SiteDifference d;
          for (int32_t m = s * 6; m < s * 6 + info.layers_of(s); ++m)
            for (size_t b = 0; b < layers[0][m].brick_slots(); ++b)
              compare_bricks(layers[0][m].brick(b), back[0][m].brick(b), d);
          EXPECT_LE(std::sqrt(d.squares / d.sites), codes * 1.001) << "slab " << s << ", " << codes;
        }
      }
}

TEST(TilesAlone, WhatRoundingHasSpentIsNotThereTwice) {
  const VolumeInfo info = tiled(LatticeKind::cc, ValueType::u16, .4 / 256, 2);
  const Layers layers = make_volume(info, [](int c, double x, double y, double z, double t) {
    Sample s = dense(c, x, y, z, t);
    s.value = std::floor(s.value * 256) / 256;
    return s;
  });
  Bench bench;
  const std::vector<SampleLayer> slab(layers[0].begin(), layers[0].begin() + 6);
  const double allowed = std::pow(info.channels[0].wavelet_error, 2) * 6 * 70 * 41 * 37;
  for (const double share : {.9, 1.1}) {
    Bytes bytes;
    Bcc4Writer writer(create_memory_sink(bytes), info);
    try {
      writer.write_slab(0, 0, slab, bench.context, share * allowed);
      EXPECT_LT(share, 1);
      SiteDifference d;
      const std::vector<SampleLayer> read = writer.as_read(0, 0, slab, bench.context, share * allowed);
      for (size_t m = 0; m < read.size(); ++m) {
        const BrickLayer is = read[m].as_values();
        for (size_t b = 0; b < slab[m].brick_slots(); ++b)
          compare_bricks(layers[0][m].brick(b), is.brick(b), d);
      }
      EXPECT_GT(d.sites, 0);
      EXPECT_LE(d.squares, .1001 * allowed);
    } catch (const Error& e) {
      EXPECT_GT(share, 1);
      EXPECT_EQ(e.code(), Code::bound_not_met) << e.message();
    }
  }
}

TEST(TilesAlone, ABoxReadsItsTilesAndNoOthers) {
  const VolumeInfo info = tiled(LatticeKind::cc, ValueType::u16, .2, 2);
  const Bytes file = write_file(info, make_volume(info, dense));
  Bench bench;
  const auto reader = Bcc4Reader::open(open_memory_source(file));
  const Bcc4Samples whole(reader, bench.memory), part(reader, bench.memory);
  const BrickBox box{{2, 0, 0}, {4, 1, 1}};
  const BrickLayer all = whole.read_layer(0, 4, {}, bench.context),
                   some = part.read_layer(0, 4, box, bench.context);
  EXPECT_EQ(part.chunks_decoded(), 1u);
  for (int x = 2; x < 4; ++x) {
    const auto *a = all.brick(all.slot(x, 0, 0)), *b = some.brick(some.slot(x, 0, 0));
    ASSERT_TRUE(a && b);
    EXPECT_TRUE(std::equal(a->value.begin(), a->value.end(), b->value.begin()));
  }
}

// Whatever room there is beside it: layers that are read together leave what decoding takes.
TEST(TilesAlone, WhatReadsOneLayerReadsSeveral) {
  for (const bool linear : {false, true}) {
    VolumeInfo info = tiled(linear ? LatticeKind::cc : LatticeKind::d4star, ValueType::u16, .2, 2);
    info.channels[0].linear = linear;
    const Bytes file = write_file(info, make_volume(info, dense));
    const auto peak = [&](std::vector<int32_t> layers, uint64_t budget) {
      Bench bench(1, budget);
      Bcc4Samples(Bcc4Reader::open(open_memory_source(file)), bench.memory, 0)
          .read_layers(0, layers, {}, bench.context, [](int32_t, BrickLayer&&) {});
      return bench.memory.peak();
    };
    const uint64_t one = peak({0}, UINT64_MAX);
    EXPECT_GT(peak({0, 1, 2, 3}, UINT64_MAX), one);
    for (uint64_t budget = one; budget < 6 * one; budget += one / 8)
      EXPECT_NO_THROW(peak({0, 1, 2, 3}, budget)) << linear << ' ' << budget - one;
  }
}

TEST(TilesAlone, LayersOneByOneDecodeATileOnce) {
  const VolumeInfo info = tiled(LatticeKind::cc, ValueType::u16, .2, 4);
  const Bytes file = write_file(info, make_volume(info, dense));
  Bench bench;
  const Bcc4Samples samples(Bcc4Reader::open(open_memory_source(file)), bench.memory);
  for (int32_t m = 0; m < 6; ++m)
    samples.read_samples(0, std::span(&m, 1), {}, bench.context, [](int32_t, SampleLayer&&) {});
  EXPECT_EQ(samples.chunks_decoded(), 2u); // along x
}

// A series that stands still has one layer of coefficients: the frames are made of it when they are asked
// for.
TEST(TilesAlone, LayersThatNobodyAskedForTakeNoMemory) {
  const VolumeInfo info = tiled(LatticeKind::cc, ValueType::u16, .2, 4);
  const Bytes file = write_file(info, make_volume(info, [](int c, double x, double y, double z, double) {
                                  return dense(c, x, y, z, 0);
                                }));
  const Layers whole = read_all(file);
  Bench bench;
  const Bcc4Samples samples(Bcc4Reader::open(open_memory_source(file)), bench.memory);
  std::vector<uint64_t> held;
  for (const int32_t m : {3, 5, 0, 1, 4, 2, 3}) {
    const BrickLayer layer = samples.read_layer(0, m, {}, bench.context);
    for (size_t s = 0; s < layer.brick_slots(); ++s) {
      SiteDifference d;
      compare_bricks(whole[0][m].brick(s), layer.brick(s), d);
      EXPECT_EQ(d.squares, 0);
      EXPECT_EQ(d.air_lost, 0);
    }
    held.push_back(bench.memory.used());
  }
  EXPECT_EQ(samples.chunks_decoded(), 2u); // along x
  EXPECT_LT(held[0], held.back() * 7 / 10);
  EXPECT_LT(held[0], held[1]);
}

TEST(TilesAlone, WhatAReaderGetsIsToldToTheWriter) {
  const VolumeInfo info = tiled(LatticeKind::d4star, ValueType::u16, .2, 4);
  const Layers layers = make_volume(info, ball);
  Bench bench;
  Bytes bytes;
  Bcc4Writer writer(create_memory_sink(bytes), info);
  std::vector<BrickLayer> told;
  for (int32_t s = 0; s < info.slabs(); ++s) {
    const auto slab = std::span(layers[0]).subspan(s * 6, info.layers_of(s));
    const std::vector<SampleLayer> compact(slab.begin(), slab.end());
    writer.write_slab(s, 0, compact, bench.context);
    std::vector<SampleLayer> read = writer.as_read(s, 0, compact, bench.context);
    // What a reader gets is held as codes, and coded anew where it is asked for once more.
    EXPECT_LT(read[0].bytes(), read[0].as_values().bytes() * 2 / 3);
    if (s == 0) read = writer.as_read(s, 0, compact, bench.context);
    for (const SampleLayer& layer : read) told.push_back(layer.as_values());
  }
  writer.finish(bench.context);
  EXPECT_FALSE(difference({told}, read_all(bytes)));
}

// What another version has made of the same samples; here others stand for it.
class TakenOver : public testing::TestWithParam<LatticeKind> {
 protected:
  const VolumeInfo info = [] {
    VolumeInfo of = tiled(GetParam(), ValueType::u16, .2, 4);
    of.channels[0].linear = GetParam() == LatticeKind::cc;
    return of;
  }();
  const Layers layers = make_volume(info, ball);
  const Layers others = make_volume(
      info, [](int c, double x, double y, double z, double t) { return ball(c, x + .5, y, z, t); });
  const Bytes other = write_file(info, others);
  Bench bench{2};

  std::vector<SampleLayer> slab(const Layers& all, int32_t s) const {
    const auto of = std::span(all[0]).subspan(s * 6, info.layers_of(s));
    return {of.begin(), of.end()};
  }
  // Goes on behind the first slab, of which it is told what that file has.
  void go_on(Bcc4Writer& writer) {
    writer.write_slab(0, 0, slab(layers, 0), bench.context);
    expect_others(writer.as_read(0, 0, slab(layers, 0), bench.context));
    for (int32_t s = 1; s < info.slabs(); ++s) writer.write_slab(s, 0, slab(layers, s), bench.context);
    EXPECT_EQ(writer.finish(bench.context).slabs_reused, 1u);
  }
  // Compares what a writer tells of its first slab with what the other file has of it.
  void expect_others(const std::vector<SampleLayer>& told) const {
    const Layers theirs = read_all(other);
    SiteDifference from_theirs, from_ours;
    for (size_t m = 0; m < told.size(); ++m) {
      const BrickLayer is = told[m].as_values();
      for (size_t b = 0; b < is.brick_slots(); ++b) {
        compare_bricks(theirs[0][m].brick(b), is.brick(b), from_theirs);
        compare_bricks(layers[0][m].brick(b), is.brick(b), from_ours);
      }
    }
    EXPECT_EQ(from_theirs.air_lost, 0);
    EXPECT_EQ(from_theirs.other_holes, 0);
    EXPECT_GT(from_theirs.holes, 0);
    const double rounding = info.channels[0].linear ? info.channels[0].scale / 64 : 0;
    EXPECT_LE(std::sqrt(from_theirs.squares / from_theirs.sites), rounding);
    EXPECT_GT(std::sqrt(from_ours.squares / from_ours.sites), 0.4); // and 0.2 is allowed
  }
};

TEST_P(TakenOver, ASlabOfAnEarlierFileIsToldAsItIs) {
  Bcc4WriterOptions options;
  options.earlier = Bcc4Reader::open(open_memory_source(other)), options.earlier_slabs = 1;
  Bytes bytes;
  Bcc4Writer writer(create_memory_sink(bytes), info, options);
  go_on(writer);
}

TEST_P(TakenOver, ASlabOfAnInterruptedWriterIsToldAsItIs) {
  const fs::path folder = fs::temp_directory_path() / ("bccsplat-taken-" + std::to_string(::getpid()));
  fs::create_directory(folder);
  const std::string path = (folder / "x.bcc4").string();
  const auto begin = [&](Partial partial) {
    Bcc4WriterOptions options;
    options.journal = std::make_shared<Bcc4Journal>(path, partial == Partial::taken_over, 1);
    return std::make_unique<Bcc4Writer>(create_file_sink(path, true, partial), info, options);
  };
  begin(Partial::kept)->write_slab(0, 0, slab(others, 0), bench.context);
  go_on(*begin(Partial::taken_over));
  fs::remove_all(folder);
}

// The checksum of the coefficients of all tiles of a file.
uint32_t checksum_of_tiles(const VolumeInfo& info, const Formula& formula) {
  const Bytes file = write_file(info, make_volume(info, formula));
  const auto reader = Bcc4Reader::open(open_memory_source(file));
  Bytes tiles;
  for (int32_t s = 0; s < info.slabs(); ++s)
    for (const Bcc4Chunk& chunk : reader->chunks(0, s)) {
      const Bytes bytes = reader->stored_bytes(chunk); // the run lists behind are deflated by a library
      tiles.insert(tiles.end(), bytes.begin(), bytes.begin() + chunk.values_bytes);
    }
  return crc32_of(tiles);
}

TEST(TilesAlone, NewRulesHaveANewNumber) {
  const char* const advice =
      "The rules have changed: raise tile_rules, and write it and the new checksums here.";
  EXPECT_EQ(tile_rules, 1) << advice;
  VolumeInfo linear = tiled(LatticeKind::cc, ValueType::u8, 1, 4);
  linear.channels[0].linear = true;
  EXPECT_EQ(checksum_of_tiles(tiled(LatticeKind::d4star, ValueType::u16, .2, 4), ball), 2735850514u)
      << advice;
  EXPECT_EQ(checksum_of_tiles(linear, dense), 3831541811u) << advice;
}

INSTANTIATE_TEST_SUITE_P(AllLattices, TakenOver, testing::Values(LatticeKind::d4star, LatticeKind::cc));

TEST(TilesAlone, DamageCostsATileAndItsReach) {
  const VolumeInfo info = tiled(LatticeKind::cc, ValueType::u16, .2, 2);
  Bytes file = write_file(info, make_volume(info, dense));
  Bench bench;
  const auto victim = Bcc4Reader::open(open_memory_source(file))->chunks(0, 0)[0];
  file[victim.offset + 9] ^= std::byte{1};
  const auto damage = Bcc4Reader::open(open_memory_source(file))->verify_all(bench.context).damage;
  ASSERT_EQ(damage.size(), 1u);
  EXPECT_EQ(damage[0].code, Code::checksum_mismatch);
  const auto salvaged = Bcc4Reader::open(open_memory_source(file), {.salvage = true});
  const Bcc4Samples samples(salvaged, bench.memory);
  const BrickLayer layer = samples.read_layer(0, 2, {}, bench.context);
  const Brick *lost = layer.brick(layer.slot(0, 0, 0)), *near = layer.brick(layer.slot(1, 1, 1)),
              *whole = layer.brick(layer.slot(4, 0, 0));
  ASSERT_TRUE(lost && near && whole);
  EXPECT_TRUE(lost->is_hole(0));
  EXPECT_TRUE(near->is_hole(0));
  EXPECT_FALSE(whole->hole);
}

// A file that breaks a rule of the page is refused before its tiles are looked at.
void expect_refused(const std::function<void(VolumeInfo&)>& change) {
  const VolumeInfo info = tiled(LatticeKind::cc, ValueType::u16, .2, 2);
  const Bytes bad = rebuild(write_file(info, make_volume(info, dense)), with_info(change));
  try {
    (void)Bcc4Reader::open(open_memory_source(bad));
    ADD_FAILURE() << "opened";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), Code::corrupt) << e.message();
  }
}

TEST(TilesAlone, RulesOfTheRecord) {
  expect_refused([](VolumeInfo& v) { v.tile_edge = 3; });
  expect_refused([](VolumeInfo& v) { v.channels[0].wavelet_error = 0; });
  expect_refused([](VolumeInfo& v) { v.channels[0].wavelet_error = NAN; });
  expect_refused([](VolumeInfo& v) {
    v.channels[0].type = ValueType::f32, v.channels[0].scale = 1, v.channels[0].offset = v.channels[0].air;
  });
}

TEST(TilesAlone, OtherCodingsAmongTilesAreRefused) {
  const VolumeInfo info = tiled(LatticeKind::cc, ValueType::u16, .2, 2);
  for (const auto& change : std::vector<std::function<void(Bcc4Chunk&)>>{
           [](Bcc4Chunk& c) { c.coding = static_cast<uint8_t>((c.coding & 0xf0) | 1); },
           [](Bcc4Chunk& c) { c.predictor = 1; }, [](Bcc4Chunk& c) { c.slot = 200; }}) {
    const Bytes bad = rebuild(write_file(info, make_volume(info, dense)),
                              {.entries = [&](std::vector<Bcc4Chunk>& page) { change(page.back()); }});
    Bench bench;
    try {
      const auto reader = Bcc4Reader::open(open_memory_source(bad));
      (void)read_all(reader, bench);
      ADD_FAILURE() << "read";
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), Code::corrupt) << e.message();
    }
  }
}

} // namespace
} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// What is written is read: samples, holes and metadata, for every value type and lattice.
#include <gtest/gtest.h>

#include <tuple>

#include "base/half.h"
#include "formats/bcc4/coding/chunk.h"
#include "tests/unit/formats/test_data.h"

namespace bccsplat {
namespace {

using namespace test;

// What a stored type makes of a sample relative to air, straight from the definition.
float stored_as(const ChannelInfo& c, float relative) {
  if (c.type == ValueType::f32) return relative;
  if (c.type == ValueType::f16) {
    const double bias = c.offset - c.air;
    const float half = half_to_float(float_to_half(static_cast<float>(relative - bias)));
    return static_cast<float>(half + bias);
  }
  const double top = c.type == ValueType::u8 ? 255 : 65535;
  const double value = static_cast<double>(c.air) + relative;
  const double code = std::clamp(std::floor((value - c.offset) / c.scale + 0.5), 0.0, top);
  return static_cast<float>(code * c.scale + (c.offset - c.air));
}

class AllTypes : public testing::TestWithParam<std::tuple<ValueType, LatticeKind, float>> {};

TEST_P(AllTypes, WriteReadWrite) {
  const auto [type, kind, air] = GetParam();
  const std::array<uint32_t, 4> dims = kind == LatticeKind::bcc ? std::array<uint32_t, 4>{30, 25, 23, 1}
                                                                : std::array<uint32_t, 4>{30, 25, 23, 9};
  const VolumeInfo info = volume(kind, dims, {channel("a", type, air)});
  const Layers layers = make_volume(info, ball);
  const auto file = write_file(info, layers);
  const Layers back = read_all(file);
  int64_t kept = 0;
  for (size_t m = 0; m < layers[0].size(); ++m) {
    const auto d =
        difference(layers[0][m], back[0][m], [&](float v) { return stored_as(info.channels[0], v); });
    EXPECT_FALSE(d) << "layer " << m << ": " << *d;
    kept += back[0][m].kept_sites();
  }
  EXPECT_GT(kept, 1000);
  const auto reader = Bcc4Reader::open(open_memory_source(file));
  EXPECT_EQ(reader->info().channels[0].sites_kept, static_cast<uint64_t>(kept));
  EXPECT_GT(reader->info().channels[0].holes, 0u);
  // The reader's own account, without what was counted, makes the same file from the samples read.
  EXPECT_EQ(write_file(info, back), file);
}

INSTANTIATE_TEST_SUITE_P(
    Bcc4RoundTrip, AllTypes,
    testing::Combine(testing::Values(ValueType::u8, ValueType::u16, ValueType::f16, ValueType::f32),
                     testing::Values(LatticeKind::d4star, LatticeKind::bcc, LatticeKind::cc),
                     testing::Values(0.0f, -3.25f, 1000.125f)));

TEST(Bcc4RoundTrip, HalfValuesOfTheSourceStayExact) {
  ChannelInfo c = channel("a", ValueType::f16, 3);
  c.offset = 0; // values, not distances from air
  const VolumeInfo info = volume(LatticeKind::bcc, {20, 20, 20, 1}, {c});
  const Layers layers = make_volume(info, [](int, double x, double y, double z, double) {
    const float half = half_to_float(float_to_half(static_cast<float>(0.37 * x + 1.1 * y - 0.61 * z)));
    return Sample{half - 3, true, false};
  });
  const auto file = write_file(info, layers);
  EXPECT_FALSE(difference(layers, read_all(file)));
  EXPECT_EQ(write_file(info, read_all(file)), file);
}

TEST(Bcc4RoundTrip, ThreadsDoNotMatter) {
  const VolumeInfo info = volume(LatticeKind::d4star, {70, 50, 40, 12},
                                 {channel("a", ValueType::u16), channel("b", ValueType::f32)});
  const Layers layers = make_volume(info, ball);
  const auto one = write_file(info, layers, 1);
  EXPECT_EQ(write_file(info, layers, 4), one);
  EXPECT_FALSE(difference(read_all(one, 1), read_all(one, 4)));
}

TEST(Bcc4RoundTrip, LevelsDecodeAlike) {
  const VolumeInfo info = volume(LatticeKind::d4star, {40, 40, 40, 9}, {channel("a", ValueType::u8)});
  const Layers layers = make_volume(info, dense);
  const Layers expected = read_all(write_file(info, layers));
  size_t raw_size = 0;
  for (const int level : {0, 1, 6, 9}) {
    const auto file = write_file(info, layers, 1, {.level = level});
    EXPECT_FALSE(difference(expected, read_all(file))) << "level " << level;
    if (level == 0)
      raw_size = file.size();
    else
      EXPECT_LT(file.size(), raw_size / 2) << "level " << level;
  }
}

TEST(Bcc4RoundTrip, SlabsOfAnyDepth) {
  VolumeInfo info = volume(LatticeKind::d4star, {24, 20, 20, 14}, {channel("a", ValueType::u16)});
  const Layers layers = make_volume(info, ball);
  const Layers expected = read_all(write_file(info, layers));
  for (const int32_t depth : {1, 3, 32}) {
    info.slab_layers = depth;
    EXPECT_FALSE(difference(expected, read_all(write_file(info, layers)))) << depth << " layers per slab";
  }
}

TEST(Bcc4RoundTrip, NothingKept) {
  const VolumeInfo info = volume(LatticeKind::d4star, {20, 20, 20, 5}, {channel("a", ValueType::u8)});
  const auto file = write_file(info, [](int, double, double, double, double) { return Sample{}; });
  const auto reader = Bcc4Reader::open(open_memory_source(file));
  EXPECT_EQ(reader->chunk_count(), 0u);
  Bench bench;
  EXPECT_EQ(Bcc4Samples(reader, bench.memory).read_layer(0, 3, {}, bench.context).kept_sites(), 0);
  EXPECT_TRUE(reader->verify_all(bench.context).damage.empty());
}

TEST(Bcc4RoundTrip, KeptSitesMayEqualAir) {
  const VolumeInfo info = volume(LatticeKind::cc, {17, 5, 3, 1}, {channel("a", ValueType::u8, 2)});
  const Layers layers = make_volume(info, [](int, double x, double, double, double) {
    return Sample{0, x > 3, false};
  });
  const auto file = write_file(info, layers);
  EXPECT_FALSE(difference(layers, read_all(file)));
  EXPECT_EQ(Bcc4Reader::open(open_memory_source(file))->info().channels[0].sites_kept, 13u * 15);
}

TEST(Bcc4RoundTrip, MetadataComesBack) {
  VolumeInfo info = volume(LatticeKind::d4star, {20, 21, 22, 4},
                           {channel("density", ValueType::u16, 1), channel("T", ValueType::f32)});
  info.scale = 1.0, info.time_scale = 1.0;
  info.affine.linear = {Vec3{0.5, 0.1, 0}, Vec3{0, -2, 0}, Vec3{0, 0.25, 3}};
  info.affine.offset = {10, 20, -30};
  info.spatial_unit = "";
  info.axes[0].unit = "degrees", info.axes[1].unit = "µm";
  info.axes[2] = {"m", true, {}};
  for (int i = 0; i < 22; ++i) info.axes[2].coordinates.push_back(1000 - 2.5 * i * i);
  info.time.uniform = false;
  info.time.times = {0, 6, 24.5, 48};
  info.time.unit = "h", info.time.epoch = "2002-10-28T00:00:00Z";
  info.recommended_kernel = "radial24+b4";
  info.sources = {{"smoke.0001.vdb", 123456789012, 0xdeadbeef}, {"smoke.0002.vdb", 1, 0}};
  info.attributes = {{"author", "Ä. Müller"}, {"empty", ""}};
  ChannelInfo& c = info.channels[0];
  c.quantity = "density", c.unit = "kg/m^3", c.threshold = 0.5f, c.source_type = SourceType::i16;
  c.source_range = {-4, 99}, c.histogram_range = {-1, 64};
  c.histogram.assign(256, 3);
  c.histogram[17] = 1'000'000'000'000;
  c.percentiles = {{2, -0.5}, {99.8, 60}};
  c.frames = {{-4, 1}, {0, 2}, {0, 3}, {0, 99}};
  c.cc_relevant = 77;
  const auto file = write_file(info, ball);
  VolumeInfo back = Bcc4Reader::open(open_memory_source(file))->info();
  EXPECT_GT(back.channels[0].sites_kept, 0u);
  EXPECT_GT(back.channels[0].kept_range.high, 50);
  for (size_t i = 0; i < 2; ++i) {
    info.channels[i].sites_kept = back.channels[i].sites_kept,
    info.channels[i].holes = back.channels[i].holes;
    info.channels[i].kept_range = back.channels[i].kept_range;
  }
  EXPECT_EQ(back, info);
}

// A field that passes the value of air here and there: such sites are kept rather than left out one by one.
TEST(Bcc4RoundTrip, ScatteredAirCostsNoRuns) {
  VolumeInfo info = volume(LatticeKind::d4star, {40, 40, 40, 12}, {channel("a", ValueType::u8)});
  info.channels[0].offset = -64; // air is code 128
  const auto wave = [](int, double x, double y, double z, double t) {
    const double v =
        std::floor(40 * std::sin(0.9 * x + 0.35 * y) * std::cos(0.4 * z - t) + 4 * std::sin(5 * x * y));
    return Sample{static_cast<float>(v), v != 0, false};
  };
  const auto file = write_file(info, wave);
  const auto reader = Bcc4Reader::open(open_memory_source(file));
  Bench bench;
  const Layers given = make_volume(info, wave), back = read_all(reader, bench);
  uint64_t sites = 0, left_out = 0;
  for (size_t m = 0; m < given[0].size(); ++m) {
    EXPECT_EQ(layer_to_dense(back[0][m]), layer_to_dense(given[0][m])) << "layer " << m;
    const Int3 n = given[0][m].dims();
    const auto all = static_cast<uint64_t>(n[0]) * n[1] * n[2];
    sites += all;
    left_out += all - given[0][m].kept_sites();
  }
  EXPECT_GT(left_out, sites / 100); // without this the test shows nothing
  EXPECT_EQ(reader->info().channels[0].sites_kept, sites);
  EXPECT_LT(reader->bytes().runs, sites / 500);
  EXPECT_TRUE(reader->verify_all(bench.context).damage.empty());
  EXPECT_EQ(write_file(info, back), file);
  // A body of air stays air, and so do single sites where bytes are not single.
  const auto bubble = [&](int c, double x, double y, double z, double t) {
    Sample s = wave(c, x, y, z, t);
    s.kept = !(x > 10 && x < 20 && y > 5 && y < 15 && z > 5 && z < 15);
    return s;
  };
  EXPECT_EQ(difference(read_all(write_file(info, bubble)), make_volume(info, bubble)), std::nullopt);
  info.channels[0].type = ValueType::u16;
  EXPECT_EQ(difference(read_all(write_file(info, wave)), given), std::nullopt);
}

TEST(Bcc4RoundTrip, TidiesWhatMustNotSpoilAFile) {
  VolumeInfo info = volume(LatticeKind::cc, {4, 4, 4, 1}, {channel("a", ValueType::f32)});
  info.sources = {{"bad\xff name", 1, 0}};
  info.attributes = {{"k", "1"}, {"other", "2"}, {"k", "3"}};
  info.channels[0].source_range = {INFINITY, -INFINITY};
  const VolumeInfo back = Bcc4Reader::open(open_memory_source(write_file(info, ball)))->info();
  EXPECT_EQ(back.sources[0].name, "bad\xef\xbf\xbd name");
  EXPECT_EQ(back.attributes, (std::vector<std::pair<std::string, std::string>>{{"other", "2"}, {"k", "3"}}));
  EXPECT_EQ(back.channels[0].source_range, Range{});
}

TEST(Bcc4RoundTrip, LengthMayBeKnownAtTheEnd) {
  const VolumeInfo whole = volume(LatticeKind::d4star, {20, 20, 20, 9}, {channel("a", ValueType::u16)});
  const Layers layers = make_volume(whole, ball);
  VolumeInfo start = whole;
  start.lattice.dims[3] = 2, start.lattice.last_layer = 2;
  Bench bench;
  std::vector<std::byte> bytes;
  Bcc4Writer writer(create_memory_sink(bytes), start);
  for (int32_t s = 0; s < whole.slabs(); ++s) {
    const size_t first = s * 8;
    writer.write_slab(s, 0,
                      std::span(layers[0]).subspan(first, std::min<size_t>(8, layers[0].size() - first)),
                      bench.context);
  }
  writer.info().lattice = whole.lattice;
  writer.finish(bench.context);
  EXPECT_EQ(bytes, write_file(whole, layers));
}

} // namespace
} // namespace bccsplat

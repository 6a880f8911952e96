// SPDX-License-Identifier: Apache-2.0
// What a series costs that plays, whatever its cache: nothing twice where the cache is what playing needs,
// never more with a larger one, and the same bits with any.
#include "volume/volume_cache.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/machine.h"
#include "field/coefficients/coefficients.h"
#include "slice/time_slice.h"
#include "tests/support/larger.h"
#include "tests/unit/formats/test_data.h"

namespace bccsplat::test {
namespace {

constexpr uint64_t gibibyte = uint64_t{1} << 30;

struct Played {
  uint64_t decoded = 0, made = 0;
  uint64_t held = 0, most = 0; // at the end, and ever
  std::vector<BrickLayer> slices;
};

// Half a frame on at a time through all of a series.
Played play(const std::vector<std::byte>& file, const char* kernel_name, uint64_t cache) {
  Bench bench;
  const auto reader = Bcc4Reader::open(open_memory_source(file));
  const Kernel kernel = make_kernel(kernel_name);
  const VolumeCache share = share_cache(cache, playing_cache(*reader, kernel));
  const Bcc4Samples samples(reader, bench.memory, share.chunks);
  const Coefficients field(samples, 0, kernel, 0, share.coefficients);
  Played out;
  for (double t = 0; t <= reader->info().lattice.last_frame(); t += 0.5)
    out.slices.push_back(time_slice(field, t, {0, 0}, {}, bench.context).coset[0]);
  out.decoded = samples.chunks_decoded(), out.made = field.layers_made();
  out.held = bench.memory.used(), out.most = bench.memory.peak();
  return out;
}

uint64_t playing_bytes(const std::vector<std::byte>& file, const char* kernel) {
  return playing_cache(*Bcc4Reader::open(open_memory_source(file)), make_kernel(kernel)).bytes();
}

struct PlayingCase {
  LatticeKind lattice;
  ValueType type;
  const char* kernel;
  Sample (*formula)(int, double, double, double, double);
};

class Playing : public testing::TestWithParam<PlayingCase> {
 protected:
  [[nodiscard]] std::vector<std::byte> file() const {
    return write_file(volume(GetParam().lattice, {24, 24, 70, 16}, {channel("value", GetParam().type)}),
                      GetParam().formula);
  }
};

TEST_P(Playing, NothingIsDecodedOrMadeTwice) {
  const auto series = file();
  const auto reader = Bcc4Reader::open(open_memory_source(series));
  const uint64_t cache = playing_bytes(series, GetParam().kernel);
  const Played played = play(series, GetParam().kernel, cache);
  EXPECT_EQ(played.decoded, reader->chunk_count());
  EXPECT_LE(played.made, static_cast<uint64_t>(reader->info().lattice.layers()));
  EXPECT_LE(played.held, cache);
}

// Work: a layer that is prefiltered takes the time of two that are decoded (tests/bench/notes/moments.md).
TEST_P(Playing, MoreCacheNeverCostsMoreNorChangesABit) {
  const auto series = file();
  const auto reader = Bcc4Reader::open(open_memory_source(series));
  const uint64_t enough = playing_bytes(series, GetParam().kernel),
                 layers_of_chunk = reader->info().slab_layers,
                 chunks = std::max<uint64_t>(1, reader->chunks(0, 1).size());
  const Played best = play(series, GetParam().kernel, 4 * enough);
  uint64_t work = UINT64_MAX;
  for (const uint64_t tenths : {0, 2, 4, 6, 8, 10, 12}) {
    const Played played = play(series, GetParam().kernel, enough * tenths / 10);
    const uint64_t now = played.decoded * layers_of_chunk / chunks + 2 * played.made;
    EXPECT_LE(now, work) << tenths << " tenths";
    work = now;
    ASSERT_EQ(played.slices.size(), best.slices.size());
    for (size_t i = 0; i < best.slices.size(); ++i)
      ASSERT_FALSE(difference(played.slices[i], best.slices[i])) << tenths << " tenths, moment " << i;
    if (tenths >= 10) {
      EXPECT_EQ(played.decoded, best.decoded);
      EXPECT_EQ(played.made, best.made);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Series, Playing,
                         testing::Values(PlayingCase{LatticeKind::d4star, ValueType::u8, "default", dense},
                                         PlayingCase{LatticeKind::d4star, ValueType::u16, "fine", dense},
                                         PlayingCase{LatticeKind::d4star, ValueType::f32, "fast", dense},
                                         PlayingCase{LatticeKind::cc, ValueType::u8, "default", dense},
                                         PlayingCase{LatticeKind::d4star, ValueType::u8, "default", ball}));

// What a dense u8 series holds that plays, in bytes a site of a layer: 6 layers of coefficients of 2 bytes,
// 11 layers of codes that these are made of, and what else of a slab of 8 has not been handed over; bricks go
// beyond the faces by a third.
TEST(VolumeCache, PlayingHoldsFewBytesASite) {
  const VolumeInfo info = volume(LatticeKind::d4star, {88, 88, 88, 16}, {channel("value", ValueType::u8)});
  const auto series = write_file(info, dense);
  const double sites = static_cast<double>(info.lattice.space.sites(0));
  const Played played = play(series, "default", playing_bytes(series, "default"));
  EXPECT_EQ(played.decoded, Bcc4Reader::open(open_memory_source(series))->chunk_count());
  EXPECT_LT(static_cast<double>(played.most) / sites, 45);
}

// Rounding coefficients is the same whoever asks, and far below the samples' own.
TEST(VolumeCache, CoefficientsOfCodesAreRoundedAlikeInAnyForm) {
  const auto series =
      write_file(volume(LatticeKind::d4star, {40, 40, 40, 16}, {channel("value", ValueType::u8)}), dense);
  Bench bench;
  const auto reader = Bcc4Reader::open(open_memory_source(series));
  const Bcc4Samples samples(reader, bench.memory);
  const Lattice4& lattice = samples.lattice();
  std::vector<BrickLayer> read;
  for (int32_t m = 0; m < lattice.layers(); ++m) read.push_back(samples.read_layer(0, m, {}, bench.context));
  const MemorySamples unrounded(lattice, {samples.air(0)}, {read});
  const Kernel kernel = make_kernel("default");
  constexpr uint64_t cache = 64 << 20;
  const Coefficients codes(samples, 0, kernel, 0, cache), values(samples, 0, kernel, 0, cache),
      exact(unrounded, 0, kernel, 0, cache);
  const int32_t m = lattice.layers() / 2;
  const auto compact = codes.compact_layers(std::span(&m, 1), bench.context).front();
  ASSERT_TRUE(compact.compact);
  EXPECT_LT(10 * compact.compact->bytes(), 6 * values.layer(m, bench.context)->bytes());
  const auto rounded = values.layer(m, bench.context), same = codes.layer(m, bench.context),
             whole = exact.layer(m, bench.context);
  EXPECT_FALSE(difference(*rounded, *same));
  const std::vector<float> a = layer_to_dense(*rounded), b = layer_to_dense(*whole);
  double most = 0, squares = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    const double error = std::fabs(static_cast<double>(a[i]) - b[i]);
    most = larger(most, error), squares += error * error / static_cast<double>(a.size());
  }
  EXPECT_GT(most, 0);
  EXPECT_LE(most, samples.sample_step(0) / 8);
  EXPECT_LT(std::sqrt(squares), samples.sample_step(0) / 24);
  // Merged of either form.
  (void)values.layers(std::vector<int32_t>{m - 2, m - 1, m, m + 1, m + 2, m + 3}, bench.context);
  const double frame = lattice.layer_frame(m);
  for (int c = 0; c < 2; ++c)
    EXPECT_FALSE(difference(time_slice(codes, frame, {0, 0}, {}, bench.context).coset[c],
                            time_slice(values, frame, {0, 0}, {}, bench.context).coset[c]));
}

TEST(VolumeCache, CodesNeedLessThanValues) {
  const auto series = [](ValueType type) {
    return write_file(volume(LatticeKind::d4star, {64, 64, 64, 12}, {channel("value", type)}), dense);
  };
  const uint64_t u8 = playing_bytes(series(ValueType::u8), "default"),
                 u16 = playing_bytes(series(ValueType::u16), "default"),
                 f32 = playing_bytes(series(ValueType::f32), "default");
  EXPECT_LT(u8, u16);
  EXPECT_LT(u16, f32);
  EXPECT_LT(u8, f32 / 2);
}

TEST(VolumeCache, AVolumeWithoutTimeDoesNotPlay) {
  const auto file =
      write_file(volume(LatticeKind::bcc, {30, 30, 30, 1}, {channel("value", ValueType::u8)}), dense);
  EXPECT_EQ(playing_bytes(file, "default"), 0u);
}

TEST(VolumeCache, TheDefaultFollowsTheSeriesWithinTheMemory) {
  const VolumeCache small{.chunks = 1 << 20, .coefficients = 6 << 20},
      large{.chunks = gibibyte / 2, .coefficients = 5 * gibibyte / 2};
  EXPECT_EQ(default_cache_bytes(small, UINT64_MAX, 16 * gibibyte), gibibyte);
  EXPECT_EQ(default_cache_bytes(small, 2 * gibibyte, 16 * gibibyte), gibibyte / 2);
  EXPECT_EQ(default_cache_bytes(large, UINT64_MAX, 16 * gibibyte), 3 * gibibyte);
  EXPECT_EQ(default_cache_bytes(large, UINT64_MAX, 4 * gibibyte), 2 * gibibyte);
  EXPECT_EQ(default_cache_bytes(large, 8 * gibibyte, 16 * gibibyte), 2 * gibibyte);
  EXPECT_EQ(default_cache_bytes(large, gibibyte, 16 * gibibyte), gibibyte / 4);
  EXPECT_EQ(default_cache_bytes(large, UINT64_MAX, gibibyte), gibibyte); // as ever
  EXPECT_GT(machine_memory(), 64u << 20);
}

TEST(VolumeCache, SharesAddUpAndGrow) {
  const VolumeCache playing{.chunks = 100, .coefficients = 700};
  VolumeCache before;
  for (uint64_t bytes = 0; bytes < 3000; bytes += 7) {
    const VolumeCache share = share_cache(bytes, playing);
    EXPECT_EQ(share.chunks + share.coefficients, bytes);
    EXPECT_GE(share.chunks, before.chunks);
    EXPECT_GE(share.coefficients, before.coefficients);
    before = share;
  }
  for (const VolumeCache& need : {playing, VolumeCache{.chunks = 400, .coefficients = 600}}) {
    const VolumeCache share = share_cache(need.bytes(), need);
    EXPECT_GE(share.chunks, need.chunks);
    EXPECT_GE(share.coefficients, need.coefficients);
  }
}

} // namespace
} // namespace bccsplat::test

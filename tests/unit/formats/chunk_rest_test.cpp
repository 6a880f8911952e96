// SPDX-License-Identifier: Apache-2.0
// Chunks that are decoded as far as they are asked for, and go on where they stopped: the same codes,
// whatever stands in them; what is checked when; and what a moment decodes, and playing on from it.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <random>
#include <utility>

#include "base/error.h"
#include "formats/bcc4/coding/scratch.h"
#include "formats/bcc4/encode/encode_chunk.h"
#include "kernel/kernel.h"
#include "slice/time_slice.h"
#include "tests/support/targets.h"
#include "tests/unit/formats/chunk_sites.h"

namespace bccsplat::test {
namespace {

// Codes that are not smooth, a chunk's each of its own; `share` of the sites are kept.
ChunkSites noisy_sites(LatticeKind kind, ValueType type, uint32_t most, double share, const Int3& brick) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> part(0, 1);
  const auto code = [&](const Vec3& p, double t) {
    const double smooth = 0.4 + 0.3 * std::sin(0.2 * p[0] + 0.3 * p[1] - 0.4 * t) * std::cos(0.25 * p[2]);
    return static_cast<uint32_t>(most * std::clamp(smooth + 0.05 * part(random), 0.0, 1.0));
  };
  // Whole planes are air, too.
  const auto kept = [&](const Vec3& p, double) {
    return share >= 1 || (std::fmod(p[2], 7) > 1.5 && part(random) < share);
  };
  VolumeInfo info = volume(kind, {40, 40, 27, 12}, {channel("a", type)});
  info.slab_layers = 6;
  return make_sites(info, 0, brick, code, kept);
}

std::span<const std::byte> codes_of_layer(const ChunkData& data, int m) {
  const size_t first = data.first[m], end = data.first[static_cast<size_t>(m) + 1];
  return std::span(data.codes).subspan(first * data.coded.bytes(), (end - first) * data.coded.bytes());
}

bool same(std::span<const std::byte> a, std::span<const std::byte> b) { return std::ranges::equal(a, b); }

LayersBefore before(const ChunkData& whole, int layers) {
  LayersBefore codes;
  for (int i = 0; i < 2; ++i)
    if (layers - 2 + i >= 0) codes[i] = codes_of_layer(whole, layers - 2 + i);
  return codes;
}

struct Coded {
  ChunkSites sites;
  ChunkCodes codes;
  EncodedChunk chunk;

  Coded(ChunkSites s, const ChunkCodes& c)
      : sites(std::move(s)), codes(c), chunk(encode_chunk(sites, c, 6)) {}
  [[nodiscard]] ChunkData decode(ChunkScratch& scratch, int layers = max_slab_layers) const {
    return decode_chunk(sites.shape, codes, chunk.entry, chunk.bytes, scratch, layers);
  }
};

void expect_parts(const Coded& coded) {
  ChunkScratch scratch;
  const ChunkData whole = coded.decode(scratch);
  ASSERT_FALSE(whole.rest);
  for (int end = 1; end < coded.sites.shape.layers; ++end) {
    const ChunkData part = coded.decode(scratch, end);
    ASSERT_TRUE(part.rest) << end;
    EXPECT_EQ(part.rest->layers, end);
    EXPECT_EQ(part.codes.size(), whole.first[end] * whole.coded.bytes());
    for (int m = 0; m < end; ++m)
      ASSERT_TRUE(same(codes_of_layer(part, m), codes_of_layer(whole, m))) << end << ": " << m;
    (void)coded.decode(scratch, end % 2 ? end : max_slab_layers); // leaves other cells behind
    const ChunkData left = finish_chunk(*part.rest, before(whole, end), scratch),
                    again = finish_chunk(*part.rest, std::nullopt, scratch);
    EXPECT_EQ(left.first[end], 0u);
    for (int m = end; m < coded.sites.shape.layers; ++m)
      ASSERT_TRUE(same(codes_of_layer(left, m), codes_of_layer(whole, m))) << end << ": " << m;
    EXPECT_TRUE(same(again.codes, whole.codes)) << end;
  }
}

TEST(ChunkRest, StoppedAndFinishedGivesTheCodesOfTheWhole) {
  for_targets([] {
    for (const LatticeKind kind : {LatticeKind::d4star, LatticeKind::cc})
      for (const double share : {1.0, 0.6})
        for (const Int3& brick : {Int3{0, 0, 0}, Int3{1, 1, 0}}) {
          SCOPED_TRACE(share);
          expect_parts({noisy_sites(kind, ValueType::u8, 255, share, brick), codes_of(ValueType::u8, 100)});
          expect_parts(
              {noisy_sites(kind, ValueType::u16, 40000, share, brick), codes_of(ValueType::u16, 9000)});
        }
  });
}

TEST(ChunkRest, WhatSavesNothingIsDecodedWhole) {
  ChunkScratch scratch;
  const Coded floats(noisy_sites(LatticeKind::d4star, ValueType::f32, 1 << 30, 1, {0, 0, 0}),
                     codes_of(ValueType::f32, uint32_t{1} << 31));
  EXPECT_FALSE(floats.decode(scratch, 1).rest);
  // The layers behind are air.
  ChunkSites sites = noisy_sites(LatticeKind::d4star, ValueType::u8, 255, 1, {0, 0, 0});
  size_t two = 0;
  for (int m = 0; m < 2; ++m) {
    const auto [x, y, z] = sites.shape.box[m];
    two += x * y * z;
  }
  sites.codes.resize(two);
  std::fill(sites.kept.begin() + 2, sites.kept.end(), BrickMask{});
  const Coded ends(std::move(sites), codes_of(ValueType::u8, 100));
  EXPECT_FALSE(ends.decode(scratch, 2).rest);
  EXPECT_TRUE(ends.decode(scratch, 1).rest);
}

// A part is refused for what it has itself; that the index tells of values that are nowhere, when all is
// known.
TEST(ChunkRest, CodesAreCheckedAsFarAsTheyAreKnown) {
  Coded coded(noisy_sites(LatticeKind::d4star, ValueType::u8, 200, 1, {0, 0, 0}),
              codes_of(ValueType::u8, 100));
  ChunkScratch scratch;
  const ChunkData whole = coded.decode(scratch);
  Bcc4Chunk& entry = coded.chunk.entry;
  const uint32_t largest = entry.max_code;
  entry.max_code = largest + 1;
  EXPECT_THROW((void)coded.decode(scratch), Error);
  const ChunkData part = coded.decode(scratch, 2);
  EXPECT_THROW((void)finish_chunk(*part.rest, before(whole, 2), scratch), Error);
  EXPECT_THROW((void)finish_chunk(*part.rest, std::nullopt, scratch), Error);
  entry.max_code = entry.min_code;
  EXPECT_THROW((void)coded.decode(scratch, 2), Error);
  entry.max_code = largest;
  coded.chunk.bytes[entry.values_bytes - 1] ^= std::byte{1}; // of the last layer
  EXPECT_THROW((void)coded.decode(scratch, 1), Error);
}

// A series in slabs of four layers.
std::vector<std::byte> series() {
  VolumeInfo info = volume(LatticeKind::d4star, {40, 36, 24, 24}, {channel("a", ValueType::u8)});
  info.slab_layers = 4;
  return write_file(info, dense);
}

// Of a kernel without a prefilter, so that a moment reads the layers in its reach alone.
Kernel kernel_of_layers() {
  Kernel kernel = make_kernel("default");
  kernel.prefilter4.clear();
  return kernel;
}

struct Opened {
  Bench bench;
  std::shared_ptr<Bcc4Reader> reader;
  Bcc4Samples samples;
  Coefficients field;
  explicit Opened(const std::vector<std::byte>& file)
      : reader(Bcc4Reader::open(open_memory_source(file))), samples(reader, bench.memory),
        field(samples, 0, kernel_of_layers(), 0, 64 << 20) {}
  BrickLayer moment(double frame) { return time_slice(field, frame, {0, 0}, {}, bench.context).coset[0]; }
  [[nodiscard]] uint64_t chunks_of_layer() const { return reader->chunks(0, 1).size(); }
};

TEST(ChunkRest, AMomentDecodesNothingBehindItsLastLayer) {
  const auto file = series();
  for (double frame = 8; frame < 12; frame += 0.37) {
    Opened opened(file);
    const auto weights = instant_weights(opened.reader->info().lattice, opened.field.kernel(), frame);
    int32_t first = INT32_MAX, last = 0;
    for (const LayerWeight& w : weights) first = std::min(first, w.layer), last = std::max(last, w.layer);
    (void)opened.moment(frame);
    EXPECT_EQ(opened.samples.chunk_layers_decoded(), (last + 1 - first / 4 * 4) * opened.chunks_of_layer())
        << frame;
  }
}

// Every layer and byte once, though the first moments leave chunks that have begun; and the same bits.
TEST(ChunkRest, PlayingOnGoesOnWhereAMomentStopped) {
  const auto file = series();
  Opened whole(file);
  for (double first = 8; first < 11; first += 0.37) {
    Opened opened(file);
    for (double frame = first; frame < first + 6; frame += 0.5)
      ASSERT_FALSE(difference(opened.moment(frame), whole.moment(frame))) << first << ": " << frame;
    EXPECT_LE(opened.samples.chunk_layers_decoded(), 4 * opened.samples.chunks_decoded()) << first;
    std::set<int32_t> slabs;
    for (double frame = first; frame < first + 6; frame += 0.5)
      for (const LayerWeight& w :
           instant_weights(opened.reader->info().lattice, opened.field.kernel(), frame))
        slabs.insert(w.layer / 4);
    EXPECT_EQ(opened.samples.chunks_decoded(), slabs.size() * opened.chunks_of_layer()) << first;
  }
}

// Where nobody keeps the layers before it, a rest is decoded from the first layer on, without another read.
TEST(ChunkRest, ARestNeedsNothingElse) {
  const auto file = series();
  Opened opened(file);
  const std::array<int32_t, 5> asked{4, 5, 6, 7, 8};
  const auto read = [&](std::span<const int32_t> layers) {
    std::vector<BrickLayer> out;
    opened.samples.read_samples(0, layers, {}, opened.bench.context,
                                [&](int32_t, SampleLayer&& layer) { out.push_back(layer.as_values()); });
    return out;
  };
  (void)read(asked);
  EXPECT_EQ(opened.samples.chunk_layers_decoded(), 5 * opened.chunks_of_layer());
  const uint64_t bytes = opened.reader->bytes_read();
  const std::array<int32_t, 1> next{10};
  const BrickLayer layer = read(next)[0];
  EXPECT_EQ(opened.reader->bytes_read(), bytes);
  EXPECT_EQ(opened.samples.chunk_layers_decoded(), 9 * opened.chunks_of_layer());
  EXPECT_FALSE(difference(layer, read_all(file)[0][10]));
  // One that was handed over and forgotten is read again.
  const std::array<int32_t, 1> gone{8};
  EXPECT_FALSE(difference(read(gone)[0], read_all(file)[0][8]));
  EXPECT_GT(opened.reader->bytes_read(), bytes);
}

} // namespace
} // namespace bccsplat::test

// SPDX-License-Identifier: Apache-2.0
// Linear tiles: samples as near as asked without a rounding of their own, and sums of layers that are the
// sums of the layers, whatever sites these keep.
#include <gtest/gtest.h>

#include <numeric>
#include <random>

#include "tests/unit/formats/rebuild.h"
#include "tests/unit/formats/test_data.h"

namespace bccsplat {
namespace {

using namespace test;

constexpr int slab_layers = 6;

// offset: of the codes, in steps; where it is no whole number air has no code of its own.
VolumeInfo linear_volume(ValueType type, double error, double offset = 0) {
  VolumeInfo info = volume(LatticeKind::cc, {70, 41, 37, 14}, {channel("a", type, 3)});
  info.tile_edge = 2, info.slab_layers = slab_layers;
  ChannelInfo& c = info.channels[0];
  c.wavelet_error = error, c.linear = true;
  c.offset = c.air + offset * c.scale;
  return info;
}

Bcc4Samples samples_of(const Bytes& file, Bench& bench, RelativeTo to = RelativeTo::air,
                       uint64_t cache = 256 << 20) {
  return {Bcc4Reader::open(open_memory_source(file)), bench.memory, cache, to};
}

double largest_value(const BrickLayer& layer) {
  double largest = 0;
  for (size_t s = 0; s < layer.brick_slots(); ++s)
    for (int i = 0; layer.brick(s) && i < brick_sites; ++i)
      largest = std::max(largest, std::fabs(double{layer.brick(s)->value[i]}));
  return largest;
}

// Weights of all layers, of either sign.
LayerSum weighed_layers(int32_t layer, int32_t layers, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> weight(-1, 1);
  LayerSum sum{layer, {}};
  for (int32_t m = 0; m < layers; ++m) sum.terms.push_back({m, weight(random)});
  sum.terms.push_back({layer, weight(random)}); // as a mirror image comes again
  return sum;
}

void expect_sum_of_layers(const SampleSource& samples, const LayerSum& sum, const BrickLayer& got,
                          const Context& context) {
  std::vector<BrickLayer> layers;
  for (int32_t m = 0; m < samples.lattice().layers(); ++m)
    layers.push_back(samples.read_layer(0, m, {}, context));
  double largest = 0, weights = 0;
  for (const BrickLayer& layer : layers) largest = std::max(largest, largest_value(layer));
  for (const LayerSum::Term& term : sum.terms) weights += std::fabs(term.weight);
  ASSERT_GT(largest, 1);
  const double doubt = 5e-7 * largest * std::max(weights, 10.);
  int64_t holes = 0;
  for (size_t s = 0; s < got.brick_slots(); ++s) {
    const Brick *own = layers[sum.layer].brick(s), *brick = got.brick(s);
    for (int i = 0; i < brick_sites; ++i) {
      double expected = 0;
      for (const auto& [m, weight] : sum.terms)
        if (const Brick* b = layers[m].brick(s)) expected += double{weight} * b->value[i];
      ASSERT_NEAR(brick ? brick->value[i] : 0, expected, doubt) << s << ' ' << i;
      const bool hole = own && own->is_hole(i);
      ASSERT_EQ(brick && brick->is_hole(i), hole);
      holes += hole;
    }
  }
  EXPECT_GT(holes, 0);
}

TEST(LinearTiles, KeepTheErrorWithoutRounding) {
  const VolumeInfo info = linear_volume(ValueType::u8, .4);
  const Layers layers = make_volume(info, ball);
  const Bytes file = write_file(info, layers);
  Bench bench;
  const auto reader = Bcc4Reader::open(open_memory_source(file));
  EXPECT_TRUE(reader->info().channels[0].linear);
  for (const auto& damage : reader->verify_all(bench.context).damage) ADD_FAILURE() << damage.message;
  const Bcc4Samples samples = samples_of(file, bench);
  double squares = 0, sites = 0, parts = 0;
  for (int32_t m = 0; m < info.lattice.layers(); ++m) {
    const BrickLayer back = samples.read_layer(0, m, {}, bench.context);
    for (size_t s = 0; s < back.brick_slots(); ++s)
      for (int i = 0; i < brick_sites; ++i) {
        const double was = layers[0][m].brick(s) ? layers[0][m].brick(s)->value[i] : 0,
                     is = back.brick(s) ? back.brick(s)->value[i] : 0, steps = is / info.channels[0].scale;
        squares += (was - is) * (was - is), ++sites;
        parts += std::fabs(steps - std::nearbyint(steps)) > .1;
      }
  }
  EXPECT_LE(std::sqrt(squares / sites), .4 + .3 * info.channels[0].scale); // what was stored was rounded
  EXPECT_GT(parts, .01 * sites);
  EXPECT_EQ(write_file(info, layers, 3), file);
}

TEST(LinearTiles, SumsOfLayersAreTheirSums) {
  for (const double offset : {0., .3}) // then layers keep sites of their own
    for (const RelativeTo to : {RelativeTo::air, RelativeTo::base}) {
      SCOPED_TRACE(offset);
      const VolumeInfo info = linear_volume(ValueType::u16, .5, offset);
      const Bytes file = write_file(info, ball);
      Bench bench(2);
      const Bcc4Samples samples = samples_of(file, bench, to);
      ASSERT_TRUE(samples.adds_layers(0));
      const int32_t n = info.lattice.layers();
      const std::vector<LayerSum> sums{weighed_layers(2, n, 1), weighed_layers(n - 1, n, 2), {7, {{7, 1}}}};
      const std::vector<BrickLayer> got = samples.add_layers(0, sums, {}, bench.context);
      for (size_t i = 0; i < sums.size(); ++i) expect_sum_of_layers(samples, sums[i], got[i], bench.context);
    }
}

// Codes up to the largest there is, slabs of as many layers as there can be, weights that take away what
// others add: against sums in double precision of what each layer has.
TEST(LinearTiles, AddUpAtFullRange) {
  VolumeInfo info = volume(LatticeKind::cc, {33, 20, 18, 40}, {channel("a", ValueType::u16)});
  ChannelInfo& c = info.channels[0];
  info.tile_edge = 2, info.slab_layers = 32;
  c.scale = 1, c.offset = c.air = 0, c.wavelet_error = 20, c.linear = true;
  const Bytes file = write_file(info, [](int, double x, double y, double z, double t) {
    const double wave = std::sin(.4 * x + .2 * y - t) * std::cos(.3 * z);
    return Sample{static_cast<float>(32767.5 + 32767 * wave), true, x < 3};
  });
  Bench bench;
  const Bcc4Samples samples = samples_of(file, bench);
  LayerSum sum{35, {}};
  for (int32_t m = 0; m < 40; ++m) sum.terms.push_back({m, m % 2 ? -1.F : 1.F});
  expect_sum_of_layers(samples, sum, samples.add_layers(0, std::span(&sum, 1), {}, bench.context)[0],
                       bench.context);
}

// All of a field but a few sites, far from air: those count for air.
TEST(LinearTiles, SitesThatAreAbsentCountForAir) {
  VolumeInfo info = linear_volume(ValueType::u8, .4, 200.3);
  const Formula far = [](int, double x, double y, double z, double t) {
    Sample s = dense(0, x, y, z, t);
    s.value += 110;
    s.kept = std::fabs(x - 20) > .4 || std::fabs(y - 9) > .4 || std::fabs(z - 5 - t) > .4;
    s.hole = s.kept && x > 60 && y < 4;
    return s;
  };
  const Bytes file = write_file(info, far);
  Bench bench;
  const Bcc4Samples samples = samples_of(file, bench, RelativeTo::base);
  ASSERT_NE(samples.base(0), samples.air(0));
  const std::vector<LayerSum> sums{weighed_layers(3, info.lattice.layers(), 5)};
  expect_sum_of_layers(samples, sums[0], samples.add_layers(0, sums, {}, bench.context)[0], bench.context);
}

TEST(LinearTiles, AreTheSameInPartsAndWithoutACache) {
  const VolumeInfo info = linear_volume(ValueType::u8, .5);
  const Bytes file = write_file(info, ball);
  Bench bench, short_bench(1, 24 << 20);
  const Bcc4Samples samples = samples_of(file, bench),
                    uncached = samples_of(file, short_bench, RelativeTo::air, 0);
  const std::vector<LayerSum> sums{weighed_layers(4, info.lattice.layers(), 3)};
  const BrickBox box{{1, 0, 1}, {3, 2, 2}};
  const BrickLayer all = samples.add_layers(0, sums, {}, bench.context)[0],
                   part = samples.add_layers(0, sums, box, bench.context)[0],
                   slow = uncached.add_layers(0, sums, {}, short_bench.context)[0];
  int64_t found = 0;
  for (size_t s = 0; s < all.brick_slots(); ++s) {
    const Brick *whole = all.brick(s), *again = slow.brick(s), *inside = part.brick(s);
    ASSERT_EQ(!whole, !again);
    if (whole) {
      EXPECT_EQ(whole->value, again->value);
    }
    if (!box.contains(all.slot_position(s))) {
      EXPECT_FALSE(inside);
    } else if (whole) {
      ASSERT_TRUE(inside);
      EXPECT_EQ(whole->value, inside->value);
      ++found;
    }
  }
  EXPECT_GT(found, 0);
}

// Layers of one slab are read together, as far as there is room, and no others.
TEST(LinearTiles, AreReadSlabBySlab) {
  const VolumeInfo info = linear_volume(ValueType::u8, .5);
  const Bytes file = write_file(info, ball);
  const auto peak = [&](std::vector<int32_t> layers) {
    Bench bench;
    int32_t next = 0;
    samples_of(file, bench, RelativeTo::air, 0)
        .read_layers(0, layers, {}, bench.context,
                     [&](int32_t m, const BrickLayer&) { EXPECT_EQ(m, next++); });
    EXPECT_EQ(next, static_cast<int32_t>(layers.size()));
    return bench.memory.peak();
  };
  std::vector<int32_t> all(info.lattice.layers());
  std::iota(all.begin(), all.end(), 0);
  const std::vector<int32_t> slab(all.begin(), all.begin() + slab_layers), one(all.begin(), all.begin() + 1);
  EXPECT_GT(peak(slab), peak(one));
  EXPECT_LT(peak(all), peak(slab) * 5 / 4);
}

// Holes are those of the layer whose holes a sum has, what else is there is as it was.
TEST(LinearTiles, OfADamagedFileLoseATile) {
  const VolumeInfo info = linear_volume(ValueType::u8, .5);
  Bytes file = write_file(info, ball);
  const auto whole = Bcc4Reader::open(open_memory_source(file));
  Bench bench;
  const std::vector<LayerSum> sums{weighed_layers(slab_layers, info.lattice.layers(), 8),
                                   weighed_layers(0, slab_layers, 9)};
  const BrickLayer before = samples_of(file, bench).add_layers(0, sums, {}, bench.context)[1];
  const Bcc4Chunk hit = whole->chunks(0, 1)[0];
  file[hit.offset] ^= std::byte{0xff};
  Bcc4Limits limits;
  limits.salvage = true;
  const Bcc4Samples samples(Bcc4Reader::open(open_memory_source(file), limits), bench.memory);
  const Int3 at = whole->brick_position(hit.slot);
  const std::vector<BrickLayer> added = samples.add_layers(0, sums, {}, bench.context);
  for (const BrickLayer& layer : {samples.read_layer(0, slab_layers, {}, bench.context), added.front()}) {
    const Brick* lost = layer.brick(at[0], at[1], at[2]);
    ASSERT_TRUE(lost);
    for (int i = 0; i < brick_sites; ++i) ASSERT_TRUE(lost->is_hole(i));
  }
  for (size_t s = 0; s < before.brick_slots(); ++s) // of the slab before alone
    if (before.brick(s)) {
      EXPECT_EQ(before.brick(s)->value, added.back().brick(s)->value);
    }
  const Bcc4Samples strict = samples_of(file, bench);
  EXPECT_THROW((void)strict.read_layer(0, slab_layers, {}, bench.context), Error);
}

} // namespace
} // namespace bccsplat

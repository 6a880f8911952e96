// SPDX-License-Identifier: Apache-2.0
// Prefiltered layers: against the stages' formula, and whatever the memory.
#include "field/coefficients/coefficients.h"

#include <gtest/gtest.h>

#include <atomic>

#include "formats/bcc4/coding/layer_codes.h"
#include "kernel/cc_kernel.h"
#include "slice/time_slice.h"
#include "tests/support/dense_layer.h"
#include "tests/support/emulated.h"
#include "tests/support/fields.h"
#include "tests/support/larger.h"
#include "tests/support/targets.h"

namespace bccsplat {
namespace {

using test::large_cache;
using test::TestContext;

// A series of noise in [-1, 1] in which whole blocks are air.
MemorySamples noise_samples(const Lattice4& lattice, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> value(-1, 1);
  std::vector<BrickLayer> layers;
  for (int32_t m = 0; m < lattice.layers(); ++m) {
    const int c = lattice.coset(m);
    std::vector<float> dense(static_cast<size_t>(lattice.space.sites(c)));
    for (float& v : dense) v = value(random);
    layers.push_back(test::layer_from_dense(lattice.space, c, dense));
    for (size_t s = 0; s < layers.back().brick_slots() && layers.back().brick_slots() > 1; ++s)
      if (random() % 3 == 0) layers.back().set(s, nullptr);
  }
  std::vector<std::vector<BrickLayer>> channels;
  channels.push_back(std::move(layers));
  return {lattice, {0}, std::move(channels)};
}

// All layers of a series as dense arrays of doubles.
using Series = std::vector<std::vector<double>>;

Series dense_series(const MemorySamples& samples, const Context& context) {
  Series s;
  for (int32_t m = 0; m < samples.lattice().layers(); ++m) {
    const auto dense = layer_to_dense(samples.read_layer(0, m, {}, context));
    s.emplace_back(dense.begin(), dense.end());
  }
  return s;
}

// One stage as kernel.h writes it, every neighbour by its mirror image.
Series stage_reference(const Lattice4& lattice, const PrefilterStage& stage, const Series& c,
                       const Series& f) {
  const auto at = [&](const Series& s, int32_t layer, const Int3& i) {
    const int32_t m = lattice.mirror_layer(layer);
    const int coset = lattice.coset(m);
    const Int3 n = lattice.space.dims(coset);
    size_t index = 0;
    for (size_t a = 3; a-- > 0;) index = index * n[a] + lattice.space.mirror(a, coset, i[a]);
    return s[m][index];
  };
  const auto spatial = [&](const Series& s, int32_t m, const Int3& i) {
    double sum = 0;
    for (size_t a = 0; a < 3; ++a)
      for (const int d : {-1, 1}) {
        Int3 j = i;
        j[a] += d;
        sum += at(s, m, j);
      }
    return sum;
  };
  const auto own = [&](const Series& s, int32_t m, const Int3& i, double w, double ws, double wt, double wm) {
    double sum = w * at(s, m, i) + ws * spatial(s, m, i);
    if (lattice.is_static()) return sum;
    for (const int d : {-lattice.layer_period(), lattice.layer_period()})
      sum += wt * at(s, m + d, i) + wm * spatial(s, m + d, i);
    return sum;
  };
  Series out = c;
  for (int32_t m = 0; m < lattice.layers(); ++m) {
    const int coset = lattice.coset(m);
    const Int3 n = lattice.space.dims(coset);
    size_t index = 0;
    for (int z = 0; z < n[2]; ++z)
      for (int y = 0; y < n[1]; ++y)
        for (int x = 0; x < n[0]; ++x, ++index) {
          const Int3 i{x, y, z};
          double sum =
              own(c, m, i, stage.self, stage.spatial, stage.temporal, stage.mixed) +
              own(f, m, i, stage.source, stage.source_spatial, stage.source_temporal, stage.source_mixed);
          if (stage.cross != 0 && !lattice.space.bcc)
            for (int k = 0; k < 8; ++k)
              sum += stage.cross * at(f, m, {x + 2 * (k & 1) - 1, y + (k & 2) - 1, z + 2 * (k >> 2) - 1});
          else if (stage.cross != 0)
            for (const int d : {-1, 1}) {
              if (lattice.is_static() && d < 0) continue;
              // Sites i - 1 and i of coset 1 surround site i of coset 0; i and i + 1 the other way round.
              for (int k = 0; k < 8; ++k)
                sum += stage.cross *
                       at(c, m + d,
                          {x + (k & 1) - 1 + coset, y + (k >> 1 & 1) - 1 + coset, z + (k >> 2) - 1 + coset});
            }
          out[m][index] = sum;
        }
  }
  return out;
}

// Every target's layers against `expected`, and, bit by bit, against each other.
void expect_layers(const MemorySamples& samples, const Kernel& kernel, const Series& expected, double largest,
                   const Context& context) {
  std::vector<std::vector<float>> first;
  test::for_targets([&] {
    const Coefficients made(samples, 0, kernel, 0, large_cache);
    for (int32_t m = 0; m < samples.lattice().layers(); ++m) {
      const auto dense = layer_to_dense(*made.layer(m, context));
      if (first.size() == static_cast<size_t>(m)) first.push_back(dense);
      ASSERT_EQ(dense, first[m]) << kernel.name << " layer " << m;
      for (size_t i = 0; i < dense.size(); ++i)
        ASSERT_NEAR(dense[i], expected[m][i], 2e-6 * largest)
            << kernel.name << " layer " << m << " site " << i;
    }
  });
}

double largest_of(const Series& s) {
  double largest = 1;
  for (const auto& layer : s)
    for (const double v : layer) largest = larger(largest, std::fabs(v));
  return largest;
}

// Sizes at which bricks end in the middle, one coset has a brick more than the other, and mirrors fall in
// different bricks; the smallest; and one of several tiles.
constexpr std::array<uint32_t, 4> awkward_sizes[] = {{24, 25, 12, 5}, {47, 24, 4, 3},  {46, 3, 23, 1},
                                                     {2, 1, 3, 2},    {70, 9, 9, 1},   {33, 17, 16, 4},
                                                     {150, 50, 6, 2}, {110, 70, 20, 1}};

TEST(Coefficients, AreTheStagesFormulaOnEveryTarget) {
  TestContext context;
  for (const auto& dims : awkward_sizes) {
    const auto lattice = Lattice4::fit(LatticeKind::d4star, dims);
    const auto samples = noise_samples(lattice, dims[0]);
    for (const char* name : {"default", "fast", "gauss09"}) {
      const Kernel kernel = make_kernel(name);
      Series c = dense_series(samples, context.get());
      const Series f = c;
      double largest = 1;
      for (const PrefilterStage& stage : lattice.is_static() ? kernel.prefilter3 : kernel.prefilter4) {
        c = stage_reference(lattice, stage, c, f);
        largest = std::max(largest, largest_of(c));
      }
      expect_layers(samples, kernel, c, largest, context.get());
    }
  }
}

TEST(Coefficients, OnCcAreTheStagesInSpaceAndThenInTime) {
  TestContext context;
  for (const auto& dims : awkward_sizes) {
    const auto lattice = Lattice4::fit(LatticeKind::cc, dims);
    const auto samples = noise_samples(lattice, dims[0]);
    for (const char* name : {"default", "radial18+b4"}) {
      const CcKernel kernel = make_cc_kernel(name);
      Series c = dense_series(samples, context.get());
      double largest = 1;
      const auto apply = [&](const std::vector<PrefilterStage>& stages) {
        const Series f = c;
        for (const PrefilterStage& stage : stages) {
          c = stage_reference(lattice, stage, c, f);
          largest = std::max(largest, largest_of(c));
        }
      };
      apply(kernel.kernel.prefilter3);
      if (!lattice.is_static()) apply(kernel.time);
      expect_layers(samples, make_kernel(name), c, largest, context.get());
    }
  }
}

// Who goes through a series once holds the layers in reach of one instant, and gets the same ones.
TEST(Coefficients, WhatIsForgottenIsNotHeldAndWhatIsMadeIsTheSame) {
  for (const LatticeKind kind : {LatticeKind::d4star, LatticeKind::cc}) {
    TestContext context, whole;
    const auto lattice = Lattice4::fit(kind, {40, 36, 34, 40});
    const auto samples = noise_samples(lattice, 8);
    const Kernel kernel = make_kernel("default");
    const Coefficients all(samples, 0, kernel, 0, large_cache), once(samples, 0, kernel, 0, large_cache);
    uint64_t most = 0, layer_bytes = 0;
    for (int32_t m = 0; m < lattice.layers(); ++m) {
      const auto expected = layer_to_dense(*all.layer(m, whole.get()));
      layer_bytes = std::max(layer_bytes, all.layer(m, whole.get())->bytes());
      EXPECT_EQ(layer_to_dense(*once.layer(m, context.get())), expected) << "layer " << m;
      once.forget(m - 2, m + 1);
      most = std::max(most, context.memory.used());
      // Those that are kept need not be made anew.
      if (m >= 2) {
        const uint64_t held = context.memory.used();
        EXPECT_EQ(layer_to_dense(*once.layer(m - 2, context.get())),
                  layer_to_dense(*all.layer(m - 2, whole.get())));
        EXPECT_EQ(context.memory.used(), held);
      }
    }
    EXPECT_LT(most, 18 * layer_bytes);
    EXPECT_GT(whole.memory.used(), 60 * layer_bytes);
    once.forget(lattice.layers(), INT32_MAX);
    EXPECT_EQ(context.memory.used(), 0u);
  }
}

// A layer is made tile by tile, and tiles are smaller the more threads there are; layers that are made
// together share what they depend on.
TEST(Coefficients, AreTheSameForAnyTilesThreadsAndCompany) {
  for (const LatticeKind kind : {LatticeKind::d4star, LatticeKind::cc}) {
    const auto lattice = Lattice4::fit(kind, {150, 60, 100, 9});
    const auto samples = noise_samples(lattice, 11);
    const Kernel kernel = make_kernel("default");
    TestContext one(1), many(16);
    const Coefficients alone(samples, 0, kernel, 0, large_cache),
        together(samples, 0, kernel, 0, large_cache);
    const std::vector<int32_t> wanted{6, 2, 3, 5, -1}; // 5 and 6 look beyond the end as well
    const auto made = together.layers(wanted, many.get());
    for (size_t i = 0; i < wanted.size(); ++i)
      EXPECT_EQ(layer_to_dense(*made[i]), layer_to_dense(*alone.layer(wanted[i], one.get()))) << wanted[i];
  }
}

// Hands over samples as codes, as integers of a file are held.
struct Packing final : SampleSource {
  const MemorySamples& inner;
  explicit Packing(const MemorySamples& s) : inner(s) {}
  const Lattice4& lattice() const override { return inner.lattice(); }
  int channels() const override { return 1; }
  float air(int c) const override { return inner.air(c); }
  BrickLayer read_layer(int c, int32_t m, const BrickBox& region, const Context& context) const override {
    return inner.read_layer(c, m, region, context);
  }
  void read_samples(int c, std::span<const int32_t> layers, const BrickBox& region, const Context& context,
                    const TakeLayer<SampleLayer>& take) const override {
    const SampleCoder coder(Quantiser{ValueType::u8, 1, 0, 0});
    for (const int32_t m : layers) {
      const BrickLayer values = read_layer(c, m, region, context);
      SampleLayer packed(values);
      for (size_t slot = 0; slot < values.brick_slots(); ++slot)
        if (const Brick* brick = values.brick(slot)) {
          auto codes = LayerCodes::of(coder, *brick);
          ASSERT_TRUE(codes);
          packed.set(slot, {nullptr, std::move(codes)});
        }
      take(m, std::move(packed));
    }
  }
};

// Codes are read a vector at a time, beyond the ends of what is asked for: bricks beside air, in tiles whose
// margins end in them.
TEST(Coefficients, OfCodesAreThoseOfValues) {
  std::vector<std::pair<std::array<uint32_t, 4>, int>> cases{{{75, 70, 40, 3}, 2}, {{50, 50, 50, 1}, 2}};
  if (!test::emulated) { // these have more tiles, of the same kinds, and take most of the time
    cases.push_back({{150, 60, 100, 9}, 3});
    cases.push_back({{150, 60, 100, 9}, 1});
  }
  for (const LatticeKind kind : {LatticeKind::d4star, LatticeKind::cc})
    for (const auto& [dims, air] : cases) {
      const auto lattice = Lattice4::fit(kind, dims);
      std::mt19937 random(dims[0] + air);
      std::vector<std::vector<BrickLayer>> channels(1);
      for (int32_t m = 0; m < lattice.layers(); ++m) {
        const int c = lattice.coset(m);
        std::vector<float> dense(static_cast<size_t>(lattice.space.sites(c)));
        for (float& v : dense) v = static_cast<float>(random() % 30);
        channels[0].push_back(test::layer_from_dense(lattice.space, c, dense));
        for (size_t s = 0; s < channels[0].back().brick_slots(); ++s)
          if (random() % 4 < static_cast<uint32_t>(air)) channels[0].back().set(s, nullptr);
      }
      const MemorySamples values(lattice, {0}, std::move(channels));
      const Packing codes(values);
      for (const int threads : {1, 2, 16}) {
        TestContext context(threads);
        const Coefficients expected(values, 0, make_kernel("default"), 0, large_cache),
            found(codes, 0, make_kernel("default"), 0, large_cache);
        for (int32_t m = 0; m < lattice.layers(); ++m)
          ASSERT_EQ(layer_to_dense(*found.layer(m, context.get())),
                    layer_to_dense(*expected.layer(m, context.get())))
              << threads << " threads, layer " << m;
      }
    }
}

TEST(Coefficients, TakeOverTheHolesOfSamples) {
  TestContext context;
  const auto lattice = Lattice4::fit(LatticeKind::d4star, {40, 40, 40, 3});
  std::vector<std::vector<BrickLayer>> channels(1);
  for (int32_t m = 0; m < lattice.layers(); ++m) channels[0].emplace_back(lattice.space, lattice.coset(m));
  auto brick = std::make_shared<Brick>(); // of holes whose fill is air, in a layer without anything else
  brick->hole = std::make_unique<BrickMask>();
  (*brick->hole)[17] = 0x0240;
  const size_t slot = channels[0][1].slot(1, 0, 1);
  channels[0][1].set(slot, std::move(brick));
  const MemorySamples samples(lattice, {0}, std::move(channels));
  const Coefficients field(samples, 0, make_kernel("default"), 0, large_cache);
  for (int32_t m = 0; m < lattice.layers(); ++m) {
    const auto layer = field.layer(m, context.get());
    for (size_t s = 0; s < layer->brick_slots(); ++s) {
      const bool expected = m == 1 && s == slot;
      ASSERT_EQ(layer->brick(s) != nullptr, expected) << m << ' ' << s;
      if (!expected) continue;
      ASSERT_TRUE(layer->brick(s)->hole);
      EXPECT_EQ((*layer->brick(s)->hole)[17], 0x0240);
      EXPECT_EQ(layer->brick(s)->count(), 0);
    }
  }
}

TEST(Coefficients, BeyondTheLatticeAndBelowThePruningIsAir) {
  TestContext context;
  const auto lattice = Lattice4::fit(LatticeKind::d4star, {30, 26, 20, 4});
  const auto samples = noise_samples(lattice, 5);
  const float prune = 0.4f;
  const Coefficients all(samples, 0, make_kernel("default"), 0, large_cache);
  const Coefficients some(samples, 0, make_kernel("default"), prune, large_cache);
  for (int32_t m = 0; m < lattice.layers(); ++m) {
    const auto a = all.layer(m, context.get()), b = some.layer(m, context.get());
    const Int3 n = a->dims();
    for (size_t s = 0; s < a->brick_slots(); ++s) {
      if (!b->brick(s)) continue;
      ASSERT_TRUE(a->brick(s));
      const Int3 at = a->slot_position(s);
      for (int i = 0; i < brick_sites; ++i) {
        const Int3 site{at[0] * 16 + i % 16, at[1] * 16 + i / 16 % 16, at[2] * 16 + i / 256};
        const bool inside = site[0] < n[0] && site[1] < n[1] && site[2] < n[2];
        const size_t k = i;
        const float v = a->brick(s)->value[k];
        const bool kept = inside && std::fabs(v) > prune;
        ASSERT_EQ(b->brick(s)->value[k], kept ? v : 0.0f);
        ASSERT_EQ(b->brick(s)->kept[k / 16] >> (i % 16) & 1, kept);
        if (!inside) {
          ASSERT_EQ(v, 0.0f);
        }
      }
    }
  }
}

// Counts the bricks that are asked for.
struct Counting final : SampleSource {
  const MemorySamples& inner;
  mutable std::atomic<int64_t> bricks{0};
  explicit Counting(const MemorySamples& s) : inner(s) {}
  const Lattice4& lattice() const override { return inner.lattice(); }
  int channels() const override { return 1; }
  float air(int c) const override { return inner.air(c); }
  BrickLayer read_layer(int c, int32_t m, const BrickBox& region, const Context& context) const override {
    const BrickLayer whole = inner.read_layer(c, m, region, context);
    BrickLayer part(whole.lattice(), whole.coset());
    for (size_t s = 0; s < whole.brick_slots(); ++s)
      if (region.contains(whole.slot_position(s))) part.set(s, whole.share(s)), ++bricks;
    return part;
  }
};

TEST(Coefficients, SmallCacheMeansMoreWorkButNotAgainAndAgain) {
  TestContext context;
  const auto lattice = Lattice4::fit(LatticeKind::d4star, {20, 20, 150, 30});
  const auto samples = noise_samples(lattice, 3);
  const int64_t height = 7; // bricks along z
  for (const char* name : {"default", "fine"}) {
    const Kernel kernel = make_kernel(name);
    const Coefficients roomy(samples, 0, kernel, 0, large_cache);
    for (const uint64_t cache : {uint64_t{0}, uint64_t{3} << 20}) {
      const Counting source(samples);
      const Coefficients tight(source, 0, kernel, 0, cache);
      for (int32_t m = 10; m < 20; ++m)
        ASSERT_EQ(layer_to_dense(*tight.layer(m, context.get())),
                  layer_to_dense(*roomy.layer(m, context.get())))
            << name << " layer " << m;
      // Per layer: itself once to see how large it is, and its reach of 2 * 2 + stages - 1 layers on either
      // side, each brick once whatever the stretches.
      const auto reach = prefilter_reach(kernel.prefilter4).time;
      EXPECT_LE(source.bricks, 10 * height * (1 + 2 * reach + 1)) << name << " cache " << cache;
      EXPECT_EQ(time_slice(tight, 9.3, {0, 0}, {}, context.get()).bounds,
                time_slice(roomy, 9.3, {0, 0}, {}, context.get()).bounds);
    }
  }
}

TEST(Coefficients, StretchesStayWithinTheCacheAndTheResult) {
  const auto lattice = Lattice4::fit(LatticeKind::d4star, {20, 20, 900, 20});
  const auto samples = noise_samples(lattice, 4);
  TestContext all;
  const Coefficients roomy(samples, 0, make_kernel("default"), 0, large_cache);
  const Slice expected = time_slice(roomy, 7.2, {0, 0}, {}, all.get());
  const uint64_t six = 6 * expected.coset[0].bytes(); // layers in the hands of the slice
  const uint64_t planes = 3u << 19;                   // of the tile that is under way
  for (const uint64_t cache : {uint64_t{3} << 19, uint64_t{5} << 18}) {
    TestContext context;
    const Coefficients tight(samples, 0, make_kernel("default"), 0, cache);
    const Slice slice = time_slice(tight, 7.2, {0, 0}, {}, context.get());
    for (size_t c = 0; c < 2; ++c)
      EXPECT_EQ(layer_to_dense(slice.coset[c]), layer_to_dense(expected.coset[c]));
    EXPECT_LE(context.memory.peak(), six + 2 * cache + planes);
    EXPECT_GT(all.memory.peak(), six + 2 * cache + planes); // it would have been more
    EXPECT_LE(context.memory.used(), cache);
  }
}

TEST(Coefficients, EachLayerOfSamplesIsReadOnceWhileTimeAdvances) {
  TestContext context;
  const auto lattice = Lattice4::fit(LatticeKind::d4star, {20, 20, 20, 40});
  const auto samples = noise_samples(lattice, 6);
  const Counting source(samples);
  const Coefficients c(source, 0, make_kernel("default"), 0, 64u << 20);
  for (int32_t m = 10; m < 40; ++m) (void)c.layer(m, context.get());
  const int reach = prefilter_reach(c.kernel().prefilter4).time;
  EXPECT_EQ(source.bricks, 30 + 2 * reach); // one brick per layer
}

} // namespace
} // namespace bccsplat

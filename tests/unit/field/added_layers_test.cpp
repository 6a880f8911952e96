// SPDX-License-Identifier: Apache-2.0
// Coefficients of a source that adds layers: those that all stages of the prefilter make of its samples.
#include <gtest/gtest.h>

#include <atomic>
#include <random>
#include <set>
#include <string>

#include "field/coefficients/coefficients.h"
#include "points/rounded_brick.h"
#include "slice/cut_plan.h"
#include "slice/time_slice.h"
#include "tests/support/dense_layer.h"
#include "tests/support/fields.h"

namespace bccsplat {
namespace {

using test::large_cache;
using test::TestContext;

// Layers in memory, sums of which can be asked for.
class AddingSamples final : public SampleSource {
 public:
  // step: of samples, for those who may round what they make of them.
  explicit AddingSamples(MemorySamples samples, double step = 0)
      : samples_(std::move(samples)), step_(step) {}
  const Lattice4& lattice() const override { return samples_.lattice(); }
  int channels() const override { return 1; }
  float air(int channel) const override { return samples_.air(channel); }
  BrickLayer read_layer(int channel, int32_t layer, const BrickBox& box, const Context& c) const override {
    ++read;
    return samples_.read_layer(channel, layer, box, c);
  }
  double sample_step(int) const override { return step_; }
  bool adds_layers(int) const override { return true; }
  uint64_t bricks_at_most(int channel, std::span<const int32_t> layers, const BrickBox&) const override {
    TestContext test;
    return samples_.read_layer(channel, layers[0], {}, test.get()).brick_slots();
  }
  std::vector<BrickLayer> add_layers(int channel, std::span<const LayerSum> sums, const BrickBox& region,
                                     const Context& context) const override {
    added += sums.size();
    std::vector<BrickLayer> out;
    for (const LayerSum& sum : sums) {
      BrickLayer& layer = out.emplace_back(lattice().space, lattice().coset(sum.layer));
      for (size_t s = 0; s < layer.brick_slots(); ++s) {
        if (!region.contains(layer.slot_position(s))) continue;
        auto brick = std::make_shared<Brick>();
        for (const auto& [m, weight] : sum.terms) {
          const BrickLayer of = samples_.read_layer(channel, m, {}, context);
          for (size_t i = 0; of.brick(s) && i < brick_sites; ++i)
            brick->value[i] += weight * of.brick(s)->value[i];
        }
        brick->kept.fill(0xffff);
        const BrickLayer own = samples_.read_layer(channel, sum.layer, {}, context);
        if (own.brick(s) && own.brick(s)->hole)
          brick->hole = std::make_unique<BrickMask>(*own.brick(s)->hole);
        layer.set(s, std::move(brick));
      }
      if (keeps) kept.push_back(layer);
    }
    return out;
  }
  mutable std::atomic<uint64_t> read{0}, added{0};
  bool keeps = false; // whether layers that were added stay here
  mutable std::vector<BrickLayer> kept;

 private:
  MemorySamples samples_;
  double step_;
};

MemorySamples layers_of_noise(const Lattice4& lattice) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> value(-1, 1);
  std::vector<BrickLayer> layers;
  for (int32_t m = 0; m < lattice.layers(); ++m) {
    std::vector<float> dense(static_cast<size_t>(lattice.space.sites(0)));
    for (float& v : dense) v = value(random);
    layers.push_back(test::layer_from_dense(lattice.space, 0, dense));
  }
  std::vector<std::vector<BrickLayer>> channels;
  channels.push_back(std::move(layers));
  return {lattice, {0}, std::move(channels)};
}

Lattice4 cartesian(uint32_t frames, bool periodic = false) {
  Lattice4 lattice = Lattice4::fit(LatticeKind::cc, {36, 21, 50, frames});
  if (periodic) lattice.periodic = true;
  return lattice;
}

// The same that goes round along an axis, too, where the last row of bricks is narrow.
Lattice4 going_round(size_t axis) {
  Lattice4 lattice = cartesian(5);
  lattice.space.periodic[axis] = true;
  return lattice;
}

double most_apart(const BrickLayer& a, const BrickLayer& b) {
  double largest = 0;
  for (int z = 0; z < a.dims()[2]; ++z)
    for (int y = 0; y < a.dims()[1]; ++y)
      for (int x = 0; x < a.dims()[0]; ++x)
        largest = std::max(largest, std::fabs(double{a.value(x, y, z)} - b.value(x, y, z)));
  return largest;
}

void expect_same_layer(const BrickLayer& a, const BrickLayer& b) {
  for (size_t s = 0; s < a.brick_slots(); ++s) {
    ASSERT_EQ(!a.brick(s), !b.brick(s));
    if (a.brick(s)) {
      EXPECT_EQ(a.brick(s)->value, b.brick(s)->value);
    }
  }
}

TEST(AddedLayers, GiveWhatAllStagesMake) {
  TestContext test;
  for (const uint32_t frames : {1u, 2u, 5u, 12u})
    for (const char* kernel : {"exact", "default", "radial18+b4", "fast"}) {
      SCOPED_TRACE(testing::Message() << kernel << " of " << frames);
      const MemorySamples plain = layers_of_noise(cartesian(frames));
      const AddingSamples adding(plain);
      const Coefficients expected(plain, 0, make_kernel(kernel), 0, large_cache),
          got(adding, 0, make_kernel(kernel), 0, large_cache);
      for (const int32_t m : {0, static_cast<int32_t>(frames) / 2, static_cast<int32_t>(frames) - 1})
        EXPECT_LT(most_apart(*expected.layer(m, test.get()), *got.layer(m, test.get())), 2e-5);
      EXPECT_EQ(adding.read, 0u);
      EXPECT_GT(adding.added, 0u);
    }
}

TEST(AddedLayers, OfAPeriodicSeriesGoRound) {
  TestContext test;
  const MemorySamples plain = layers_of_noise(cartesian(9, true));
  const AddingSamples adding(plain);
  const Coefficients expected(plain, 0, make_kernel("exact"), 0, large_cache),
      got(adding, 0, make_kernel("exact"), 0, large_cache);
  for (const int32_t m : {0, 8})
    EXPECT_LT(most_apart(*expected.layer(m, test.get()), *got.layer(m, test.get())), 2e-5);
}

// In stretches where the cache is short, and in a box, they are the same to the bit; the next moment asks for
// nothing that is there.
TEST(AddedLayers, DependOnNoCacheAndNoBox) {
  TestContext test;
  for (const char* kernel : {"exact", "default"}) {
    const AddingSamples adding(layers_of_noise(cartesian(6)));
    const BrickBox box{{1, 0, 1}, {3, 2, 2}};
    constexpr uint64_t little = 300 << 10;
    const Coefficients whole(adding, 0, make_kernel(kernel), 0, large_cache),
        narrow(adding, 0, make_kernel(kernel), 0, little),
        part(adding, 0, make_kernel(kernel), 0, large_cache, box);
    const std::vector<int32_t> wanted{2, 3, 4};
    const auto all = whole.layers(wanted, test.get());
    const uint64_t once = adding.added;
    EXPECT_EQ(once, wanted.size());
    const auto slow = narrow.layers(wanted, test.get());
    EXPECT_GT(adding.added, 2 * once); // it took several stretches
    const auto boxed = part.layers(wanted, test.get());
    for (size_t i = 0; i < wanted.size(); ++i) {
      expect_same_layer(*all[i], *slow[i]);
      for (size_t s = 0; s < all[i]->brick_slots(); ++s) {
        if (!box.contains(all[i]->slot_position(s))) continue;
        ASSERT_TRUE(boxed[i]->brick(s));
        EXPECT_EQ(all[i]->brick(s)->value, boxed[i]->brick(s)->value);
      }
    }
    const uint64_t before = adding.added;
    (void)whole.layers(std::vector<int32_t>{3, 4, 5}, test.get());
    EXPECT_EQ(adding.added, before + 1);
  }
}

TEST(AddedLayers, OfAPeriodicAxisGoRound) {
  TestContext test;
  for (const size_t axis : {0, 1, 2}) {
    const MemorySamples plain = layers_of_noise(going_round(axis));
    const AddingSamples adding(plain);
    const Coefficients expected(plain, 0, make_kernel("exact"), 0, large_cache),
        got(adding, 0, make_kernel("exact"), 0, large_cache);
    EXPECT_LT(most_apart(*expected.layer(2, test.get()), *got.layer(2, test.get())), 2e-5);
  }
}

// The prefilter writes over bricks that nobody else has, and over no others.
TEST(AddedLayers, ThatAreHeldElsewhereStay) {
  TestContext test;
  const MemorySamples noise = layers_of_noise(cartesian(6));
  const AddingSamples adding(noise);
  AddingSamples keeping(noise);
  keeping.keeps = true;
  const Coefficients own(adding, 0, make_kernel("exact"), 0, large_cache),
      shared(keeping, 0, make_kernel("exact"), 0, large_cache);
  const auto expected = own.layer(3, test.get()), got = shared.layer(3, test.get());
  expect_same_layer(*expected, *got);
  ASSERT_EQ(keeping.kept.size(), 1U);
  const Coefficients anew(keeping, 0, make_kernel("exact"), 0, large_cache);
  (void)anew.layer(3, test.get());
  expect_same_layer(keeping.kept.front(), keeping.kept.back());
  EXPECT_GT(most_apart(keeping.kept.front(), *got), 0.1);
}

// The field at the instant of a layer is what it is beside it, and made of that layer alone.
TEST(AddedLayers, OfAStillAreOne) {
  TestContext test;
  for (const bool periodic : {false, true})
    for (const uint32_t frames : {2u, 5u, 12u}) {
      const AddingSamples adding(layers_of_noise(cartesian(frames, periodic)));
      const Coefficients field(adding, 0, make_kernel("exact"), 0, large_cache);
      ASSERT_TRUE(plan_moment(field, 1, {}, {}).still);
      ASSERT_FALSE(plan_moment(field, 0.5, {}, {}).still);
      for (const int32_t m : {0, static_cast<int32_t>(frames) / 2, static_cast<int32_t>(frames) - 1}) {
        SCOPED_TRACE(testing::Message() << m << " of " << frames);
        const Slice still = merged_moment(plan_moment(field, m, {}, {}), {}, test.get());
        const double beside = m == 0 ? 1e-7 : m - 1e-7;
        const Slice near = merged_moment(plan_moment(field, beside, {}, {}), {}, test.get());
        EXPECT_LT(most_apart(still.coset[0], near.coset[0]), 5e-4);
        EXPECT_GT(still.bounds[1], 0.5);
      }
      const uint64_t before = adding.added;
      fetch(plan_moment(field, 1, {}, {}), test.get());
      const bool known = frames == 2;
      EXPECT_EQ(adding.added, before + (known ? 0 : 1));
      fetch(plan_moment(field, 1, {}, {}), test.get());
      EXPECT_EQ(adding.added, before + (known ? 0 : 1)); // it is kept
    }
  for (const char* kernel : {"default", "fast", "exact"}) { // a static volume has no instants
    const AddingSamples adding(layers_of_noise(cartesian(kernel == std::string("exact") ? 1 : 4)));
    const Coefficients field(adding, 0, make_kernel(kernel), 0, large_cache);
    EXPECT_FALSE(plan_moment(field, 0, {}, {}).still);
  }
}

// A still is told apart from the layer of that number that moments are merged of, in what is read for it and
// in what others know it by.
TEST(AddedLayers, OfAStillAreNotThoseOfMoments) {
  TestContext test;
  const AddingSamples adding(layers_of_noise(cartesian(12)));
  const Coefficients field(adding, 0, make_kernel("exact"), 0, large_cache),
      other(adding, 0, make_kernel("exact"), 0, large_cache);
  HypersliceOptions options;
  options.merge_later = true;
  const auto series = [&](const Coefficients& of, double frame) {
    return merged_moment(plan_moment(of, frame, {}, options), {}, test.get()).coset.moment()->series();
  };
  EXPECT_EQ(
      std::set<uint64_t>({series(field, 5), series(field, 5.5), series(other, 5), series(other, 5.5)}).size(),
      4U);
  const CutPlan still = plan_moment(field, 8, {}, {}), moment = plan_moment(field, 8.25, {}, {});
  LayerReads one, around, missing;
  list_layers(still, true, one), list_layers(moment, true, around);
  EXPECT_EQ(one.size(), 1U);
  EXPECT_GT(around.size(), 3U);
  fetch(still, test.get());
  list_layers(still, true, missing);
  EXPECT_TRUE(missing.empty());
  list_layers(moment, true, missing);
  EXPECT_EQ(missing.size(), around.size());
  const std::vector<int32_t> eighth{8};
  const auto range = [&](bool of_still) {
    const auto layer = field.compact_layers(eighth, test.get(), of_still).front();
    return field.range(8, of_still, layer, test.get());
  };
  EXPECT_NE(range(true), range(false));
}

TEST(AddedLayers, OfAStillDependOnNoCacheAndNoBox) {
  TestContext test;
  const AddingSamples adding(layers_of_noise(cartesian(6)));
  const BrickBox box{{1, 0, 1}, {3, 2, 2}};
  constexpr uint64_t little = 300 << 10;
  const Coefficients whole(adding, 0, make_kernel("exact"), 0, large_cache),
      narrow(adding, 0, make_kernel("exact"), 0, little),
      part(adding, 0, make_kernel("exact"), 0, large_cache, box);
  const auto values = [&](const Coefficients& of) {
    return merged_moment(plan_moment(of, 3, {}, {}), {}, test.get());
  };
  const Slice all = values(whole);
  const uint64_t once = adding.added;
  const Slice slow = values(narrow);
  EXPECT_GT(adding.added, once + 1); // it took several stretches
  const Slice boxed = values(part);
  expect_same_layer(all.coset[0], slow.coset[0]);
  for (size_t s = 0; s < all.coset[0].brick_slots(); ++s) {
    if (!box.contains(all.coset[0].slot_position(s))) continue;
    ASSERT_TRUE(boxed.coset[0].brick(s));
    EXPECT_EQ(all.coset[0].brick(s)->value, boxed.coset[0].brick(s)->value);
  }
}

HypersliceOptions once() {
  HypersliceOptions options;
  options.once = true;
  return options;
}

// What nothing follows is added once, whatever the kernel weighs: instants, means, sums over time, frames.
TEST(AddedLayers, OfOneMomentAreOneSum) {
  TestContext test;
  struct Case {
    const char* kernel;
    double frame;
    std::array<double, 2> interval;
    ThicknessKind kind;
    bool periodic;
  };
  for (const auto& [kernel, frame, interval, kind, periodic] :
       {Case{"exact", 6.4, {0, 0}, ThicknessKind::mean, false},
        {"exact", 0.2, {0, 0}, ThicknessKind::mean, false},
        {"exact", 7, {0, 0}, ThicknessKind::mean, false},
        {"default", 6.4, {0, 0}, ThicknessKind::mean, false},
        {"default", 7, {0, 0}, ThicknessKind::mean, false},
        {"exact", 6.4, {-1, 2.5}, ThicknessKind::mean, false},
        {"exact", 8.6, {0, 0}, ThicknessKind::mean, true}}) {
    SCOPED_TRACE(testing::Message() << kernel << " at " << frame);
    const AddingSamples adding(layers_of_noise(cartesian(9, periodic)));
    const Coefficients layers(adding, 0, make_kernel(kernel), 0, large_cache),
        sum(adding, 0, make_kernel(kernel), 0, large_cache);
    HypersliceOptions options;
    options.thickness.kind = kind;
    const Slice expected = merged_moment(plan_moment(layers, frame, interval, options), {}, test.get());
    options.once = true;
    const CutPlan plan = plan_moment(sum, frame, interval, options);
    const uint64_t before = adding.added;
    const Slice got = merged_moment(plan, {}, test.get());
    EXPECT_EQ(adding.added, before + 1);
    EXPECT_EQ(sum.layers_made(), 1U);
    EXPECT_LT(most_apart(expected.coset[0], got.coset[0]), 1e-4);
    EXPECT_EQ(expected.points(), got.points());
    for (size_t end = 0; end < 2; ++end) EXPECT_NEAR(expected.bounds[end], got.bounds[end], 1e-3);
    // Nothing is kept.
    (void)merged_moment(plan, {}, test.get());
    EXPECT_EQ(adding.added, before + 2);
  }
}

// Where some of its layers are there it is made of layers, and they are kept.
TEST(AddedLayers, ThatAreHeldAreMergedEvenOnce) {
  TestContext test;
  const AddingSamples adding(layers_of_noise(cartesian(16)));
  const Coefficients field(adding, 0, make_kernel("exact"), 0, large_cache);
  const auto moment = [&](double frame, const HypersliceOptions& options) {
    return merged_moment(plan_moment(field, frame, {}, options), {}, test.get());
  };
  const Slice expected = moment(6.4, {});
  const uint64_t made = adding.added;
  expect_same_layer(expected.coset[0], moment(6.4, once()).coset[0]);
  EXPECT_EQ(adding.added, made);
  (void)moment(7.4, once());
  EXPECT_EQ(adding.added, made + 1); // the one that is not there
  (void)moment(7.3, {});
  EXPECT_EQ(adding.added, made + 1);
}

// One sum has the holes of the layer that weighs most, as layers that are merged do; of one box, or in
// stretches, it is the same.
TEST(AddedLayers, OfOneMomentHaveItsHolesAndItsBox) {
  TestContext test;
  const Lattice4 lattice = cartesian(9);
  std::vector<std::vector<BrickLayer>> channels(1);
  const MemorySamples noise = layers_of_noise(lattice);
  for (int32_t m = 0; m < lattice.layers(); ++m) {
    BrickLayer layer = noise.read_layer(0, m, {}, test.get());
    auto brick = std::make_shared<Brick>();
    brick->value = layer.brick(0)->value, brick->kept = layer.brick(0)->kept;
    brick->hole = std::make_unique<BrickMask>();
    (*brick->hole)[static_cast<size_t>(m)] = 1;
    layer.set(0, std::move(brick));
    channels[0].push_back(std::move(layer));
  }
  const AddingSamples adding(MemorySamples(lattice, {0}, std::move(channels)));
  const BrickBox box{{0, 0, 1}, {2, 2, 3}};
  constexpr uint64_t little = 300 << 10;
  const Coefficients layers(adding, 0, make_kernel("exact"), 0, large_cache),
      sum(adding, 0, make_kernel("exact"), 0, large_cache),
      narrow(adding, 0, make_kernel("exact"), 0, little),
      part(adding, 0, make_kernel("exact"), 0, large_cache, box);
  for (const double frame : {3.2, 3.8}) {
    const auto moment = [&](const Coefficients& of, const HypersliceOptions& options) {
      return merged_moment(plan_moment(of, frame, {}, options), {}, test.get());
    };
    const Slice expected = moment(layers, {}), got = moment(sum, once());
    EXPECT_TRUE(got.has_holes);
    ASSERT_TRUE(got.coset[0].brick(0)->hole);
    EXPECT_EQ(*expected.coset[0].brick(0)->hole, *got.coset[0].brick(0)->hole);
    EXPECT_TRUE(got.coset[0].brick(0)->is_hole(brick_edge * (frame < 3.5 ? 3 : 4)));
    expect_same_layer(got.coset[0], moment(narrow, once()).coset[0]);
    const Slice boxed = moment(part, once());
    for (size_t s = 0; s < got.coset[0].brick_slots(); ++s) {
      if (!box.contains(got.coset[0].slot_position(s))) continue;
      ASSERT_TRUE(boxed.coset[0].brick(s));
      EXPECT_EQ(got.coset[0].brick(s)->value, boxed.coset[0].brick(s)->value);
    }
  }
}

TEST(AddedLayers, AreKeptAsNumbersWhereTheirStepAllows) {
  TestContext test;
  constexpr double step = 1.0 / 64;
  const MemorySamples noise = layers_of_noise(cartesian(6));
  const AddingSamples plain(noise), stepped(noise, step);
  for (const char* kernel : {"exact", "default"}) {
    const Coefficients exact(plain, 0, make_kernel(kernel), 0, large_cache),
        rounded(stepped, 0, make_kernel(kernel), 0, large_cache);
    const auto layer = rounded.compact_layers(std::vector<int32_t>{3}, test.get()).front();
    ASSERT_TRUE(layer.compact);
    for (size_t s = 0; s < layer.brick_slots(); ++s) EXPECT_TRUE(layer.compact->brick(s).codes);
    EXPECT_LE(layer.compact->bytes(),
              exact.compact_layers(std::vector<int32_t>{3}, test.get()).front().compact->bytes() * 2 / 3);
    EXPECT_LE(most_apart(*exact.layer(3, test.get()), *rounded.layer(3, test.get())),
              coarsest_step(step) / 2);
  }
}

} // namespace
} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// The streaming fit as a machine: slabs in order, bounded memory, lattice samples given directly, data
// that do not fit.
#include <gtest/gtest.h>

#include <random>

#include "fit/kept/packed_block.h"
#include "tests/unit/fit/fit_series.h"

namespace bccsplat::test {
namespace {

Code code_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& e) {
    return e.code();
  }
  return Code::ok;
}

TEST(FitStream, SlabsComeInOrderForEveryChannel) {
  const Series s = noise({9, 8, 7, 23}, 1);
  FitOptions o = options_for(s);
  o.dims[3] = 0;
  o.slab_layers = 5;
  o.channels.resize(3);
  o.channels[2].quantiser = quantiser_of_source(SourceType::f32, 1);
  Bench bench;
  std::array<std::vector<BrickLayer>, 3> layers;
  std::array<int32_t, 3> slabs{};
  Fit fit(
      o,
      [&](int32_t slab, int channel, std::span<const BrickLayer> given) {
        const size_t c = channel;
        EXPECT_EQ(slab, slabs[c]++);
        EXPECT_EQ(layers[c].size(), static_cast<size_t>(slab) * 5);
        EXPECT_LE(given.size(), 5u);
        layers[c].insert(layers[c].end(), given.begin(), given.end());
      },
      bench.context);
  for (uint32_t t = 0; t < 23; ++t)
    for (const int channel : {2, 0, 1}) {
      const FrameBox box = s.box(t);
      fit.add_frame(channel, {&box, channel == 1 ? size_t{0} : size_t{1}});
    }
  const FitReport report = fit.finish();
  EXPECT_EQ(report.lattice, Lattice4::fit(o.lattice, s.dims));
  for (const auto& l : layers) EXPECT_EQ(l.size(), static_cast<size_t>(report.lattice.layers()));
  for (int32_t m = 0; m < report.lattice.layers(); ++m)
    EXPECT_EQ(layers[0][m].coset(), report.lattice.coset(m));
  EXPECT_GT(report.channels[0].sites_kept, 0u);
  EXPECT_EQ(report.channels[1].sites_kept, 0u);
  const auto reference = reference_layers(report.lattice, s, 1);
  EXPECT_LT(worst_difference({report, layers[2]}, reference), 2e-6);
}

TEST(FitStream, LayersComeAsSoonAsTheirFramesAreThere) {
  const Series s = noise({5, 5, 5, 40}, 2);
  FitOptions o = options_for(s);
  o.slab_layers = 1;
  Bench bench;
  int32_t given = 0;
  Fit fit(
      o, [&](int32_t, int, std::span<const BrickLayer>) { ++given; }, bench.context);
  for (uint32_t t = 0; t < 40; ++t) {
    const FrameBox box = s.box(t);
    fit.add_frame(0, {&box, 1});
    // Layer m needs frames up to floor(m / sqrt 2) + 4; 40 frames end the series.
    int32_t expected = 0;
    while (std::floor(expected / std::numbers::sqrt2) + 4 <= t) ++expected;
    if (t == 39) expected = fit.lattice().layers();
    EXPECT_GE(given, expected) << t;
  }
}

TEST(FitStream, MemoryDoesNotGrowWithTheSeries) {
  uint64_t peak[2], bound = 0;
  for (const uint32_t frames : {30u, 90u}) {
    const Series s = noise({40, 36, 34, frames}, 3);
    FitOptions o = options_for(s);
    o.dims[3] = 0;
    Bench bench;
    Fit fit(
        o, [](int32_t, int, std::span<const BrickLayer>) {}, bench.context);
    for (uint32_t t = 0; t < frames; ++t) {
      const FrameBox box = s.box(t);
      fit.add_frame(0, {&box, 1});
    }
    EXPECT_EQ(fit.finish().channels[0].frames.size(), frames);
    peak[frames == 90] = bench.memory.peak();
    const Lattice4 l = Lattice4::fit(o.lattice, s.dims);
    uint64_t bricks = BrickLayer(l.space, 0).brick_slots() + BrickLayer(l.space, 1).brick_slots();
    // Frames within reach (8 and those that wait for the next layer), a slab of 8 layers, work space.
    bound = bricks * 11 * sizeof(float) * brick_sites + bricks * 4 * sizeof(Brick) + (4 << 20);
  }
  EXPECT_EQ(peak[0], peak[1]);
  EXPECT_LT(peak[1], bound);
}

// Frames within reach take two bytes a site of both cosets, nine of them 13 bytes a voxel, and a slab of
// bytes 8 of a third of a byte; bricks beyond the faces besides.
TEST(FitStream, AVoxelOfBytesTakesFewBytes) {
  const std::array<uint32_t, 4> dims{64, 64, 64, 24};
  const size_t voxels = size_t{dims[0]} * dims[1] * dims[2];
  FitOptions o;
  o.dims = dims;
  o.channels[0].quantiser = {ValueType::u8, 1, 0, 0};
  o.channels[0].unit = packing_unit(o.channels[0].quantiser);
  Bench bench;
  uint64_t slab_bytes = 0;
  Fit fit(
      o,
      [&](int32_t, int, const SlabLayers& layers) {
        for (const SampleLayer& layer : layers.compact()) slab_bytes = std::max(slab_bytes, layer.bytes());
      },
      bench.context);
  std::mt19937 random(5);
  std::vector<uint8_t> values(voxels);
  for (uint32_t t = 0; t < dims[3]; ++t) {
    for (uint8_t& v : values) v = static_cast<uint8_t>(1 + random() % 255);
    FrameBox box;
    box.data = values.data(), box.type = SourceType::u8, box.dims = {dims[0], dims[1], dims[2]};
    fit.add_frame(0, {&box, 1});
  }
  (void)fit.finish();
  const auto sites = static_cast<double>(fit.lattice().space.sites(0));
  EXPECT_LT(static_cast<double>(slab_bytes), 1.5 * sites);
  EXPECT_LT(static_cast<double>(bench.memory.peak()) / static_cast<double>(voxels), 23);
}

TEST(FitStream, GivesTheMemoryBack) {
  Bench bench;
  {
    const Series s = noise({20, 20, 20, 6}, 4);
    FitOptions o = options_for(s);
    Fit fit(
        o, [](int32_t, int, std::span<const BrickLayer>) {}, bench.context);
    const FrameBox box = s.box(0);
    fit.add_frame(0, {&box, 1});
    fit.add_frame(0, {&box, 1});
    EXPECT_GT(bench.memory.used(), 0u);
  }
  EXPECT_EQ(bench.memory.used(), 0u);
}

TEST(FitStream, RefusesToExceedTheBudget) {
  const Series s = noise({64, 64, 64, 2}, 5);
  Bench bench(2, 1 << 20);
  FitOptions o = options_for(s);
  Fit fit(
      o, [](int32_t, int, std::span<const BrickLayer>) {}, bench.context);
  const FrameBox box = s.box(0);
  EXPECT_EQ(code_of([&] { fit.add_frame(0, {&box, 1}); }), Code::memory_budget);
}

TEST(FitStream, StopsWhenCancelled) {
  const Series s = noise({40, 40, 40, 2}, 5);
  Bench bench;
  FitOptions o = options_for(s);
  Fit fit(
      o, [](int32_t, int, std::span<const BrickLayer>) {}, bench.context);
  bench.progress.cancel();
  const FrameBox box = s.box(0);
  EXPECT_EQ(code_of([&] { fit.add_frame(0, {&box, 1}); }), Code::cancelled);
}

TEST(FitStream, DirectLayersAreKeptAsTheyAre) {
  for (const uint32_t frames : {1u, 9u}) {
    FitOptions o;
    o.dims = {30, 22, 41, frames};
    o.channels[0].threshold = 0.5f;
    o.channels[0].quantiser = quantiser_of_source(SourceType::f32, 1);
    const Lattice4 l = Lattice4::fit(o.lattice, o.dims);
    Bench bench(2);
    std::vector<BrickLayer> layers;
    Fit fit(
        o,
        [&](int32_t, int, std::span<const BrickLayer> given) {
          layers.insert(layers.end(), given.begin(), given.end());
        },
        bench.context);
    std::mt19937 random(3);
    std::uniform_real_distribution<float> uniform(0, 3);
    std::vector<std::vector<float>> samples;
    uint64_t kept = 0;
    float low = 9, high = 0;
    for (int32_t m = 0; m < l.layers(); ++m) {
      samples.emplace_back(static_cast<size_t>(l.space.sites(l.coset(m))));
      for (float& v : samples.back()) {
        v = uniform(random);
        kept += std::fabs(v - 1) > 0.5f;
        low = std::min(low, v);
        high = std::max(high, v);
      }
      fit.add_layer(0, samples.back());
    }
    const FitReport report = fit.finish();
    EXPECT_EQ(report.lattice, l);
    EXPECT_EQ(report.channels[0].sites_kept, kept);
    EXPECT_EQ(report.channels[0].source_range.low, static_cast<double>(low));
    EXPECT_EQ(report.channels[0].source_range.high, static_cast<double>(high));
    EXPECT_TRUE(report.channels[0].frames.empty());
    for (int32_t m = 0; m < l.layers(); ++m) {
      const auto dense = layer_to_dense(layers[m]);
      const auto& given = samples[m];
      ASSERT_EQ(dense.size(), given.size());
      for (size_t i = 0; i < dense.size(); ++i)
        ASSERT_EQ(dense[i], std::fabs(given[i] - 1) > 0.5f ? given[i] - 1 : 0.0f);
    }
  }
}

TEST(FitStream, DirectLayersFollowThePolicyForWhatIsNotFinite) {
  FitOptions o;
  o.dims = {12, 12, 12, 1};
  const Lattice4 l = Lattice4::fit(o.lattice, o.dims);
  std::vector<float> samples(l.space.sites(0), 2.0f), rest(l.space.sites(1), 2.0f);
  samples[5] = NAN;
  samples[9] = INFINITY;
  const auto fit_with = [&](NonFinite policy) {
    o.nonfinite = policy;
    Bench bench;
    Fitted f;
    Fit fit(
        o, [&](int32_t, int, std::span<const BrickLayer> g) { f.layers.assign(g.begin(), g.end()); },
        bench.context);
    fit.add_layer(0, samples);
    fit.add_layer(0, rest);
    f.report = fit.finish();
    return f;
  };
  EXPECT_EQ(code_of([&] { (void)fit_with(NonFinite::error); }), Code::nonfinite_value);
  const Fitted clamped = fit_with(NonFinite::clamp), holes = fit_with(NonFinite::hole);
  EXPECT_EQ(clamped.report.channels[0].nonfinite, 2u);
  EXPECT_EQ(clamped.report.channels[0].holes, 0u);
  EXPECT_EQ(clamped.dense(0)[5], 0.0f);
  EXPECT_EQ(clamped.dense(0)[9], 2.0f);
  EXPECT_EQ(holes.report.channels[0].holes, 2u);
  for (const float v : holes.dense(0)) EXPECT_EQ(v, 2.0f);
  EXPECT_TRUE(holes.layers[0].brick(0)->is_hole(5));
}

// Not finite throughout is not missing where it may be clamped: it is air, and infinities the ends of the
// range.
TEST(FitStream, ClampsAFrameThatIsNotFiniteThroughout) {
  const auto middle_of = [](float value) {
    const Series s({9, 9, 9, 9},
                   [&](double, double, double, double t) { return t == 4 ? value : 2 + t / 8; });
    FitOptions o = options_for(s, LatticeKind::cc);
    o.nonfinite = NonFinite::clamp;
    return run_fit(o, s).dense(4)[364];
  };
  EXPECT_EQ(middle_of(NAN), 0.0f);
  EXPECT_EQ(middle_of(INFINITY), 2.375f); // the largest so far
  EXPECT_EQ(middle_of(-INFINITY), 2.0f);
}

TEST(FitStream, RefusesWhatDoesNotFit) {
  const Series s = noise({6, 6, 6, 3}, 1);
  const FrameBox box = s.box(0);
  const auto make = [&](uint32_t frames, Bench& bench) {
    FitOptions o = options_for(s);
    o.dims[3] = frames;
    return std::make_unique<Fit>(
        o, [](int32_t, int, std::span<const BrickLayer>) {}, bench.context);
  };
  Bench bench;
  std::vector<float> layer(Lattice4::fit(LatticeKind::d4star, s.dims).space.sites(0), 1.0f);
  EXPECT_EQ(code_of([&] { (void)make(0, bench)->finish(); }), Code::wrong_state);
  EXPECT_EQ(code_of([&] { (void)make(3, bench)->finish(); }), Code::wrong_state);
  EXPECT_EQ(code_of([&] { make(3, bench)->add_layer(0, std::span(layer).subspan(1)); }),
            Code::invalid_argument);
  EXPECT_EQ(code_of([&] { make(3, bench)->add_frame(1, {&box, 1}); }), Code::invalid_argument);
  EXPECT_EQ(code_of([&] { make(3, bench)->add_frame(-1, {&box, 1}); }), Code::invalid_argument);
  const auto static_one = make(0, bench);
  static_one->add_frame(0, {&box, 1});
  EXPECT_EQ(static_one->finish().lattice.kind, LatticeKind::bcc);
}

TEST(FitStream, RefusesSizesBeyondReason) {
  for (const std::array<uint32_t, 4> dims : {std::array<uint32_t, 4>{4000000000u, 1, 1, 1},
                                             {100000, 100000, 100000, 0},
                                             {UINT32_MAX, UINT32_MAX, UINT32_MAX, 9}}) {
    FitOptions o;
    o.dims = dims;
    Bench bench;
    EXPECT_EQ(code_of([&] {
                Fit(
                    o, [](int32_t, int, std::span<const BrickLayer>) {}, bench.context);
              }),
              Code::limit_exceeded);
  }
  FitOptions o;
  o.dims = {4, 4, 0, 4};
  Bench bench;
  EXPECT_EQ(code_of([&] {
              Fit(
                  o, [](int32_t, int, std::span<const BrickLayer>) {}, bench.context);
            }),
            Code::invalid_argument);
}

} // namespace
} // namespace bccsplat::test

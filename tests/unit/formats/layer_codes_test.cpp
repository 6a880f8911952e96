// SPDX-License-Identifier: Apache-2.0
// Samples that stay as codes are those that bricks of values have, whichever part of them is read.
#include "formats/bcc4/coding/layer_codes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <utility>

#include "tests/support/targets.h"
#include "tests/unit/formats/test_data.h"

namespace bccsplat::test {
namespace {

std::vector<SampleLayer> read_samples(const Bcc4Samples& samples, Bench& bench) {
  std::vector<int32_t> numbers(static_cast<size_t>(samples.lattice().layers()));
  std::iota(numbers.begin(), numbers.end(), 0);
  std::vector<SampleLayer> layers;
  samples.read_samples(0, numbers, {}, bench.context, [&](int32_t m, SampleLayer&& layer) {
    EXPECT_EQ(m, static_cast<int32_t>(layers.size()));
    layers.push_back(std::move(layer));
  });
  return layers;
}

// The values of a part of a brick, and nothing beside it that is not allowed to be, are written.
void expect_part(const SampleBrick& brick, const Brick& values, const PlanePart& p) {
  constexpr size_t stride = 40;
  constexpr float mark = -1e30f;
  std::vector<float> rows(stride * (brick_edge + 1), mark);
  brick.codes->read(p, rows.data(), stride);
  const size_t width = p.width, height = p.height;
  for (size_t y = 0; y < height; ++y)
    for (size_t x = 0; x < width; ++x)
      ASSERT_EQ(rows[y * stride + x], values.value[((p.plane * 16 + p.y) * 16 + p.x) + y * 16 + x]);
  for (size_t y = 0; y <= brick_edge; ++y) {
    const size_t written = y >= height ? 0 : width == brick_edge ? brick_edge : width + 15;
    for (size_t x = written; x < stride; ++x) ASSERT_EQ(rows[y * stride + x], mark);
  }
}

void expect_same(const SampleLayer& layer, const BrickLayer& expected) {
  ASSERT_EQ(layer.coset(), expected.coset());
  ASSERT_EQ(layer.dims(), expected.dims());
  for (size_t s = 0; s < expected.brick_slots(); ++s) {
    const Brick* values = expected.brick(s);
    const SampleBrick& brick = layer.brick(s);
    ASSERT_EQ(static_cast<bool>(brick), values != nullptr);
    if (!values) continue;
    ASSERT_EQ(brick.hole() != nullptr, values->hole != nullptr);
    if (values->hole) {
      ASSERT_EQ(*brick.hole(), *values->hole);
    }
    std::array<float, brick_sites> room;
    ASSERT_TRUE(std::equal(values->value.begin(), values->value.end(), brick.all(room)));
    if (!brick.codes) continue;
    for (const PlanePart& part :
         {PlanePart{0, 0, 0, 16, 16}, PlanePart{15, 3, 11, 5, 5}, PlanePart{7, 0, 2, 16, 1},
          PlanePart{8, 15, 15, 1, 1}, PlanePart{3, 0, 0, 15, 16}})
      expect_part(brick, *values, part);
  }
}

// Rows of many runs, of one and of none.
Sample ragged(int c, double x, double y, double z, double t) {
  Sample s = dense(c, x, y, z, t);
  const bool many = std::sin(40 * x + 17 * y + t) > -0.5;
  s.kept = std::fmod(y + z, 3) < 1 ? many : std::fmod(y + z, 3) < 2 && x > 5 + z;
  s.value = s.kept ? s.value : 0;
  return s;
}

struct CodesCase {
  LatticeKind lattice;
  ValueType type;
  double scale;
};

class LayerCodesOf : public testing::TestWithParam<CodesCase> {};

TEST_P(LayerCodesOf, AreTheSamplesOfBricks) {
  const auto [lattice, type, scale] = GetParam();
  for (const auto& formula : {ball, dense, ragged}) {
    VolumeInfo info = volume(lattice, {40, 37, 25, 9}, {channel("value", type, 3)});
    info.channels[0].scale = scale;
    const auto file = write_file(info, formula);
    Bench bench;
    const Bcc4Samples samples(Bcc4Reader::open(open_memory_source(file)), bench.memory);
    const std::vector<SampleLayer> layers = read_samples(samples, bench);
    const Layers expected = read_all(file);
    ASSERT_EQ(layers.size(), expected[0].size());
    uint64_t coded = 0, bytes = 0, floats = 0;
    for (size_t m = 0; m < layers.size(); ++m) {
      for_targets([&] { expect_same(layers[m], expected[0][m]); });
      for (size_t s = 0; s < layers[m].brick_slots(); ++s) coded += layers[m].brick(s).codes != nullptr;
      bytes += layers[m].bytes(), floats += expected[0][m].bytes();
    }
    EXPECT_EQ(coded > 0, !is_float(type));
    if (!is_float(type)) {
      EXPECT_LT(bytes, floats * 7 / 10); // much less where bricks are full
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Types, LayerCodesOf,
                         testing::Values(CodesCase{LatticeKind::d4star, ValueType::u8, 0.5},
                                         CodesCase{LatticeKind::d4star, ValueType::u8, 1.0 / 3},
                                         CodesCase{LatticeKind::d4star, ValueType::u16, 1.0 / 256},
                                         CodesCase{LatticeKind::cc, ValueType::u16, 0.01},
                                         CodesCase{LatticeKind::d4star, ValueType::f16, 1},
                                         CodesCase{LatticeKind::cc, ValueType::f32, 1}));

TEST(LayerCodes, SinglePrecisionIsTakenWhereItIsExact) {
  const auto coder = [](ValueType type, double scale, double offset, float air) {
    Quantiser q;
    q.type = type, q.scale = scale, q.offset = offset, q.air = air;
    return SampleCoder(q);
  };
  EXPECT_TRUE(coder(ValueType::u8, 1, 0, 0).is_single());
  EXPECT_TRUE(coder(ValueType::u16, 1, -32768, 100).is_single());
  EXPECT_FALSE(coder(ValueType::u8, 1.0 / 3, 0, 0).is_single());
  EXPECT_FALSE(coder(ValueType::u16, 0.1, 0, 0).is_single());
  EXPECT_FALSE(coder(ValueType::f16, 1, 0, 0).is_single());
}

TEST(LayerCodes, LayersReadTogetherAreDecodedOnceWithoutACache) {
  const VolumeInfo info = volume(LatticeKind::d4star, {40, 40, 40, 20}, {channel("value", ValueType::u8)});
  const auto file = write_file(info, dense);
  const auto reader = Bcc4Reader::open(open_memory_source(file));
  Bench bench;
  const Bcc4Samples together(reader, bench.memory, 0);
  const auto layers = read_samples(together, bench);
  EXPECT_EQ(together.chunks_decoded(), reader->chunk_count());
  const Bcc4Samples apart(reader, bench.memory, 0);
  for (int32_t m = 0; m < apart.lattice().layers(); ++m) {
    const BrickLayer one = apart.read_layer(0, m, {}, bench.context);
    expect_same(layers[m], one);
  }
  EXPECT_GT(apart.chunks_decoded(), 6 * reader->chunk_count());
}

TEST(LayerCodes, LayersOutsideTheFileAreRefused) {
  const auto file =
      write_file(volume(LatticeKind::d4star, {20, 20, 20, 4}, {channel("value", ValueType::u8)}), dense);
  Bench bench;
  const Bcc4Samples samples(Bcc4Reader::open(open_memory_source(file)), bench.memory);
  const std::array<int32_t, 2> beyond{0, samples.lattice().layers()};
  EXPECT_THROW(samples.read_samples(0, beyond, {}, bench.context, [](int32_t, SampleLayer&&) {}), Error);
}

// A brick of values that a type can hold: some of its sites, of which some are holes.
Brick coded_brick(const SampleCoder& coder, uint32_t seed) {
  std::mt19937 random(seed);
  Brick brick;
  brick.value.fill(0);
  brick.hole = std::make_unique<BrickMask>();
  for (size_t site = 0; site < brick_sites; ++site) {
    if (random() % 5 == 0 && site / brick_edge % 3 > 0) continue; // every third row is full
    const auto bit = static_cast<uint16_t>(1u << (site % brick_edge));
    brick.kept[site / brick_edge] |= bit;
    if (random() % 9 == 0) (*brick.hole)[site / brick_edge] |= bit;
    brick.value[site] = coder.decode(static_cast<uint32_t>(random()) & coder.codes().mask());
  }
  return brick;
}

TEST(LayerCodes, ABrickOfValuesIsItsCodes) {
  for (const ValueType type : {ValueType::u8, ValueType::u16})
    for (const Quantiser& q : {Quantiser{type, 1, 0, 3}, Quantiser{type, 0.37, -12.5, 1.25f}}) {
      const SampleCoder coder(q);
      const Brick brick = coded_brick(coder, 5);
      std::shared_ptr<const LayerCodes> codes;
      std::vector<uint32_t> first, given;
      for_targets([&] {
        codes = LayerCodes::of(coder, brick);
        ASSERT_TRUE(codes);
        given.clear();
        codes->append_codes(given);
        if (first.empty()) first = given;
        EXPECT_EQ(given, first);
      });
      const auto back = SampleBrick{nullptr, codes}.as_values();
      EXPECT_EQ(back->value, brick.value);
      EXPECT_EQ(back->kept, brick.kept);
      EXPECT_EQ(*back->hole, *brick.hole);
      EXPECT_TRUE(codes->coded_as(coder));
      EXPECT_FALSE(codes->coded_as(SampleCoder(Quantiser{type, q.scale * 2, q.offset, q.air})));
      std::vector<uint32_t> expected;
      uint64_t clamped = 0;
      for (size_t site = 0; site < brick_sites; ++site)
        if (brick.kept[site / brick_edge] >> (site % brick_edge) & 1)
          expected.push_back(coder.encode(brick.value[site], clamped));
      EXPECT_EQ(given, expected);
    }
}

TEST(LayerCodes, ValuesThatNoCodeGivesStayValues) {
  const SampleCoder coder(Quantiser{ValueType::u8, 1, 0, 0});
  Brick brick = coded_brick(coder, 6);
  EXPECT_TRUE(LayerCodes::of(coder, brick));
  for (const size_t first : {size_t{6} * brick_edge, size_t{7} * brick_edge}) // of a full row and another
    for (const float wrong : {0.25f, 256.0f, -1.0f, -0.0f, std::numeric_limits<float>::quiet_NaN()}) {
      size_t site = first;
      while (!(brick.kept[site / brick_edge] >> (site % brick_edge) & 1)) ++site;
      const float right = std::exchange(brick.value[site], wrong);
      for_targets([&] { EXPECT_FALSE(LayerCodes::of(coder, brick)) << site << " " << wrong; });
      brick.value[site] = right;
    }
  const SampleCoder floats(Quantiser{ValueType::f32, 1, 0, 0});
  EXPECT_FALSE(LayerCodes::of(floats, coded_brick(coder, 6)));
}

} // namespace
} // namespace bccsplat::test

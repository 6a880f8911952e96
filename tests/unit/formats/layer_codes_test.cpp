// Samples that stay as codes are those that bricks of values have, whichever part of them is read.
#include "formats/bcc4/coding/layer_codes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

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

// The values of a part of a brick, and nothing beside it, are written.
void expect_part(const SampleBrick& brick, const Brick& values, const PlanePart& p) {
  constexpr int stride = 21;
  constexpr float mark = -1e30f;
  std::vector<float> rows(stride * brick_edge, mark);
  brick.codes->read(p, rows.data(), stride);
  for (int y = 0; y < p.height; ++y)
    for (int x = 0; x < p.width; ++x)
      ASSERT_EQ(rows[static_cast<size_t>(y * stride + x)],
                values.value[static_cast<size_t>((p.plane * 16 + p.y + y) * 16 + p.x + x)]);
  for (int i = p.width; i < stride; ++i) ASSERT_EQ(rows[static_cast<size_t>(i)], mark);
  for (size_t i = static_cast<size_t>(p.height) * stride; i < rows.size(); ++i) ASSERT_EQ(rows[i], mark);
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

TEST(LayerCodes, AreTheSamplesOfBricks) {
  for (const LatticeKind kind : {LatticeKind::d4star, LatticeKind::cc})
    for (const ValueType type : {ValueType::u8, ValueType::u16, ValueType::f16, ValueType::f32})
      for (const auto& formula : {ball, dense}) {
        const VolumeInfo info = volume(kind, {40, 37, 25, 9}, {channel("value", type, 3)});
        const auto file = write_file(info, formula);
        Bench bench;
        const Bcc4Samples samples(Bcc4Reader::open(open_memory_source(file)), bench.memory);
        const std::vector<SampleLayer> layers = read_samples(samples, bench);
        const Layers expected = read_all(file);
        ASSERT_EQ(layers.size(), expected[0].size());
        uint64_t coded = 0, bytes = 0;
        for (size_t m = 0; m < layers.size(); ++m) {
          expect_same(layers[m], expected[0][m]);
          for (size_t s = 0; s < layers[m].brick_slots(); ++s) coded += layers[m].brick(s).codes != nullptr;
          bytes += layers[m].bytes();
        }
        EXPECT_EQ(coded > 0, !is_float(type));
        // Small bricks at the faces hold few codes, and so do those of the ball.
        uint64_t floats = 0;
        for (const BrickLayer& layer : expected[0]) floats += layer.bytes();
        if (!is_float(type)) {
          EXPECT_LT(bytes, floats * 6 / 10);
        }
      }
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
    expect_same(layers[static_cast<size_t>(m)], one);
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

} // namespace
} // namespace bccsplat::test

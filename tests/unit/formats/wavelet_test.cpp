// SPDX-License-Identifier: Apache-2.0
// Wavelet coefficients of a box: back exactly what the coder foretold, near the numbers as asked, and nothing
// worse than an error from bytes that no coder made.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "base/error.h"
#include "formats/bcc4/encode/choose_tile.h"
#include "formats/bcc4/wavelet/bit_tables.h"
#include "formats/bcc4/wavelet/wavelet_tile.h"

namespace bccsplat {
namespace {

std::vector<float> waves(const TileBox& box, double noise) {
  std::mt19937 random(7);
  std::normal_distribution<double> spread(0, noise);
  std::vector<float> values;
  for (int t = 0; t < box.layers; ++t)
    for (int z = 0; z < box.size[2]; ++z)
      for (int y = 0; y < box.size[1]; ++y)
        for (int x = 0; x < box.size[0]; ++x)
          values.push_back(static_cast<float>(
              1000 + 300 * std::sin(.2 * x + .1 * y - .3 * t) * std::cos(.15 * z) + spread(random)));
  return values;
}

double mean_square(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += (double{a[i]} - b[i]) * (double{a[i]} - b[i]);
  return sum / static_cast<double>(a.size());
}

struct WaveletCase {
  TileBox box;
  double noise, error;
};

std::vector<float> frames_of(const TileCoefficients& coefficients) {
  LayerRoom room;
  return TileLayers(coefficients, room).frames();
}

// Frames that are summed as coefficients are those that are summed as layers.
void expect_one_by_one(const TileCoefficients& coefficients, std::span<const float> frames) {
  const size_t samples = coefficients.shape().samples();
  const auto [low, high] = std::minmax_element(frames.begin(), frames.end());
  for (int t = 0; t < coefficients.basis().frames; ++t) {
    std::vector<float> frame(samples), weights(coefficients.basis().frames);
    weights[t] = 1;
    coefficients.add_to(frame, weights);
    synthesise(coefficients.shape(), frame);
    for (size_t i = 0; i < samples; ++i)
      ASSERT_NEAR(frame[i], frames[t * samples + i], 1e-5 * std::max(1.F, *high - *low));
  }
}

class WaveletTiles : public testing::TestWithParam<WaveletCase> {};

TEST_P(WaveletTiles, TheDecoderHasWhatTheCoderForetold) {
  const auto [box, noise, error] = GetParam();
  const std::vector<float> values = waves(box, noise);
  const std::vector<TileBox> boxes{box, {}};
  const TileRule rule = find_tile_rule(std::span(&box, 1), {values}, error * error);
  std::vector<TileBands> bands(2);
  TileRoom room;
  bands[0] = analyse_tile(box, values, rule.steps.step, rule.halvings_along_z);
  choose_steps(bands[0], rule, room.walk);
  const auto bytes = code_tile(bands, rule.steps, room.walk);
  const auto back = decode_tile(boxes, bytes, 0, room.walk);
  const std::vector<float> frames = frames_of(back[0]);
  EXPECT_EQ(frames, frames_of(coefficients_of(bands[0], rule.steps)));
  EXPECT_TRUE(frames_of(back[1]).empty());
  expect_one_by_one(back[0], frames);
  EXPECT_LT(mean_square(values, frames), 3 * error * error);
  EXPECT_GT(mean_square(values, frames), .5 * error * error);
  // Numbers of that error take at least some entropy, and never nearly what they take as they are.
  EXPECT_LT(bytes.size(), values.size() * 2);
}

INSTANTIATE_TEST_SUITE_P(
    Boxes, WaveletTiles,
    testing::Values(WaveletCase{{{64, 64, 64}, 4}, 3, 6}, WaveletCase{{{33, 17, 5}, 7}, 3, 4},
                    WaveletCase{{{1, 1, 1}, 16}, 9, 9}, WaveletCase{{{2, 3, 4}, 1}, 9, 9},
                    WaveletCase{{{16, 1, 40}, 32}, .5, 2}, WaveletCase{{{20, 20, 20}, 3}, 50, 9}));

// Codes near the top of 16 bits: far from air no error is too small, be the coarse rest ever so large and the
// rows of the basis rounded.
TEST(WaveletTile, SmallErrorsFarFromAirAreKept) {
  TileRoom room;
  for (const int layers : {1, 8, 16})
    for (const double error : {3., .1}) {
      const TileBox box{{32, 32, 32}, layers};
      std::vector<float> values = waves(box, error / 4);
      for (float& v : values) v += 62000;
      const TileRule rule = find_tile_rule(std::span(&box, 1), {values}, error * error);
      std::vector<TileBands> bands(1);
      bands[0] = analyse_tile(box, values, rule.steps.step, rule.halvings_along_z);
      StepRule steps = rule.steps;
      fit_into_steps(bands, steps);
      EXPECT_EQ(steps.step, rule.steps.step);
      choose_steps(bands[0], rule, room.walk);
      const std::vector<float> frames =
          frames_of(decode_tile(std::span(&box, 1), code_tile(bands, steps, room.walk), 0, room.walk)[0]);
      EXPECT_EQ(frames, frames_of(coefficients_of(bands[0], steps)));
      EXPECT_LT(mean_square(values, frames), 3 * error * error) << layers << " layers, " << error;
    }
}

// What no halving less makes fit takes a larger step, which is told.
TEST(WaveletTile, ALargerStepWhereNothingFits) {
  const TileBox box{{16, 16, 16}, 4};
  std::vector<TileBands> bands{analyse_tile(box, std::vector<float>(box.sites(), 60000), .001F, 2), {}};
  StepRule steps{.001F, {}};
  EXPECT_TRUE(fit_into_steps(bands, steps));
  EXPECT_EQ(bands[0].shape.levels(), 0);
  EXPECT_NEAR(steps.step, 120000. / (1 << 21), 1e-6);
  EXPECT_FALSE(fit_into_steps(bands, steps));
}

// Frames that come in turn: their principal components are far fewer than cosines.
TEST(WaveletTile, ABasisOfItsOwnWhereItSavesMore) {
  const TileBox box{{24, 24, 24}, 12};
  std::vector<float> values = waves({{24, 24, 24}, 1}, 80);
  const std::vector<float> other = waves({{24, 24, 24}, 1}, 0);
  std::vector<float> series;
  for (int t = 0; t < box.layers; ++t) {
    const auto& frame = t % 2 == 0 ? values : other;
    series.insert(series.end(), frame.begin(), frame.end());
  }
  const TileBands own = analyse_tile(box, series, 4, 3);
  EXPECT_TRUE(own.own_basis);
  const TileBands noise = analyse_tile(box, waves(box, 9000), 4, 3);
  EXPECT_FALSE(noise.own_basis);
}

TEST(WaveletTile, BytesThatNoCoderMadeAreRefusedOrDecoded) {
  const TileBox box{{20, 18, 17}, 5};
  const std::vector<float> values = waves(box, 3);
  const TileRule rule = find_tile_rule(std::span(&box, 1), {values}, 4);
  std::vector<TileBands> bands(1);
  TileRoom room;
  bands[0] = analyse_tile(box, values, rule.steps.step, rule.halvings_along_z);
  choose_steps(bands[0], rule, room.walk);
  const auto good = code_tile(bands, rule.steps, room.walk);
  std::mt19937 random(3);
  for (int i = 0; i < 60; ++i) {
    auto bytes = good;
    bytes[random() % (i < 30 ? 12 : bytes.size())] ^= static_cast<std::byte>(1U << (random() % 8));
    if (i % 3 == 0) bytes.resize(random() % bytes.size());
    try {
      EXPECT_EQ(frames_of(decode_tile(std::span(&box, 1), bytes, 0, room.walk)[0]).size(), box.sites());
    } catch (const Error& e) {
      EXPECT_TRUE(e.code() == Code::corrupt || e.code() == Code::truncated) << e.message();
    }
  }
  // Whatever was walked through, the room is as it was.
  EXPECT_EQ(frames_of(decode_tile(std::span(&box, 1), good, 0, room.walk)[0]),
            frames_of(coefficients_of(bands[0], rule.steps)));
}

// Few coefficients, far from each other in space, time and level: each is found where nothing is expected.
TEST(WaveletTile, WhatStandsAloneIsFound) {
  const TileBox box{{64, 33, 20}, 16};
  const StepRule steps{2, {}};
  TileRoom room;
  for (const size_t apart : {7919UL, 104729UL, 400009UL}) {
    std::vector<TileBands> bands{analyse_tile(box, std::vector<float>(box.sites()), 2, 2)};
    bands[0].steps.assign(box.sites(), 0);
    for (size_t i = apart / 2; i < box.sites(); i += apart) bands[0].steps[i] = static_cast<int>(i % 5) - 2;
    const auto bytes = code_tile(bands, steps, room.walk);
    EXPECT_EQ(frames_of(decode_tile(std::span(&box, 1), bytes, 0, room.walk)[0]),
              frames_of(coefficients_of(bands[0], steps)));
  }
}

TEST(WaveletTile, TablesOfBitsRiseAndTurnBack) {
  for (int l = -most_logit; l < most_logit; ++l) {
    EXPECT_LE(probability_of(l), probability_of(l + 1));
    EXPECT_EQ(probability_of(l) + probability_of(-l), 65536);
    const double exact = 65536 / (1 + std::exp(-static_cast<double>(l) / logit_unit));
    EXPECT_NEAR(probability_of(l), exact, 50) << l;
  }
  for (int p = 8; p < 65536; p += 16)
    EXPECT_NEAR(probability_of(logit_of(static_cast<uint16_t>(p))), p, 70) << p;
}

// The lines of section 12 of formats/bcc4.md, one after the other: value i of a line is at i * stride.
void put_line_together(float* line, size_t stride, int count) {
  const auto coarse = static_cast<float>(1.149604398), fine = static_cast<float>(1 / 1.149604398);
  std::vector<float> v(count);
  for (int i = 0; i < count; ++i) {
    const int from = i % 2 == 0 ? i / 2 : (count + 1) / 2 + i / 2;
    v[i] = line[from * stride] * (i % 2 == 0 ? fine : coarse);
  }
  const std::array<float, 4> weights{-.4435068522F, -.8829110762F, .05298011854F, 1.586134342F};
  for (int step = 0; step < 4; ++step)
    for (int i = step % 2; i < count; i += 2) {
      const int before = i > 0 ? i - 1 : 1, after = i + 1 < count ? i + 1 : count - 2;
      v[i] += weights[step] * (v[before] + v[after]);
    }
  for (int i = 0; i < count; ++i) line[i * stride] = v[i];
}

void put_together(const Halvings& s, std::vector<float>& frame) {
  const std::array<size_t, 3> stride{1, size_t(s.size[0]), size_t(s.size[0]) * s.size[1]};
  for (int level = s.levels(); level >= 1; --level)
    for (int a = 2; a >= 0; --a) {
      if (!s.halves(a, level) || s.kept(a, level - 1) < 2) continue;
      const int b = (a + 1) % 3, c = (a + 2) % 3;
      for (int i = 0; i < s.kept(b, level - 1); ++i)
        for (int j = 0; j < s.kept(c, level - 1); ++j)
          put_line_together(frame.data() + i * stride[b] + j * stride[c], stride[a], s.kept(a, level - 1));
    }
}

std::vector<float> noise(size_t count) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> spread(-900, 900);
  std::vector<float> values(count);
  for (float& v : values) v = spread(random);
  return values;
}

// To the bit, in boxes that no vector divides; and the way there is the reverse of the way back.
TEST(WaveletTile, VectorsLiftLinesAsThePageHasIt) {
  for (const std::array<int, 3>& size : std::vector<std::array<int, 3>>{
           {64, 64, 19}, {33, 17, 5}, {2, 3, 70}, {95, 1, 8}, {7, 100, 31}, {128, 2, 2}, {1, 1, 1}}) {
    Halvings shape{size, {}};
    for (size_t a = 0; a < 3; ++a) shape.times[a] = most_halvings(size[a]);
    const std::vector<float> values = noise(shape.samples());
    std::vector<float> fast = values, slow = values;
    synthesise(shape, fast), put_together(shape, slow);
    EXPECT_EQ(fast, slow) << size[0] << " x " << size[1] << " x " << size[2];
    analyse(shape, fast);
    for (size_t i = 0; i < fast.size(); ++i) ASSERT_NEAR(fast[i], values[i], .05) << i;
  }
}

// To the bit what the whole gives, at ends and inside, also where an axis is not halved or a part is one
// sample; what lies far from a part is not touched.
TEST(WaveletTile, APartIsMadeAsOfTheWhole) {
  std::mt19937 random(5);
  for (const std::array<int, 3>& size :
       std::vector<std::array<int, 3>>{{64, 64, 64}, {33, 17, 5}, {2, 3, 70}, {95, 1, 8}, {1, 1, 1}}) {
    Halvings shape{size, {}};
    for (size_t a = 0; a < 3; ++a) shape.times[a] = most_halvings(size[a]);
    const std::vector<float> coefficients = noise(shape.samples());
    std::vector<float> whole = coefficients;
    synthesise(shape, whole);
    for (int n = 0; n < 30; ++n) {
      BoxPart part;
      for (size_t a = 0; a < 3; ++a) {
        part.first[a] = std::uniform_int_distribution(0, size[a] - 1)(random);
        part.end[a] =
            n == 0 ? part.first[a] + 1 : std::uniform_int_distribution(part.first[a] + 1, size[a])(random);
      }
      std::vector<float> made = coefficients;
      synthesise(shape, part, made);
      for (int z = part.first[2]; z < part.end[2]; ++z)
        for (int y = part.first[1]; y < part.end[1]; ++y)
          for (int x = part.first[0]; x < part.end[0]; ++x) {
            const size_t at = x + size_t(size[0]) * (y + size_t(size[1]) * z);
            ASSERT_EQ(made[at], whole[at]) << x << ' ' << y << ' ' << z << " of " << size[0];
          }
    }
  }
  Halvings shape{{64, 64, 64}, {4, 4, 4}};
  std::vector<float> made = noise(shape.samples());
  const float last = made.back(), inner = made[50 + 64 * (50 + 64 * 50)];
  synthesise(shape, {{0, 0, 0}, {16, 16, 16}}, made);
  EXPECT_EQ(made.back(), last);
  EXPECT_EQ(made[50 + 64 * (50 + 64 * 50)], inner);
}

template<class Code> void compare_codes() {
  constexpr int layers = 5, nx = 21, ny = 18;
  constexpr float high = sizeof(Code) == 1 ? 250 : 2000;
  const std::vector<float> values = noise(size_t{nx} * ny * brick_edge * layers + beyond_sums);
  std::vector<WeighedLayer> sum;
  for (int k = 0; k < layers; ++k)
    sum.push_back({values.data() + size_t{nx} * ny * brick_edge * k, .3F - .11F * static_cast<float>(k)});
  const RoundedCodes rounded{100, 7, high};
  BrickMask kept{};
  for (size_t r = 0; r < brick_rows; ++r) kept[r] = static_cast<uint16_t>(r % 3 ? r * 40503 : 0xffff);
  const BrickRows rows{nx + 2, nx, size_t{nx} * ny};
  std::vector<Code> codes(brick_sites + beyond_sums), wanted;
  codes.resize(sum_to_codes(sum, rows, rounded, kept, codes.data()) - codes.data());
  for (size_t r = 0; r < brick_rows; ++r)
    for (size_t x = 0; x < brick_edge; ++x) {
      if ((kept[r] >> x & 1) == 0) continue;
      float number = 0;
      for (const WeighedLayer& l : sum)
        number += l.weight * l.first[rows.first + r / brick_edge * rows.plane + r % brick_edge * nx + x];
      wanted.push_back(static_cast<Code>(std::clamp(std::floor(number + 100.F + .5F), 7.F, high)));
    }
  EXPECT_EQ(codes, wanted);
}

TEST(WaveletTile, SumsOfLayersBecomeCodes) {
  compare_codes<uint8_t>();
  compare_codes<uint16_t>();
}

// A rounding of them that depends on the machine would be another format.
TEST(WaveletTile, NoCosineIsNearATie) {
  for (int n = 1; n <= 32; ++n)
    for (int k = 0; k < n; ++k)
      for (int t = 0; t < n; ++t) {
        const double v =
            std::sqrt((k ? 2.0 : 1.0) / n) * std::cos(std::numbers::pi * k * (t + .5) / n) * basis_unit;
        EXPECT_GT(std::fabs(v - std::floor(v) - .5), 1e-9) << n << ", " << k << ", " << t;
      }
}

} // namespace
} // namespace bccsplat

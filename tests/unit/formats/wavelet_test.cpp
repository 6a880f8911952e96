// SPDX-License-Identifier: Apache-2.0
// Wavelet coefficients of a box: back exactly what the coder foretold, near the numbers as asked, and nothing
// worse than an error from bytes that no coder made.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "base/error.h"
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

class WaveletTiles : public testing::TestWithParam<WaveletCase> {};

TEST_P(WaveletTiles, TheDecoderHasWhatTheCoderForetold) {
  const auto [box, noise, error] = GetParam();
  const std::vector<float> values = waves(box, noise);
  const std::vector<TileBox> boxes{box, {}};
  const TileRule rule = find_tile_rule(std::span(&box, 1), std::span(&values, 1), error * error);
  std::vector<TileBands> bands(2);
  bands[0] = analyse_tile(box, values, rule.steps.step, rule.halvings_along_z);
  choose_steps(bands[0], rule);
  const auto bytes = code_tile(bands, rule.steps);
  const auto back = decode_tile(boxes, bytes, 0);
  EXPECT_EQ(back[0], restore_tile(bands[0], rule.steps));
  EXPECT_TRUE(back[1].empty());
  EXPECT_LT(mean_square(values, back[0]), 3 * error * error);
  EXPECT_GT(mean_square(values, back[0]), .5 * error * error);
  // Numbers of that error take at least some entropy, and never nearly what they take as they are.
  EXPECT_LT(bytes.size(), values.size() * 2);
}

INSTANTIATE_TEST_SUITE_P(
    Boxes, WaveletTiles,
    testing::Values(WaveletCase{{{64, 64, 64}, 4}, 3, 6}, WaveletCase{{{33, 17, 5}, 7}, 3, 4},
                    WaveletCase{{{1, 1, 1}, 16}, 9, 9}, WaveletCase{{{2, 3, 4}, 1}, 9, 9},
                    WaveletCase{{{16, 1, 40}, 32}, .5, 2}, WaveletCase{{{20, 20, 20}, 3}, 50, 9}));

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
  const TileRule rule = find_tile_rule(std::span(&box, 1), std::span(&values, 1), 4);
  std::vector<TileBands> bands(1);
  bands[0] = analyse_tile(box, values, rule.steps.step, rule.halvings_along_z);
  choose_steps(bands[0], rule);
  const auto good = code_tile(bands, rule.steps);
  std::mt19937 random(3);
  for (int i = 0; i < 60; ++i) {
    auto bytes = good;
    bytes[random() % (i < 30 ? 12 : bytes.size())] ^= static_cast<std::byte>(1U << (random() % 8));
    if (i % 3 == 0) bytes.resize(random() % bytes.size());
    try {
      EXPECT_EQ(decode_tile(std::span(&box, 1), bytes, 0)[0].size(), box.sites());
    } catch (const Error& e) {
      EXPECT_TRUE(e.code() == Code::corrupt || e.code() == Code::truncated) << e.message();
    }
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

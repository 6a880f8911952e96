// SPDX-License-Identifier: Apache-2.0
// Predictors of codes: decoding is the inverse of prediction for chunks of all shapes and types on all
// instruction sets, fitted weights stay in bounds, and fields that are smooth leave little.
#include "formats/bcc4/coding/predict.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <random>

#include "formats/bcc4/encode/encode_chunk.h"
#include "formats/bcc4/encode/fit_weights.h"
#include "formats/bcc4/page.h"
#include "tests/support/targets.h"
#include "tests/unit/formats/chunk_sites.h"
#include "tests/unit/formats/test_data.h"

namespace bccsplat {
namespace {

struct Way {
  Predictor predictor;
  bool chains = true;
};
constexpr std::array<Way, 7> all = {{{Predictor::none},
                                     {Predictor::west},
                                     {Predictor::lorenzo},
                                     {Predictor::previous},
                                     {Predictor::cross},
                                     {Predictor::fitted},
                                     {Predictor::fitted, false}}};

struct Case {
  LatticeKind kind;
  std::array<uint32_t, 4> dims;
  int32_t slab_layers, slab;
  Int3 brick;
};
// Whole bricks, edges, a brick that coset 1 lacks, one layer, static lattices, slabs that start with coset 1.
const std::vector<Case> cases = {{LatticeKind::d4star, {40, 40, 40, 20}, 8, 1, {0, 0, 0}},
                                 {LatticeKind::d4star, {40, 40, 40, 20}, 8, 3, {1, 1, 1}},
                                 {LatticeKind::d4star, {23, 24, 23, 20}, 8, 0, {1, 0, 1}},
                                 {LatticeKind::d4star, {30, 30, 30, 20}, 3, 1, {0, 1, 0}},
                                 {LatticeKind::d4star, {30, 30, 30, 20}, 1, 3, {0, 0, 0}},
                                 {LatticeKind::d4star, {30, 30, 30, 60}, 32, 1, {1, 0, 0}},
                                 {LatticeKind::bcc, {40, 23, 30, 1}, 8, 0, {0, 0, 0}},
                                 {LatticeKind::bcc, {40, 23, 30, 1}, 8, 0, {1, 0, 0}},
                                 {LatticeKind::cc, {20, 18, 17, 9}, 8, 0, {0, 0, 0}},
                                 {LatticeKind::cc, {20, 18, 17, 9}, 8, 0, {1, 0, 1}},
                                 {LatticeKind::cc, {20, 18, 17, 1}, 8, 0, {0, 1, 0}}};

// The codes that residuals stand for, by way of byte planes and packed codes.
std::vector<uint32_t> unpredicted(const ChunkSites& sites, const ChunkCodes& codes, Predictor predictor,
                                  std::span<const int16_t> weights, std::span<const uint32_t> residuals) {
  const size_t bytes = codes.bytes(), count = residuals.size();
  std::vector<std::byte> planes(2 * unpredict_slack + count * bytes, std::byte{0xa5});
  for (size_t b = 0; b < bytes; ++b)
    for (size_t i = 0; i < count; ++i)
      planes[unpredict_slack + b * count + i] = static_cast<std::byte>(residuals[i] >> (8 * b));
  std::vector<std::byte> packed(count * bytes + unpredict_slack);
  static CellRing<int32_t> ring; // with what the call before left in it
  unpredict(sites.shape, sites.kept, codes, predictor, weights,
            std::span(planes).subspan(unpredict_slack, count * bytes), packed.data(), ring);
  std::vector<uint32_t> out(count);
  for (size_t i = 0; i < count; ++i) std::memcpy(&out[i], packed.data() + i * bytes, bytes);
  return out;
}

TEST(Predict, UnpredictIsTheInverse) {
  std::mt19937 random(5);
  for (const Case& c : cases)
    for (const ValueType type : {ValueType::u8, ValueType::u16, ValueType::f16, ValueType::f32})
      for (const int share : {0, 1, 3, 4}) { // of sites kept, in quarters; 0: an object, whose rows are runs
        VolumeInfo info = test::volume(c.kind, c.dims, {test::channel("a", type)});
        info.slab_layers = c.slab_layers;
        ChunkCodes codes = codes_of(type, 0);
        // That of floats is in the middle, that of integers anywhere.
        codes.air = type == ValueType::f32 && share % 2 == 0 ? 1u << 31
                                                             : static_cast<uint32_t>(random()) & codes.mask();
        const ChunkSites sites = make_sites(
            info, c.slab, c.brick,
            [&](const Vec3& p, double t) {
              const double wave = 0.5 + 0.5 * std::sin(0.3 * p[0] + 0.2 * p[1] - 0.4 * p[2] + t);
              const auto smooth = static_cast<uint32_t>(wave * codes.mask());
              return random() % 8
                         ? smooth
                         : static_cast<uint32_t>(random()) & codes.mask(); // some steps over the whole range
            },
            [&](const Vec3& p, double t) {
              if (share > 0) return static_cast<int>(random() % 4) < share;
              const double x = p[0] - 14 - 0.3 * t, y = p[1] - 13, z = p[2] - 15;
              return x * x + y * y + z * z < 81;
            });
        if (sites.codes.empty()) continue;
        for (const auto& [p, chains] : all) {
          std::vector<int16_t> weights;
          if (p == Predictor::fitted) {
            FittedWeights fitted = fit_weights(sites, codes);
            weights = chains ? std::move(fitted.chained) : std::move(fitted.unchained);
            ASSERT_EQ(weights.size(), fitted_weights(sites.shape));
          }
          const auto residuals = predict(sites, codes, p, weights);
          for (const uint32_t r : residuals) ASSERT_LE(r, codes.mask());
          test::for_targets([&] {
            ASSERT_EQ(unpredicted(sites, codes, p, weights, residuals), sites.codes)
                << "predictor " << static_cast<int>(p);
          });
        }
      }
}

// Codes of floats that hardly change, whose predictions no limit touches; and codes so large that limits do,
// alone or in the midst of others.
TEST(Predict, FloatsNearAndFarFromTheLimits) {
  std::mt19937 random(8);
  const ChunkCodes codes = codes_of(ValueType::f32, 1u << 31);
  for (const uint32_t far : {0u, 1u, 40u, 2u}) { // one in so many sites; 0: none
    const ChunkSites sites = full_sites(ValueType::f32, 1, [&](const Vec3& p, double t) {
      if (far > 0 && random() % far == 0) return random() % 2 ? 0u : UINT32_MAX;
      const auto value = static_cast<float>(1 + 0.5 * std::sin(0.3 * p[0] + 0.2 * p[1] - 0.4 * p[2] + t));
      return std::bit_cast<uint32_t>(value) | 1u << 31;
    });
    for (const Predictor p : {Predictor::west, Predictor::lorenzo, Predictor::previous, Predictor::cross}) {
      const auto residuals = predict(sites, codes, p, {});
      test::for_targets([&] { ASSERT_EQ(unpredicted(sites, codes, p, {}, residuals), sites.codes); });
    }
  }
}

// Layers with a cross layer then need no site of the same row; the price is small where fields are smooth.
TEST(Predict, WithoutChainsRowsDependOnOtherRowsOnly) {
  const ChunkCodes codes = codes_of(ValueType::u16, 0);
  const ChunkSites sites = full_sites(ValueType::u16, 1, [](const Vec3& p, double t) {
    return static_cast<uint32_t>(30000 +
                                 20000 * std::sin(0.3 * p[0] + 0.2 * p[1]) * std::cos(0.4 * p[2] + t));
  });
  const auto [with, weights] = fit_weights(sites, codes);
  ASSERT_EQ(weights.size(), 53u); // classes 0, 1 and 3
  EXPECT_NE(weights[0], 0);
  EXPECT_EQ(weights[10], 0);
  EXPECT_EQ(weights[28], 0);
  EXPECT_NE(with[28], 0);
  const auto bits = [&](std::span<const int16_t> w) {
    double sum = 0;
    for (const uint32_t r : predict(sites, codes, Predictor::fitted, w)) sum += std::bit_width(r);
    return sum;
  };
  EXPECT_LT(bits(weights), 1.05 * bits(with));
}

TEST(Predict, ExtremeWeightsDoNotOverflow) {
  std::mt19937 random(6);
  const ChunkCodes codes = codes_of(ValueType::u16, 0);
  const ChunkSites sites =
      full_sites(ValueType::u16, 0, [&](const Vec3&, double) { return random() % 2 ? 65535u : 0u; });
  std::vector<int16_t> weights(fitted_weights(sites.shape)); // classes 0, 1 and 3: 10, 18 and 25 weights
  ASSERT_EQ(weights.size(), 53u);
  weights[0] = 32767, weights[10 + 3] = -32767, weights[28 + 24] = 32767;
  const auto residuals = predict(sites, codes, Predictor::fitted, weights);
  EXPECT_EQ(unpredicted(sites, codes, Predictor::fitted, weights, residuals), sites.codes);
  weights[1] = -1; // the magnitudes of one class now sum to 32768
  EXPECT_THROW(static_cast<void>(predict(sites, codes, Predictor::fitted, weights)), Error);
}

// Sums of single bytes reach the 24 bits that they are held in: whole chunks of codes far from air, weights
// whose magnitudes sum to the most there is, in layers with chains and without.
TEST(Predict, ExtremeWeightsOfBytesDoNotOverflow) {
  std::mt19937 random(12);
  for (const uint32_t air : {0u, 128u, 255u})
    for (int round = 0; round < 8; ++round) {
      ChunkCodes codes = codes_of(ValueType::u8, 0);
      codes.air = air;
      const ChunkSites sites = full_sites(ValueType::u8, round % 2, [&](const Vec3&, double) {
        return random() % 8 ? 255 - air : static_cast<uint32_t>(random() & 255);
      });
      std::vector<int16_t> weights;
      for (const size_t taps : {10, 18, 25}) { // of classes 0, 1 and 3
        const size_t first = weights.size(), shares = round < 4 ? 4 : taps;
        weights.resize(first + taps);
        for (size_t i = 0; i < shares; ++i) {
          const int share = INT16_MAX / static_cast<int>(shares), sign = random() % 2 || round == 0 ? 1 : -1;
          weights[first + (i == 3 ? 7 : i)] = static_cast<int16_t>(sign * share);
        }
      }
      ASSERT_EQ(weights.size(), fitted_weights(sites.shape));
      const auto residuals = predict(sites, codes, Predictor::fitted, weights);
      test::for_targets([&] {
        ASSERT_EQ(unpredicted(sites, codes, Predictor::fitted, weights, residuals), sites.codes)
            << "air " << air << " round " << round;
      });
    }
}

// Mean bits of the residuals of sites off the faces of a full chunk, from the third layer on.
double inner_bits(const ChunkSites& sites, const std::vector<uint32_t>& residuals) {
  double bits = 0;
  size_t i = 0, count = 0;
  for (int m = 0; m < sites.shape.layers; ++m) {
    const Int3 n = sites.shape.box[m];
    for (int z = 0; z < n[2]; ++z)
      for (int y = 0; y < n[1]; ++y)
        for (int x = 0; x < n[0]; ++x, ++i) {
          const bool inside = x > 0 && y > 0 && z > 0 && x < n[0] - 1 && y < n[1] - 1 && z < n[2] - 1;
          if (!inside || (m < 2 && !sites.shape.still)) continue;
          bits += std::bit_width(residuals[i]);
          ++count;
        }
  }
  return bits / static_cast<double>(count);
}

double mean_square(const std::vector<uint32_t>& folded) {
  double sum = 0;
  for (const uint32_t f : folded) sum += 0.25 * f * f;
  return sum / static_cast<double>(folded.size());
}

TEST(Predict, LinearFieldsAreForeseen) {
  size_t tried = 0;
  for (const Case& c : cases) {
    VolumeInfo info = test::volume(c.kind, c.dims, {test::channel("a", ValueType::u16)});
    info.slab_layers = c.slab_layers;
    const ChunkCodes codes = codes_of(ValueType::u16, 0);
    const ChunkSites sites = make_sites(
        info, c.slab, c.brick,
        [](const Vec3& p, double t) {
          return static_cast<uint32_t>(20000 + 150 * p[0] - 90 * p[1] + 60 * p[2] + 40 * t + 0.5);
        },
        [](const Vec3&, double) { return true; });
    if (sites.codes.size() < 8192) continue;
    ++tried;
    // Lorenzo's cube is exact on linear fields, off the faces; codes are rounded.
    EXPECT_LT(inner_bits(sites, predict(sites, codes, Predictor::lorenzo, {})), 3);
    EXPECT_GT(inner_bits(sites, predict(sites, codes, Predictor::west, {})), 7); // the step along x
    // Least squares has the faces to care for as well: over all sites no fixed predictor has a smaller mean
    // square.
    const double fitted =
        mean_square(predict(sites, codes, Predictor::fitted, fit_weights(sites, codes).chained));
    for (const Predictor p : {Predictor::west, Predictor::lorenzo, Predictor::previous, Predictor::cross})
      EXPECT_LT(fitted, mean_square(predict(sites, codes, p, {}))) << "kind " << static_cast<int>(c.kind);
  }
  EXPECT_GE(tried, 4u);
}

// What goes on along each row by itself, beside what all rows share: the site at x - 1 is worth waiting for.
TEST(Predict, ChunksHaveChainsWhereTheySave) {
  const ChunkCodes codes = codes_of(ValueType::u8, 0);
  const ChunkSites sites = full_sites(ValueType::u8, 1, [](const Vec3& p, double t) {
    const double row = 2.4 * p[1] + 13.7 * p[2] * p[1] + 31.3 * t * p[2];
    return static_cast<uint32_t>(128 + 40 * std::sin(0.3 * p[0] + row) +
                                 60 * std::sin(0.7 * p[0] + 0.5 * p[1] + 0.6 * p[2] + t));
  });
  const FittedWeights fitted = fit_weights(sites, codes);
  EXPECT_GT(mean_square(predict(sites, codes, Predictor::fitted, fitted.unchained)),
            2 * mean_square(predict(sites, codes, Predictor::fitted, fitted.chained)));
  EXPECT_LE(100 * encode_chunk(sites, codes, 6).bytes.size(),
            101 * encode_chunk(sites, codes, 9).bytes.size());
}

TEST(Predict, AConstantLeavesOnlyItsFirstSite) {
  const ChunkCodes codes = codes_of(ValueType::u8, 100);
  const ChunkSites air = full_sites(ValueType::u8, 1, [](const Vec3&, double) { return 100u; });
  for (const Predictor p : {Predictor::west, Predictor::lorenzo, Predictor::previous, Predictor::cross})
    for (const uint32_t r : predict(air, codes, p, {})) ASSERT_EQ(r, 0u);
  const ChunkSites seven = full_sites(ValueType::u8, 1, [](const Vec3&, double) { return 107u; });
  for (const Predictor p : {Predictor::west, Predictor::previous, Predictor::cross}) {
    const auto r = predict(seven, codes, p, {});
    EXPECT_EQ(r[0], 14u); // +7, folded
    EXPECT_EQ(static_cast<size_t>(std::count(r.begin(), r.end(), 0u)), r.size() - 1);
  }
}

} // namespace
} // namespace bccsplat

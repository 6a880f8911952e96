// SPDX-License-Identifier: Apache-2.0
// What is chosen for a chunk, and the weights that are fitted to it, are those of slow forms that try and sum
// up everything, on all instruction sets.
#include "formats/bcc4/encode/choose_predictor.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <memory>
#include <random>

#include "formats/bcc4/coding/entropy.h"
#include "formats/bcc4/encode/constant_bits.h"
#include "formats/bcc4/encode/fit_weights.h"
#include "formats/bcc4/encode/normal_equations.h"
#include "tests/support/targets.h"
#include "tests/unit/formats/chunk_sites.h"

namespace bccsplat {
namespace {

uint64_t bits_of(std::span<const uint32_t> residuals, const ChunkCodes& codes) {
  uint64_t bits = 0;
  for (uint32_t b = 0; b < codes.bytes(); ++b) {
    std::array<uint32_t, 256> count{};
    for (const uint32_t r : residuals) ++count[r >> (8 * b) & 255];
    bits += entropy_bits_256(count);
  }
  return bits;
}

// Tries one predictor after the other.
Choice chosen_slowly(const ChunkSites& sites, const ChunkCodes& codes, int level) {
  Choice best{Predictor::none, {}, sites.codes};
  uint64_t lowest = bits_of(sites.codes, codes);
  const auto attempt = [&](Predictor p, const std::vector<int16_t>& weights, uint64_t handicap) {
    std::vector<uint32_t> residuals = predict(sites, codes, p, weights);
    const uint64_t bits = bits_of(residuals, codes) + weights.size() * 16 * 256;
    if (bits + handicap < lowest) lowest = bits, best = {p, weights, std::move(residuals)};
  };
  for (const Predictor p : {Predictor::west, Predictor::lorenzo, Predictor::previous, Predictor::cross})
    attempt(p, {}, 0);
  const FittedWeights fitted = fit_weights(sites, codes);
  if (level < 9) attempt(Predictor::fitted, fitted.unchained, 0);
  attempt(Predictor::fitted, fitted.chained, level < 9 ? lowest / 32 : 0);
  return best;
}

// Chunks of which each predictor is the best one for some.
enum class Field { waves, steps, still, noise, ramp, constant, rough };
uint32_t value_of(Field field, const Vec3& p, double t, uint32_t most, std::mt19937& random) {
  const double scale = most;
  switch (field) {
  case Field::waves:
    return static_cast<uint32_t>(scale * (0.5 + 0.4 * std::sin(0.3 * p[0] + 0.2 * p[1] - 0.4 * p[2] + t)));
  case Field::steps: // along y and z
    return static_cast<uint32_t>(scale *
                                 std::fabs(std::sin(91 * std::floor(p[1]) + 37 * std::floor(p[2]) + t)));
  case Field::still:
    return static_cast<uint32_t>(scale * std::fabs(std::sin(31 * p[0] + 57 * p[1] + 91 * p[2])));
  case Field::noise:
    return static_cast<uint32_t>(random()) & most;
  case Field::ramp:
    return static_cast<uint32_t>(3 * p[0] + 2 * p[1] + p[2] + 5 * t) & most;
  case Field::constant:
    return most / 3;
  case Field::rough:
    return static_cast<uint32_t>(random() % 5 ? most / 2 + random() % 3 : random() & most);
  }
  return 0;
}

TEST(ChoosePredictor, IsThatOfTryingAll) {
  std::mt19937 random(4);
  std::array<int, predictor_count> found{};
  for (const ValueType type : {ValueType::u8, ValueType::u16, ValueType::f32})
    for (const Field field :
         {Field::waves, Field::steps, Field::still, Field::noise, Field::ramp, Field::constant, Field::rough})
      for (const int share : {1, 3, 4}) { // of sites kept, in quarters
        ChunkCodes codes = codes_of(type, 0);
        codes.air = static_cast<uint32_t>(random()) & codes.mask();
        const VolumeInfo info =
            test::volume(LatticeKind::d4star, {40, 40, 40, 20}, {test::channel("a", type)});
        const ChunkSites sites = make_sites(
            info, 1, {0, 0, share == 3},
            [&](const Vec3& p, double t) { return value_of(field, p, t, codes.mask(), random); },
            [&](const Vec3&, double) { return static_cast<int>(random() % 4) < share; });
        for (const int level : {6, 9}) {
          const Choice expected = chosen_slowly(sites, codes, level);
          ++found[static_cast<size_t>(expected.predictor)];
          test::for_targets([&] {
            const Choice choice = choose_predictor(sites, codes, level);
            ASSERT_EQ(choice.predictor, expected.predictor) << static_cast<int>(field) << " " << share;
            ASSERT_EQ(choice.weights, expected.weights);
            ASSERT_EQ(choice.residuals, expected.residuals);
          });
        }
      }
  for (const int count : found) EXPECT_GT(count, 0);
}

TEST(ConstantBits, AreThoseOfAllSitesOrSureToBeMore) {
  std::mt19937 random(3);
  for (const ValueType type : {ValueType::u8, ValueType::u16}) {
    const ChunkCodes codes = codes_of(type, 9);
    for (const Field field : {Field::waves, Field::noise, Field::rough}) {
      const ChunkSites sites = full_sites(
          type, 1, [&](const Vec3& p, double t) { return value_of(field, p, t, codes.mask(), random); });
      std::array<uint64_t, constant_predictors> all{};
      for (size_t p = 0; p < all.size(); ++p)
        all[p] = bits_of(predict(sites, codes, static_cast<Predictor>(p), {}), codes);
      int left_out = 0;
      for (const uint64_t limit : {uint64_t{0}, all[1] / 4, all[1] / 2, all[1], UINT64_MAX / 2})
        test::for_targets([&] {
          const auto bits = constant_bits(sites, codes, limit);
          for (size_t p = 0; p < all.size(); ++p) {
            if (bits[p] == UINT64_MAX) {
              EXPECT_GT(all[p], limit);
              ++left_out;
            } else {
              EXPECT_EQ(bits[p], all[p]);
            }
          }
        });
      EXPECT_GT(left_out, 0);
    }
  }
}

// Sums up doubles, one chosen site after the other.
template<class D> FittedWeights fitted_slowly(const ChunkSites& sites, const ChunkCodes& codes) {
  const auto every = std::max<uint32_t>(1, static_cast<uint32_t>(sites.codes.size()) / 6144);
  std::array<std::unique_ptr<NormalEquations>, classes> sums;
  for (auto& s : sums) s = std::make_unique<NormalEquations>();
  const uint32_t* code = sites.codes.data();
  uint32_t index = 0;
  CellRing<D> ring;
  walk_rows<D>(sites.shape, sites.kept, ring, [&](const Row<D>& row) {
    std::array<const D*, max_taps> taps;
    const size_t n = gather_taps(row, taps);
    NormalEquations& e = *sums[(row.cross ? 1 : 0) | (row.previous ? 2 : 0)];
    for (unsigned bits = sites.kept[row.layer][row.index]; bits; bits &= bits - 1, ++code, ++index) {
      const int x = std::countr_zero(bits);
      row.own[x] = static_cast<D>(*code) - static_cast<D>(codes.air);
      if ((index * 2654435761u >> 16) % every != 0) continue;
      std::array<double, max_taps + 1> v{};
      for (size_t i = 0; i < n; ++i) v[i] = static_cast<double>(taps[i][x]);
      v[n] = static_cast<double>(row.own[x]);
      for (size_t i = 0; i <= n; ++i)
        for (size_t j = 0; j <= i; ++j) e.sum[i][j] += v[i] * v[j];
    }
  });
  FittedWeights fitted;
  for (int c = 0; c < classes; ++c) {
    if (!(classes_present(sites.shape) >> c & 1)) continue;
    const size_t n = class_taps(c);
    LeastSquares e;
    for (size_t i = 0; i < n; ++i) {
      std::copy_n(sums[c]->sum[i].begin(), i + 1, e.a[i].begin());
      e.b[i] = sums[c]->sum[n][i];
    }
    const auto append = [&](std::vector<int16_t>& to) {
      const Weights w = solve(e, n);
      to.insert(to.end(), w.begin(), w.begin() + n);
    };
    append(fitted.chained);
    for (size_t i = 0; i < n && c & 1; ++i) e.a[0][i] = e.a[i][0] = 0;
    if (c & 1) e.b[0] = 0;
    append(fitted.unchained);
  }
  return fitted;
}

TEST(FitWeights, AreThoseOfPlainSums) {
  std::mt19937 random(12);
  for (const ValueType type : {ValueType::u8, ValueType::u16, ValueType::f32})
    for (const Field field : {Field::waves, Field::noise, Field::rough})
      for (const int share : {2, 4}) {
        ChunkCodes codes = codes_of(type, 0);
        codes.air = share == 4 ? codes.mask() : 3;
        const VolumeInfo info =
            test::volume(LatticeKind::d4star, {40, 40, 40, 20}, {test::channel("a", type)});
        const ChunkSites sites = make_sites(
            info, 1, {0, 0, 0},
            [&](const Vec3& p, double t) { return value_of(field, p, t, codes.mask(), random); },
            [&](const Vec3&, double) { return static_cast<int>(random() % 4) < share; });
        const FittedWeights expected = fitted_slowly<int64_t>(sites, codes);
        test::for_targets([&] {
          const FittedWeights fitted = fit_weights(sites, codes);
          ASSERT_EQ(fitted.chained, expected.chained);
          ASSERT_EQ(fitted.unchained, expected.unchained);
        });
      }
}

} // namespace
} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
#include "formats/bcc4/coding/normal_equations.h"

#include <gtest/gtest.h>

#include <bit>
#include <memory>
#include <random>
#include <vector>

#include "tests/support/targets.h"

namespace bccsplat {
namespace {

// In any number of batches and on every target the bits of the plain sums, one sample after the other.
TEST(NormalEquations, PlainSumsInOrder) {
  constexpr size_t columns = NormalEquations::columns;
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  for (const size_t n : {size_t{own_taps}, size_t{own_taps + cross_taps}, size_t{max_taps}}) {
    std::vector<double> samples(100 * columns);
    for (size_t s = 0; s < 100; ++s)
      for (size_t i = 0; i <= n; ++i) samples[s * columns + i] = normal(random);
    const auto expected = std::make_unique<NormalEquations>();
    for (size_t s = 0; s < 100; ++s)
      for (size_t i = 0; i <= n; ++i)
        for (size_t j = 0; j <= i; ++j)
          expected->sum[i][j] += samples[s * columns + i] * samples[s * columns + j];
    test::for_targets([&] {
      const auto equations = std::make_unique<NormalEquations>();
      for (const auto& [first, count] : {std::pair<size_t, size_t>{0, 64}, {64, 1}, {65, 0}, {65, 35}})
        add_samples(*equations, std::span<const double>(samples).subspan(first * columns, count * columns),
                    n);
      for (size_t i = 0; i <= n; ++i)
        for (size_t j = 0; j <= i; ++j)
          ASSERT_EQ(std::bit_cast<uint64_t>(equations->sum[i][j]),
                    std::bit_cast<uint64_t>(expected->sum[i][j]))
              << i << " " << j;
    });
  }
}

// Whole numbers of a byte give the same sums in single precision, however many there are.
TEST(NormalEquations, SmallNumbersAreSummedExactly) {
  constexpr size_t columns = NormalEquations::columns;
  std::mt19937 random(7);
  for (const bool extreme : {false, true}) {
    std::vector<double> samples(200 * columns);
    for (size_t s = 0; s < 200; ++s)
      for (size_t i = 0; i <= max_taps; ++i)
        samples[s * columns + i] =
            extreme ? (random() % 8 ? 255 : -255) : static_cast<int>(random() % 511) - 255;
    const std::vector<float> small(samples.begin(), samples.end());
    const auto expected = std::make_unique<NormalEquations>();
    add_samples(*expected, std::span<const double>(samples), max_taps);
    test::for_targets([&] {
      const auto equations = std::make_unique<NormalEquations>();
      for (const auto& [first, count] : {std::pair<size_t, size_t>{0, 65}, {65, 0}, {65, 135}})
        add_samples(*equations, std::span<const float>(small).subspan(first * columns, count * columns),
                    max_taps);
      for (size_t i = 0; i <= max_taps; ++i)
        for (size_t j = 0; j <= i; ++j) ASSERT_EQ(equations->sum[i][j], expected->sum[i][j]) << i << " " << j;
    });
  }
}

// A reader refuses weights that could overflow its sums; however large the solution, what is written is read.
TEST(NormalEquations, LargeWeightsAreScaledToWhatAReaderTakes) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(-1, 1), exponent(-2, 6);
  for (int round = 0; round < 20000; ++round) {
    const size_t n = 10 + random() % (max_taps - 9);
    const double largest = std::pow(10, exponent(random));
    LeastSquares e;
    double sum = 0;
    for (size_t i = 0; i < n; ++i) {
      const double weight = largest * unit(random);
      e.a[i][i] = 1e9;
      e.b[i] = weight * 1e9;
      sum += std::fabs(weight);
    }
    const Weights w = solve(e, n);
    int total = 0;
    for (size_t i = 0; i < n; ++i) total += std::abs(int{w[i]});
    ASSERT_LE(total, INT16_MAX) << n << " taps, magnitudes of " << sum;
    if (sum * 4096 > 2 * INT16_MAX) {
      ASSERT_GE(total, INT16_MAX - 2 * static_cast<int>(n));
    }
  }
}

} // namespace
} // namespace bccsplat

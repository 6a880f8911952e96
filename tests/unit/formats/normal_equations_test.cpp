// SPDX-License-Identifier: Apache-2.0
#include "formats/bcc4/encode/normal_equations.h"

#include <gtest/gtest.h>

#include <bit>
#include <memory>
#include <random>
#include <vector>

#include "formats/bcc4/encode/tap_rows.h"
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

// Rows of cells, of which some sites are chosen, give the sums of these sites, exactly, however many there
// are.
TEST(NormalEquations, RowsOfWholeNumbersAreSummedExactly) {
  constexpr size_t columns = NormalEquations::columns;
  std::mt19937 random(7);
  for (const int largest : {255, 65535})
    for (const size_t n : {size_t{own_taps}, size_t{own_taps + cross_taps}, size_t{max_taps}})
      for (const bool extreme : {false, true}) {
        constexpr size_t rows = 90; // of 16 sites
        std::vector<float> cells((n + 1) * rows * brick_edge);
        for (float& v : cells)
          v = static_cast<float>(extreme ? (random() % 8 ? largest : -largest)
                                         : static_cast<int>(random() % (2u * largest + 1)) - largest);
        std::vector<unsigned> chosen(rows);
        for (size_t r = 0; r < rows; ++r) chosen[r] = r < 60 && extreme ? full_row : random() & full_row;
        chosen[3] = 1, chosen[4] = 0x8000, chosen[5] = 0;
        const auto at = [&](size_t tap, size_t r) { return &cells[(tap * rows + r) * brick_edge]; };
        std::vector<double> samples;
        for (size_t r = 0; r < rows; ++r)
          for (size_t x = 0; x < brick_edge; ++x) {
            if (!(chosen[r] >> x & 1)) continue;
            samples.resize(samples.size() + columns);
            for (size_t i = 0; i <= n; ++i) samples[samples.size() - columns + i] = at(i, r)[x];
          }
        const auto expected = std::make_unique<NormalEquations>();
        add_samples(*expected, std::span<const double>(samples), n);
        test::for_targets([&] {
          TapRows sums(n, largest == 255);
          for (size_t r = 0; r < rows; ++r) {
            std::array<const float*, max_taps> taps{};
            for (size_t i = 0; i < n; ++i) taps[i] = at(i, r);
            sums.add(taps, at(n, r), chosen[r]);
          }
          EXPECT_EQ(sums.count(), samples.size() / columns);
          const NormalEquations& got = sums.sums();
          for (size_t i = 0; i <= n; ++i)
            for (size_t j = 0; j <= i; ++j) ASSERT_EQ(got.sum[i][j], expected->sum[i][j]) << i << " " << j;
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

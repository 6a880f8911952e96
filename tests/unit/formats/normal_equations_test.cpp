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
        add_samples(*equations, std::span(samples).subspan(first * columns, count * columns), n);
      for (size_t i = 0; i <= n; ++i)
        for (size_t j = 0; j <= i; ++j)
          ASSERT_EQ(std::bit_cast<uint64_t>(equations->sum[i][j]),
                    std::bit_cast<uint64_t>(expected->sum[i][j]))
              << i << " " << j;
    });
  }
}

} // namespace
} // namespace bccsplat

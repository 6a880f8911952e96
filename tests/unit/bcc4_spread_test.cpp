#include "formats/bcc4_spread.h"

#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <random>
#include <vector>

namespace bccsplat {
namespace {

TEST(Bcc4Spread, EveryValueToItsPlaceAndZeroElsewhere) {
  std::mt19937 random(3);
  for (int round = 0; round < 20; ++round) {
    BrickMask kept{};
    for (uint16_t& row : kept) {
      const auto bits = static_cast<unsigned>(random());
      const unsigned first = bits % 16, length = 1 + bits / 16 % (16 - first);
      const std::array<unsigned, 4> kinds = {0, 0xffff, ((1u << length) - 1) << first, bits & 0xffff};
      row = static_cast<uint16_t>(kinds[random() % 4]);
    }
    Brick expected{};
    // What lies beside the values must not show, whatever it is.
    std::vector<float> values(brick_edge, std::numeric_limits<float>::quiet_NaN());
    for (size_t i = 0; i < brick_sites; ++i)
      if (kept[i / brick_edge] >> (i % brick_edge) & 1) {
        expected.value[i] = static_cast<float>(i) - 700.5f;
        values.push_back(expected.value[i]);
      }
    values.insert(values.end(), brick_edge, std::numeric_limits<float>::quiet_NaN());
    const auto brick = std::make_unique<Brick>();
    brick->value.fill(-1);
    spread_values(kept, values.data() + brick_edge, brick->value);
    EXPECT_EQ(brick->value, expected.value);
  }
}

} // namespace
} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
#include "formats/bcc4/coding/spread.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <memory>
#include <random>
#include <vector>

#include "tests/support/targets.h"
#include "tests/unit/formats/test_data.h"

namespace bccsplat {
namespace {

// Integers with scales and offsets that must be rounded alike, halves, floats.
std::vector<ChannelInfo> spread_channels() {
  ChannelInfo bytes = test::channel("u8", ValueType::u8), words = test::channel("u16", ValueType::u16);
  bytes.scale = 1.0 / 3, bytes.offset = -7.7;
  words.scale = 0.1, words.offset = -3276.8, words.air = 0;
  return {bytes, words, test::channel("f16", ValueType::f16, 3), test::channel("f32", ValueType::f32, 1.5f)};
}

// Rows that are empty, full, one run or anything, at the ends of the codes or between them.
TEST(Bcc4Spread, EveryValueToItsPlaceAndZeroElsewhere) {
  std::mt19937 random(3);
  for (const ChannelInfo& channel : spread_channels())
    for (int round = 0; round < 20; ++round) {
      const SampleCoder coder(channel, round < 15 ? channel.air : 1000.1f);
      const size_t bytes = coder.codes().bytes(), first = round % 3 * 11, behind = round % 2 * 40;
      BrickMask kept{};
      for (uint16_t& row : kept) {
        const auto bits = static_cast<unsigned>(random());
        const unsigned start = bits % 16, length = 1 + bits / 16 % (16 - start);
        const std::array<unsigned, 4> kinds = {0, 0xffff, ((1u << length) - 1) << start, bits & 0xffff};
        row = static_cast<uint16_t>(kinds[random() % 4]);
      }
      std::vector<uint32_t> codes(first);
      Brick expected{};
      for (size_t i = 0; i < brick_sites; ++i)
        if (kept[i / brick_edge] >> (i % brick_edge) & 1) {
          const uint32_t range = coder.highest() - coder.lowest();
          codes.push_back(coder.lowest() + static_cast<uint32_t>(random()) % range);
          expected.value[i] = coder.decode(codes.back());
        }
      codes.resize(codes.size() + behind);
      std::vector<std::byte> packed(codes.size() * bytes);
      for (size_t i = 0; i < codes.size(); ++i) std::memcpy(packed.data() + i * bytes, &codes[i], bytes);
      test::for_targets([&] {
        const auto brick = std::make_unique<Brick>();
        brick->value.fill(-1);
        spread_codes(coder, kept, packed, first, brick->value);
        for (size_t i = 0; i < brick_sites; ++i)
          ASSERT_EQ(std::bit_cast<uint32_t>(brick->value[i]), std::bit_cast<uint32_t>(expected.value[i]))
              << channel.name << " site " << i;
      });
    }
}

} // namespace
} // namespace bccsplat

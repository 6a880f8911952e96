// SPDX-License-Identifier: Apache-2.0
#include "formats/bcc4/coding/range.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "tests/support/targets.h"

namespace bccsplat {
namespace {

template<class Stored> void expect_range(size_t count, std::mt19937& random) {
  std::vector<Stored> codes(count);
  for (Stored& c : codes) c = static_cast<Stored>(random());
  const auto packed = std::as_bytes(std::span(codes));
  const auto [low, high] = packed_range(packed, sizeof(Stored));
  EXPECT_EQ(low, *std::min_element(codes.begin(), codes.end())) << count;
  EXPECT_EQ(high, *std::max_element(codes.begin(), codes.end())) << count;
}

TEST(Bcc4Range, SmallestAndLargestOfAnyNumber) {
  std::mt19937 random(4);
  test::for_targets([&] {
    for (const size_t count : {1, 2, 15, 16, 17, 31, 63, 64, 65, 1000, 4096}) {
      expect_range<uint8_t>(count, random);
      expect_range<uint16_t>(count, random);
      expect_range<uint32_t>(count, random);
    }
  });
}

} // namespace
} // namespace bccsplat

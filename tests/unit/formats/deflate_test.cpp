// SPDX-License-Identifier: Apache-2.0
#include "formats/bcc4/coding/deflate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace bccsplat {
namespace {

// Low bytes without any order, middle bytes of a narrow distribution, high bytes mostly 0.
struct Planes {
  std::vector<std::byte> bytes;
  std::vector<size_t> ends;
};
Planes planes(size_t count) {
  std::mt19937 random(4);
  std::geometric_distribution<int> narrow(0.3);
  Planes p;
  for (int plane = 0; plane < 3; ++plane) {
    for (size_t i = 0; i < count; ++i)
      p.bytes.push_back(static_cast<std::byte>(plane == 0   ? random() & 255
                                               : plane == 1 ? static_cast<unsigned>(narrow(random)) & 255
                                               : i % 97     ? 0
                                                            : 1));
    p.ends.push_back(p.bytes.size());
  }
  return p;
}

TEST(Bcc4Deflate, PartsAreOneStream) {
  for (const size_t count : {1, 2, 100, 5000, 70000})
    for (const int level : {1, 6, 9}) {
      const Planes p = planes(count);
      const auto stream = deflate_parts(p.bytes, p.ends, level);
      std::vector<std::byte> back(p.bytes.size());
      ASSERT_TRUE(inflate_bytes(stream, back)) << count << " level " << level;
      EXPECT_EQ(back, p.bytes);
    }
}

// Blocks that follow the parts need little more than what the parts hold.
TEST(Bcc4Deflate, PartsTakeTheirEntropy) {
  const size_t count = 20000;
  const Planes p = planes(count);
  const double middle = -(std::log2(0.3) + 0.7 / 0.3 * std::log2(0.7)); // bits, of the geometric distribution
  const double entropy = static_cast<double>(count) * (8 + middle + 1.0 / 97 * (std::log2(97) + 1.44)) / 8;
  const double size = static_cast<double>(deflate_parts(p.bytes, p.ends, 6).size());
  EXPECT_LT(size, 1.02 * entropy + 200);
  EXPECT_LT(size, 0.98 * static_cast<double>(deflate_bytes(p.bytes, 6, DeflateKind::noise).size()));
}

// Bytes in which repeats, runs and frequencies each matter somewhere, of many pieces.
std::vector<std::byte> mixed(size_t count) {
  std::mt19937 random(7);
  std::vector<std::byte> bytes;
  while (bytes.size() < count) {
    const size_t length = 1 + random() % 300;
    const auto byte = static_cast<std::byte>(random() % 40);
    const size_t back = bytes.size() > 20000 ? 1 + random() % 20000 : 0;
    const bool repeat = back > 0 && random() % 2;
    for (size_t i = 0; i < length; ++i) bytes.push_back(repeat ? bytes[bytes.size() - back] : byte);
  }
  return bytes;
}

// A stream that may be cancelled is the one that may not.
TEST(Bcc4Deflate, PiecesAreTheSameStream) {
  const std::vector<std::byte> bytes = mixed(1 << 20), noise = planes(200000).bytes;
  for (const auto* of : {&bytes, &noise})
    for (const int level : {1, 6, 9})
      for (const DeflateKind kind : {DeflateKind::text, DeflateKind::noise}) {
        Progress progress;
        EXPECT_TRUE(deflate_bytes(*of, level, kind, &progress) == deflate_bytes(*of, level, kind)) << level;
      }
}

// A piece of the slowest strategy takes a millisecond or two.
TEST(Bcc4Deflate, CancelEndsItWithinAPiece) {
  constexpr size_t most_unchecked = 1 << 13; // bytes
  const std::vector<std::byte> bytes = mixed(most_unchecked);
  for (const DeflateKind kind : {DeflateKind::text, DeflateKind::noise}) {
    CancelToken token;
    Progress progress;
    progress.watch(&token);
    token.cancel();
    try {
      static_cast<void>(deflate_bytes(bytes, 9, kind, &progress));
      ADD_FAILURE() << "went on";
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), Code::cancelled);
    }
  }
}

} // namespace
} // namespace bccsplat

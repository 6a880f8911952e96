// SPDX-License-Identifier: Apache-2.0
#include "formats/bcc4/coding/entropy.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "formats/bcc4/coding/deflate.h"

namespace bccsplat {
namespace {

TEST(Bcc4Entropy, PowersOfTwoAreExact) {
  for (const uint64_t e : {0, 1, 7, 20, 40}) EXPECT_EQ(log2_256(uint64_t{1} << e), 256 * e);
  // Between them a straight line: at most 0.09 below.
  for (uint64_t n = 1; n < 5000; n += 7) {
    EXPECT_LE(static_cast<double>(log2_256(n)), 256 * std::log2(static_cast<double>(n)) + 1e-9);
    EXPECT_GE(static_cast<double>(log2_256(n)), 256 * (std::log2(static_cast<double>(n)) - 0.09));
  }
}

TEST(Bcc4Entropy, OfKnownCodes) {
  const std::vector<uint32_t> even(16, 100), lengths{8, 4, 2, 1, 1}, one{50}, none(7);
  EXPECT_EQ(entropy_bits_256(even), 256u * 4 * 1600);
  EXPECT_EQ(huffman_bits_256(even), 256u * 4 * 1600);
  // 1, 2, 3, 4 and 4 bits.
  EXPECT_EQ(huffman_bits_256(lengths), 256u * (8 + 4 * 2 + 2 * 3 + 4 + 4));
  EXPECT_EQ(entropy_bits_256(one), 0u);
  EXPECT_EQ(huffman_bits_256(one), 256u * 50); // a bit each all the same
  EXPECT_EQ(huffman_bits_256(none), 0u);
  EXPECT_EQ(entropy_bits_256({}), 0u);
}

size_t deflated_size(const std::vector<std::byte>& bytes, int strategy) {
  z_stream stream{};
  EXPECT_EQ(deflateInit2(&stream, 6, Z_DEFLATED, -15, 8, strategy), Z_OK);
  std::vector<Bytef> out(deflateBound(&stream, static_cast<uLong>(bytes.size())));
  std::vector<std::byte> in = bytes;
  stream.next_in = reinterpret_cast<Bytef*>(in.data()), stream.avail_in = static_cast<uInt>(in.size());
  stream.next_out = out.data(), stream.avail_out = static_cast<uInt>(out.size());
  EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  const size_t size = stream.total_out;
  deflateEnd(&stream);
  return size;
}

// Two-sided geometric residuals of several widths, with and without runs of zeros.
TEST(Bcc4Entropy, PredictsDeflate) {
  std::mt19937 random(9);
  for (const double width : {0.02, 0.3, 2.0, 20.0, 1000.0})
    for (const uint32_t run : {0u, 5u, 60u, 2000u}) {
      std::vector<std::byte> bytes;
      std::geometric_distribution<int> magnitude(1 / (1 + width));
      while (bytes.size() < 16000) {
        bytes.push_back(static_cast<std::byte>(magnitude(random)));
        if (run > 0 && random() % 40 == 0) bytes.insert(bytes.end(), 1 + random() % run, std::byte{0});
      }
      const DeflateBits bits = deflate_bits(bytes);
      const auto alone = static_cast<double>(deflated_size(bytes, Z_HUFFMAN_ONLY));
      const auto with_runs = static_cast<double>(deflated_size(bytes, Z_RLE));
      const std::string what = "width " + std::to_string(width) + " run " + std::to_string(run);
      EXPECT_NEAR(static_cast<double>(bits.alone_256) / 2048, alone, 0.04 * alone + 100) << what;
      EXPECT_NEAR(static_cast<double>(bits.with_runs_256) / 2048, with_runs, 0.04 * with_runs + 100) << what;
      // What is chosen by it is no more than a little larger than the best.
      const auto chosen = static_cast<double>(deflate_bytes(bytes, 6, DeflateKind::noise).size());
      EXPECT_LE(chosen, 1.01 * std::min(alone, with_runs)) << what;
    }
}

// The same, byte after byte.
DeflateBits bits_slowly(std::span<const std::byte> bytes) {
  std::array<uint32_t, 256> alone{};
  std::array<uint32_t, 256 + 29> with_runs{};
  uint64_t extra = 0;
  for (size_t i = 0; i < bytes.size();) {
    size_t end = i;
    for (; end < bytes.size() && bytes[end] == bytes[i];) ++end;
    const auto symbol = static_cast<size_t>(bytes[i]);
    alone[symbol] += static_cast<uint32_t>(end - i);
    ++with_runs[symbol];
    size_t again = end - i - 1;
    for (; again >= 3; again -= std::min<size_t>(again, 258)) {
      // The first length of each symbol from that of 3 on, and the bits behind it (RFC 1951, 3.2.5).
      constexpr std::array<size_t, 29> first = {3,  4,  5,  6,   7,   8,   9,   10,  11, 13,
                                                15, 17, 19, 23,  27,  31,  35,  43,  51, 59,
                                                67, 83, 99, 115, 131, 163, 195, 227, 258};
      const size_t length = std::min<size_t>(again, 258);
      const auto k =
          static_cast<size_t>(std::upper_bound(first.begin(), first.end(), length) - first.begin()) - 1;
      ++with_runs[256 + k];
      extra += 1 + (k < 4 || k == 28 ? 0 : k / 4 - 1);
    }
    with_runs[symbol] += static_cast<uint32_t>(again);
    i = end;
  }
  return {huffman_bits_256(alone), huffman_bits_256(with_runs) + 256 * extra};
}

TEST(Bcc4Entropy, RunsAreFoundWhereverTheyAre) {
  std::mt19937 random(4);
  for (int round = 0; round < 3000; ++round) {
    std::vector<std::byte> bytes;
    for (size_t n = random() % 60; bytes.size() < n;)
      bytes.insert(bytes.end(), 1 + (random() % 40 ? random() % 7 : random() % 600),
                   static_cast<std::byte>(random() % 3 + (random() % 2 ? 127 : 0)));
    const DeflateBits expected = bits_slowly(bytes), found = deflate_bits(bytes);
    ASSERT_EQ(found.alone_256, expected.alone_256);
    ASSERT_EQ(found.with_runs_256, expected.with_runs_256);
  }
}

} // namespace
} // namespace bccsplat

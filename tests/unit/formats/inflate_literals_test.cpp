// SPDX-License-Identifier: Apache-2.0
// The inflater of literals: what zlib writes comes back, and what zlib refuses is refused.
#include "formats/bcc4/coding/inflate_literals.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <random>
#include <vector>

#include "formats/bcc4/coding/deflate.h"

namespace bccsplat {
namespace {

using Bytes = std::vector<std::byte>;

Bytes deflated(const Bytes& bytes, int level, int strategy) {
  z_stream z{};
  EXPECT_EQ(deflateInit2(&z, level, Z_DEFLATED, -15, 8, strategy), Z_OK);
  Bytes out(deflateBound(&z, static_cast<uLong>(bytes.size())) + 64);
  z.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(bytes.data()));
  z.avail_in = static_cast<uInt>(bytes.size());
  z.next_out = reinterpret_cast<Bytef*>(out.data());
  z.avail_out = static_cast<uInt>(out.size());
  EXPECT_EQ(deflate(&z, Z_FINISH), Z_STREAM_END);
  out.resize(z.total_out);
  deflateEnd(&z);
  return out;
}

// Numbers of a geometric distribution; the smaller `p`, the longer the codes.
Bytes residuals(size_t count, double p) {
  std::mt19937 random(5);
  std::geometric_distribution<int> number(p);
  Bytes bytes(count);
  for (std::byte& b : bytes) b = static_cast<std::byte>(std::min(number(random), 255));
  return bytes;
}

// Whether it takes the stream, into a room whose surroundings stay as they are.
bool takes(const Bytes& stream, size_t size, Bytes& out) {
  constexpr size_t around = 16;
  constexpr std::byte mark{0x5a};
  const auto inflater = std::make_unique<LiteralInflater>();
  Bytes room(size + 2 * around, mark);
  const bool took = inflater->inflate(stream, std::span(room).subspan(around, size));
  for (size_t i = 0; i < around; ++i) {
    EXPECT_EQ(room[i], mark);
    EXPECT_EQ(room[around + size + i], mark);
  }
  out.assign(room.begin() + around, room.begin() + (around + size));
  return took;
}

// Codes of 1 to 15 bits, blocks that end within a look, runs, matches and blocks that are stored.
TEST(InflateLiterals, GivesWhatWasDeflated) {
  for (const double p : {0.999, 0.9, 0.6, 0.3, 0.05, 0.002})
    for (const size_t count : {size_t{1}, size_t{30}, size_t{5000}, size_t{40000}})
      for (const int strategy : {Z_HUFFMAN_ONLY, Z_RLE, Z_DEFAULT_STRATEGY})
        for (const int level : {0, 6}) {
          const Bytes bytes = residuals(count, p);
          Bytes out;
          if (count < 1000 && level > 0) continue; // in a fixed code
          EXPECT_TRUE(takes(deflated(bytes, level, strategy), count, out));
          EXPECT_EQ(out, bytes) << p << ' ' << count << " strategy " << strategy << " level " << level;
        }
}

TEST(InflateLiterals, LeavesFixedCodesToTheLibrary) {
  const Bytes bytes = residuals(5000, 0.4), stream = deflated(bytes, 6, Z_FIXED);
  Bytes out;
  EXPECT_FALSE(takes(stream, bytes.size(), out));
  Inflater inflater;
  EXPECT_TRUE(inflater.inflate(stream, out, DeflateKind::noise));
  EXPECT_EQ(out, bytes);
}

TEST(InflateLiterals, RefusesOtherSizesAndWhatFollows) {
  const Bytes bytes = residuals(9000, 0.5);
  Bytes stream = deflated(bytes, 6, Z_RLE), out;
  EXPECT_TRUE(takes(stream, bytes.size(), out));
  EXPECT_FALSE(takes(stream, bytes.size() - 1, out));
  EXPECT_FALSE(takes(stream, bytes.size() + 1, out));
  stream.push_back(std::byte{0});
  EXPECT_FALSE(takes(stream, bytes.size(), out));
}

// What is damaged is refused, or is what zlib makes of it.
TEST(InflateLiterals, TakesNothingThatZlibRefuses) {
  size_t taken = 0, refused = 0;
  for (const int strategy : {Z_HUFFMAN_ONLY, Z_RLE, Z_DEFAULT_STRATEGY}) {
    const Bytes bytes = residuals(3000, 0.5), stream = deflated(bytes, 6, strategy);
    Bytes out;
    for (size_t cut = 0; cut < stream.size(); ++cut)
      ASSERT_FALSE(takes(Bytes(stream.begin(), stream.begin() + cut), bytes.size(), out)) << cut;
    std::mt19937 random(3);
    for (int i = 0; i < 2000; ++i) {
      Bytes damaged = stream;
      const size_t at = i % 2 ? random() % 80 : random() % stream.size();
      damaged[at] ^= static_cast<std::byte>(1u << random() % 8);
      Bytes other(bytes.size());
      const bool took = takes(damaged, bytes.size(), out);
      took ? ++taken : ++refused;
      if (!took) continue;
      z_stream z{};
      ASSERT_EQ(inflateInit2(&z, -15), Z_OK);
      z.next_in = reinterpret_cast<Bytef*>(damaged.data());
      z.avail_in = static_cast<uInt>(damaged.size());
      z.next_out = reinterpret_cast<Bytef*>(other.data());
      z.avail_out = static_cast<uInt>(other.size());
      ASSERT_EQ(inflate(&z, Z_FINISH), Z_STREAM_END) << "strategy " << strategy << ", bit of byte " << at;
      EXPECT_EQ(z.avail_in + z.avail_out, 0u);
      inflateEnd(&z);
      EXPECT_EQ(out, other);
    }
  }
  EXPECT_GT(taken, 100u);
  EXPECT_GT(refused, 1000u);
}

} // namespace
} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Run lists: what is written comes back, in rows or all at once, and malformed lists are refused.
#include "points/runs.h"

#include <gtest/gtest.h>

#include <bit>
#include <random>

namespace bccsplat {
namespace {

struct Rows {
  std::vector<uint16_t> bits;
  std::vector<int> width;
};

std::vector<std::byte> encode(const Rows& rows) {
  ByteWriter out;
  RunEncoder encoder(out);
  for (size_t i = 0; i < rows.bits.size(); ++i) encoder.row(rows.bits[i], rows.width[i]);
  encoder.finish();
  return out.release();
}

uint64_t count_sites(const Rows& rows) {
  uint64_t n = 0;
  for (const int w : rows.width) n += w;
  return n;
}
uint64_t count_kept(const Rows& rows) {
  uint64_t n = 0;
  for (const uint16_t b : rows.bits) n += std::popcount(b);
  return n;
}

std::vector<uint16_t> decode(std::span<const std::byte> bytes, const std::vector<int>& width, uint64_t sites,
                             uint64_t kept) {
  ByteReader in(bytes, "runs");
  RunDecoder decoder(in, sites, kept);
  std::vector<uint16_t> out;
  for (const int w : width) out.push_back(decoder.row(w));
  decoder.finish();
  in.expect_end();
  return out;
}

TEST(Runs, AnyRowsComeBack) {
  std::mt19937 random(7);
  for (int round = 0; round < 300; ++round) {
    Rows rows;
    const int n = 1 + static_cast<int>(random() % 300);
    const auto density = static_cast<unsigned>(random() % 5);
    for (int i = 0; i < n; ++i) {
      const int w = static_cast<int>(random() % 17);
      auto bits = static_cast<unsigned>(random());
      if (density == 0) bits &= static_cast<unsigned>(random() & random() & random());
      if (density == 1) bits |= static_cast<unsigned>(random() | random() | random());
      if (density == 2) bits = 0;
      if (density == 3) bits = 0xffff;
      rows.bits.push_back(static_cast<uint16_t>(bits & ((1u << w) - 1)));
      rows.width.push_back(w);
    }
    EXPECT_EQ(decode(encode(rows), rows.width, count_sites(rows), count_kept(rows)), rows.bits);
  }
}

TEST(Runs, RowsFilledAtOnceAreThoseReadOneByOne) {
  std::mt19937 random(8);
  for (int round = 0; round < 200; ++round) {
    Rows rows;
    const size_t n = 1 + random() % 300;
    for (size_t i = 0; i < n; ++i) {
      const unsigned kind = random() % 4, bits = static_cast<unsigned>(random());
      rows.bits.push_back(static_cast<uint16_t>(kind == 0   ? 0
                                                : kind == 1 ? 0xffff
                                                : kind == 2 ? bits
                                                            : 0x07f8));
      rows.width.push_back(16);
    }
    if (count_kept(rows) == 0) continue;
    const auto bytes = encode(rows);
    ByteReader in(bytes, "runs");
    RunDecoder decoder(in, count_sites(rows), count_kept(rows));
    std::vector<uint16_t> filled(n);
    const size_t cut = random() % (n + 1); // in two parts
    decoder.fill(std::span(filled).first(cut));
    decoder.fill(std::span(filled).subspan(cut));
    decoder.finish();
    EXPECT_EQ(filled, rows.bits);
  }
}

TEST(Runs, AFullBrickIsOnePair) {
  const Rows rows{std::vector<uint16_t>(brick_rows, 0xffff), std::vector<int>(brick_rows, 16)};
  ByteWriter expected;
  expected.write_varint(0);
  expected.write_varint(brick_sites);
  EXPECT_EQ(encode(rows), expected.release());
}

TEST(Runs, BytesAreAtMostOnePerSiteAndOneMore) {
  for (const int bits : {0x5555, 0xaaaa, 0xffff, 0x1111, 0x8001}) {
    const Rows rows{std::vector<uint16_t>(brick_rows, static_cast<uint16_t>(bits)),
                    std::vector<int>(brick_rows, 16)};
    EXPECT_LE(encode(rows).size(), count_sites(rows) + 1);
  }
}

void expect_refused(std::initializer_list<uint8_t> bytes, uint64_t sites, uint64_t kept, Code code,
                    const char* text) {
  std::vector<std::byte> list;
  for (const uint8_t b : bytes) list.push_back(static_cast<std::byte>(b));
  std::vector<int> width(sites / 16, 16);
  if (sites % 16) width.push_back(static_cast<int>(sites % 16));
  try {
    static_cast<void>(decode(list, width, sites, kept));
    ADD_FAILURE() << text << ": was read";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), code) << e.message();
    EXPECT_NE(e.message().find(text), std::string::npos) << e.message();
  }
}

TEST(Runs, MalformedListsAreRefused) {
  expect_refused({1, 0}, 32, 4, Code::corrupt, "not canonical");                // empty run
  expect_refused({1, 2, 0, 2}, 32, 4, Code::corrupt, "not canonical");          // two runs that touch
  expect_refused({0, 5}, 32, 4, Code::corrupt, "goes beyond");                  // more set than there are
  expect_refused({29, 4}, 32, 4, Code::corrupt, "goes beyond");                 // over the end
  expect_refused({0, 4, 1}, 32, 4, Code::corrupt, "bytes too many");            // bytes left over
  expect_refused({0, 2}, 32, 4, Code::truncated, "bytes");                      // a pair is missing
  expect_refused({0x80, 0x00, 4}, 32, 4, Code::corrupt, "bad variable-length"); // longer than need be
  expect_refused({0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x7f, 4}, 32, 4, Code::corrupt,
                 "bad variable-length"); // more than 64 bits
}

TEST(Runs, RowsMustCoverTheRuns) {
  const Rows rows{{0xffff, 0xffff}, {16, 16}};
  const auto bytes = encode(rows);
  ByteReader in(bytes, "runs");
  RunDecoder decoder(in, 32, 32);
  EXPECT_EQ(decoder.row(16), 0xffff);
  EXPECT_THROW(decoder.finish(), Error);
}

TEST(Runs, CompressAndExpandAreInverse) {
  std::mt19937 random(1);
  for (int i = 0; i < 1000; ++i) {
    const auto mask = static_cast<uint16_t>(random()), bits = static_cast<uint16_t>(random() & mask);
    const uint16_t packed = compress_bits(bits, mask);
    EXPECT_EQ(std::popcount(packed), std::popcount(bits));
    EXPECT_EQ(packed >> std::popcount(mask), 0);
    EXPECT_EQ(expand_bits(packed, mask), bits);
  }
}

TEST(Runs, RowIndexReachesEveryRow) {
  std::mt19937 random(2);
  BrickMask kept;
  for (uint16_t& row : kept) row = static_cast<uint16_t>(random());
  const RowIndex index = row_index(kept);
  int n = 0;
  for (size_t r = 0; r < brick_rows; ++r) {
    EXPECT_EQ(index[r], n);
    n += std::popcount(kept[r]);
  }
  EXPECT_EQ(index[brick_rows], n);
}

} // namespace
} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Words of bits against samples that are looked at one by one.
#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "fit/axis/near_source.h"
#include "fit/axis/nonzero_bits.h"

namespace bccsplat {
namespace {

std::vector<SampleSpan> spans(size_t count, size_t samples, size_t longest, std::mt19937& random) {
  std::vector<SampleSpan> list;
  for (size_t i = 0; i < count; ++i) {
    const size_t first = random() % samples;
    list.push_back({first, std::min(samples - 1, first + random() % longest)});
  }
  return list;
}

TEST(NearSource, EqualsLookingAtEverySample) {
  std::mt19937 random(7);
  TileBits bits;
  for (const size_t width : {5u, 64u, 65u, 130u, 200u}) {
    const size_t ny = 9, nz = 6;
    std::vector<float> sample(width * ny * nz);
    for (float& v : sample) v = random() % 150 == 0 ? -0.25f : 0.0f;
    bits.clear(width, ny, nz);
    for (size_t z = 0; z < nz; ++z)
      for (size_t y = 0; y < ny; ++y) bits.add_row(sample.data() + (z * ny + y) * width, y, z);
    const auto along_x = spans(16, width, 64, random), along_y = spans(16, ny, 4, random),
               along_z = spans(16, nz, 4, random);
    const SpanGroup group(along_x);
    std::vector<char> found(16 * 16 * 16);
    bits.for_rows(along_y, along_z, [&](size_t j, size_t k, const uint64_t* row) {
      const uint32_t together = group.any(row);
      for (size_t i = 0; i < 16; ++i) {
        found[(k * 16 + j) * 16 + i] = TileBits::any(row, along_x[i]);
        EXPECT_EQ(together >> i & 1, found[(k * 16 + j) * 16 + i] != 0 ? 1u : 0u) << width << " " << i;
      }
    });
    size_t set = 0;
    for (size_t k = 0; k < 16; ++k)
      for (size_t j = 0; j < 16; ++j)
        for (size_t i = 0; i < 16; ++i) {
          bool any = false;
          for (size_t z = along_z[k].first; z <= along_z[k].last; ++z)
            for (size_t y = along_y[j].first; y <= along_y[j].last; ++y)
              for (size_t x = along_x[i].first; x <= along_x[i].last; ++x)
                any = any || sample[(z * ny + y) * width + x] != 0;
          ASSERT_EQ(found[(k * 16 + j) * 16 + i] != 0, any) << width;
          set += any;
        }
    EXPECT_GT(set, 0u);
    EXPECT_LT(set, 4096u);
  }
}

TEST(NearSource, SpansOfABrickTogether) {
  std::mt19937 random(8);
  for (const size_t first : {0u, 1u, 40u, 63u, 64u, 100u})
    for (const size_t width : {20u, 63u, 64u, 65u, 90u}) {
      std::vector<SampleSpan> list = spans(16, width, 30, random);
      list[3] = {0, 0}, list[9] = {width - 1, width - 1};
      for (SampleSpan& s : list) s.first += first, s.last += first;
      const SpanGroup group(list);
      for (int i = 0; i < 50; ++i) {
        std::array<uint64_t, 5> row{};
        for (int k = 0; k < i % 4; ++k) {
          const size_t at = random() % 192;
          row[at / 64] |= uint64_t{1} << at % 64;
        }
        for (size_t k = 0; k < 16; ++k)
          ASSERT_EQ(group.any(row.data()) >> k & 1, TileBits::any(row.data(), list[k]));
      }
    }
}

TEST(NonzeroBits, EqualTheValues) {
  std::mt19937 random(9);
  for (const size_t count : {1u, 7u, 16u, 63u, 64u, 65u, 150u}) {
    std::vector<float> row(count);
    for (float& v : row) v = random() % 3 == 0 ? 0.0f : random() % 5 == 0 ? -1e-40f : 2.0f;
    row[0] = -0.0f, row[count - 1] = std::nanf("");
    std::vector<uint64_t> words((count + 63) / 64, ~uint64_t{0});
    nonzero_bits(row.data(), count, words.data());
    for (size_t i = 0; i < 64 * words.size(); ++i)
      ASSERT_EQ(words[i / 64] >> i % 64 & 1, i < count && row[i] != 0 ? 1u : 0u) << count << " " << i;
  }
}

} // namespace
} // namespace bccsplat

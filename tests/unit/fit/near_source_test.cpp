// SPDX-License-Identifier: Apache-2.0
// Words of bits against samples that are looked at one by one.
#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include "fit/near_source.h"

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
    std::vector<char> found(16 * 16 * 16);
    bits.for_rows(along_y, along_z, [&](size_t j, size_t k, const uint64_t* row) {
      for (size_t i = 0; i < 16; ++i) found[(k * 16 + j) * 16 + i] = TileBits::any(row, along_x[i]);
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

} // namespace
} // namespace bccsplat

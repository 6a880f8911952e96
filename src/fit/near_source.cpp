// SPDX-License-Identifier: Apache-2.0
#include "fit/near_source.h"

#include <algorithm>
#include <cmath>

namespace bccsplat {

std::array<int64_t, 2> near_samples(double position, double reach, const FilterTable& table, size_t site,
                                    int64_t nearest, bool turns, int64_t n) {
  reach = std::min(reach, 31.0);
  std::array<int64_t, 2> near{
      std::max(table.first[site], static_cast<int64_t>(std::ceil(position - reach))),
      std::min(table.first[site] + table.taps - 1, static_cast<int64_t>(std::floor(position + reach)))};
  for (int64_t& sample : near)
    if (!turns) sample = std::clamp<int64_t>(sample, 0, n - 1);
  return {std::min(near[0], nearest), std::max(near[1], nearest)};
}

void TileBits::clear(size_t width, size_t ny, size_t nz) {
  width_ = width, ny_ = ny, words_ = (width + 63) / 64;
  bits_.assign(nz * ny * words_, 0);
}

void TileBits::add_row(const float* row, size_t y, size_t z) {
  uint64_t* bits = bits_.data() + (z * ny_ + y) * words_;
  for (size_t begin = 0; begin < width_; begin += 64) {
    uint64_t word = 0;
    for (size_t i = 0; i < std::min<size_t>(64, width_ - begin); ++i)
      word |= static_cast<uint64_t>(row[begin + i] != 0) << i;
    bits[begin / 64] = word;
  }
}

bool TileBits::join(const std::vector<uint64_t>& from, size_t size, const SampleSpan& span,
                    std::vector<uint64_t>& to) {
  to.assign(size + 1, 0);
  uint64_t all = 0;
  for (size_t s = span.first; s <= span.last; ++s)
    for (size_t i = 0; i < size; ++i) {
      to[i] |= from[s * size + i];
      all |= from[s * size + i];
    }
  return all != 0;
}

} // namespace bccsplat

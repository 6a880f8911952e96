// SPDX-License-Identifier: Apache-2.0
#include "fit/near_source.h"

#include <algorithm>

namespace bccsplat {

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

// SPDX-License-Identifier: Apache-2.0
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fit/axis/nonzero_bits.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <algorithm>

#include "fit/axis/nonzero_bits.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

void NonzeroBits(const float* HWY_RESTRICT row, size_t count, uint64_t* HWY_RESTRICT words) {
  const hn::CappedTag<float, 16> d;
  const size_t lanes = hn::Lanes(d);
  for (size_t begin = 0; begin < count; begin += 64) {
    uint64_t word = 0;
    const size_t end = std::min<size_t>(64, count - begin);
    size_t i = 0;
    for (; i + lanes <= end; i += lanes) {
      uint8_t bytes[8] = {};
      // Ne is false of NaN.
      hn::StoreMaskBits(d, hn::Not(hn::Eq(hn::LoadU(d, row + begin + i), hn::Zero(d))), bytes);
      word |= static_cast<uint64_t>(bytes[0] | uint32_t{bytes[1]} << 8) << i;
    }
    for (; i < end; ++i) word |= static_cast<uint64_t>(row[begin + i] != 0) << i;
    words[begin / 64] = word;
  }
}

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {
HWY_EXPORT(NonzeroBits);

void nonzero_bits(const float* row, size_t count, uint64_t* words) {
  HWY_DYNAMIC_DISPATCH(NonzeroBits)(row, count, words);
}

} // namespace bccsplat
#endif

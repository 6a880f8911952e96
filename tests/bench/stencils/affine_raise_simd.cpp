// SPDX-License-Identifier: Apache-2.0
// The loop of affine_raise.h through Highway: one body is compiled for every target, and the best is chosen
// at run time. Targets whose vectors hold fewer than 16 floats take the reference.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tests/bench/stencils/affine_raise_simd.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <algorithm>

#include "tests/bench/stencils/affine_raise.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat::bench {
namespace HWY_NAMESPACE {

#if HWY_TARGET > HWY_AVX3
void RaiseTurned(const RaiseBlock& b) { raise_block_reference(b); }
#else

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<float, 16>;
using V = hn::Vec<D>;
constexpr D d;
constexpr hn::RebindToSigned<D> di;
constexpr hn::Repartition<double, D> dd;

// Writes 16 rows of 16 floats as columns.
HWY_INLINE void Turn(const float* rows, float* out, std::ptrdiff_t pitch) {
  V quad[4][4]; // [rows 4 g ..][q]: columns q, 4 + q, 8 + q, 12 + q of four rows, one block each
  for (int g = 0; g < 4; ++g) {
    const V a = hn::Load(d, rows + (4 * g + 0) * 16), b = hn::Load(d, rows + (4 * g + 1) * 16),
            c = hn::Load(d, rows + (4 * g + 2) * 16), e = hn::Load(d, rows + (4 * g + 3) * 16);
    const auto ab0 = hn::BitCast(dd, hn::InterleaveLower(d, a, b)),
               ab1 = hn::BitCast(dd, hn::InterleaveUpper(d, a, b));
    const auto ce0 = hn::BitCast(dd, hn::InterleaveLower(d, c, e)),
               ce1 = hn::BitCast(dd, hn::InterleaveUpper(d, c, e));
    quad[g][0] = hn::BitCast(d, hn::InterleaveLower(dd, ab0, ce0));
    quad[g][1] = hn::BitCast(d, hn::InterleaveUpper(dd, ab0, ce0));
    quad[g][2] = hn::BitCast(d, hn::InterleaveLower(dd, ab1, ce1));
    quad[g][3] = hn::BitCast(d, hn::InterleaveUpper(dd, ab1, ce1));
  }
  for (int q = 0; q < 4; ++q) {
    const auto even = [&](int g) HWY_ATTR {
      return hn::OddEvenBlocks(hn::SwapAdjacentBlocks(quad[g + 1][q]), quad[g][q]);
    };
    const auto odd = [&](int g) HWY_ATTR {
      return hn::OddEvenBlocks(quad[g + 1][q], hn::SwapAdjacentBlocks(quad[g][q]));
    };
    const V even0 = even(0), even2 = even(2), odd0 = odd(0), odd2 = odd(2);
    hn::StoreU(hn::ConcatLowerLower(d, even2, even0), d, out + q * pitch);
    hn::StoreU(hn::ConcatLowerLower(d, odd2, odd0), d, out + (4 + q) * pitch);
    hn::StoreU(hn::ConcatUpperUpper(d, even2, even0), d, out + (8 + q) * pitch);
    hn::StoreU(hn::ConcatUpperUpper(d, odd2, odd0), d, out + (12 + q) * pitch);
  }
}

template<int kTaps> void RaiseTaps(const RaiseBlock& b) {
  HWY_ALIGN float rows[most_raised][raise_block * raise_block];
  for (int r = 0; r < raise_block; ++r) {
    const int32_t base = std::min(b.sample[r][0], b.sample[r][raise_block - 1]);
    const auto offset = hn::Sub(hn::LoadU(di, b.sample[r]), hn::Set(di, base));
    const int most = b.sample[r][0] + b.sample[r][raise_block - 1] - 2 * base;
    V w[kTaps];
    for (int t = 0; t < kTaps; ++t) w[t] = hn::LoadU(d, b.weight[r] + t * b.weight_pitch);
    constexpr int half = kTaps / 2;
    if (most + half <= raise_block) {
      // One vector holds the samples of half of the taps, and another, that many further, the rest.
      for (int s = 0; s < b.sheets; ++s) {
        const float* const from = b.source[s][r] + base;
        const V first = hn::LoadU(d, from), rest = hn::LoadU(d, from + half);
        V sum = hn::Zero(d), other = hn::Zero(d);
        for (int t = 0; t < half; ++t) {
          const auto place = hn::IndicesFromVec(d, hn::Add(offset, hn::Set(di, t)));
          sum = hn::MulAdd(w[t], hn::TableLookupLanes(first, place), sum);
          other = hn::MulAdd(w[half + t], hn::TableLookupLanes(rest, place), other);
        }
        hn::Store(hn::Add(sum, other), d, rows[s] + r * raise_block);
      }
      continue;
    }
    const auto place = hn::IndicesFromVec(d, hn::And(offset, hn::Set(di, raise_block - 1)));
    const auto second = hn::RebindMask(d, hn::Gt(offset, hn::Set(di, raise_block - 1)));
    const bool wide = most >= raise_block;
    for (int s = 0; s < b.sheets; ++s) {
      const float* const from = b.source[s][r] + base;
      V sum = hn::Zero(d);
      for (int t = 0; t < kTaps; ++t) {
        V x = hn::TableLookupLanes(hn::LoadU(d, from + t), place);
        if (wide) x = hn::IfThenElse(second, hn::TableLookupLanes(hn::LoadU(d, from + t + 16), place), x);
        sum = hn::MulAdd(w[t], x, sum);
      }
      hn::Store(sum, d, rows[s] + r * raise_block);
    }
  }
  for (int s = 0; s < b.sheets; ++s) Turn(rows[s], b.out[s], b.out_pitch);
}

void RaiseTurned(const RaiseBlock& b) {
  if (b.taps == 4) return RaiseTaps<4>(b);
  if (b.taps == 6) return RaiseTaps<6>(b);
  RaiseTaps<8>(b);
}

#endif
} // namespace HWY_NAMESPACE
} // namespace bccsplat::bench
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat::bench {
HWY_EXPORT(RaiseTurned);

void raise_turned(const RaiseBlock& b) { HWY_DYNAMIC_DISPATCH(RaiseTurned)(b); }

} // namespace bccsplat::bench
#endif

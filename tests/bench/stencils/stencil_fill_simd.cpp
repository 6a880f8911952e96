// SPDX-License-Identifier: Apache-2.0
// The loop of stencil_fill.h through Highway: one body is compiled for every target, and the best is chosen
// at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tests/bench/stencils/stencil_fill_simd.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include "tests/bench/stencils/stencil_fill.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat::bench {
namespace HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR
void FillRow(const RowArgs& a) { fill_row_reference(a); }
#else

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<float, 16>;
using V = hn::Vec<D>;
constexpr D d;

// Samples 2 * lanes * kVectors from `n` on, n in pairs.
template<int kVectors> HWY_INLINE void FillBlock(const RowArgs& a, int n) {
  const int lanes = static_cast<int>(hn::Lanes(d));
  V even[kVectors], odd[kVectors];
  for (int i = 0; i < kVectors; ++i) even[i] = odd[i] = hn::Zero(d);
  const StencilTap* tap = a.stencil->taps.data();
  const StencilTap *const both = tap + a.stencil->both, *const first = both + a.stencil->even,
                          *const end = tap + a.stencil->taps.size();
  const float* const sites = a.sites + n;
  for (; tap != both; ++tap) {
    const V w0 = hn::Set(d, tap->weight[0]), w1 = hn::Set(d, tap->weight[1]);
    for (int i = 0; i < kVectors; ++i) {
      const V c = hn::LoadU(d, sites + tap->site + i * lanes);
      even[i] = hn::MulAdd(w0, c, even[i]), odd[i] = hn::MulAdd(w1, c, odd[i]);
    }
  }
  for (; tap != first; ++tap) {
    const V w = hn::Set(d, tap->weight[0]);
    for (int i = 0; i < kVectors; ++i)
      even[i] = hn::MulAdd(w, hn::LoadU(d, sites + tap->site + i * lanes), even[i]);
  }
  for (; tap != end; ++tap) {
    const V w = hn::Set(d, tap->weight[1]);
    for (int i = 0; i < kVectors; ++i)
      odd[i] = hn::MulAdd(w, hn::LoadU(d, sites + tap->site + i * lanes), odd[i]);
  }
  for (int i = 0; i < kVectors; ++i) hn::StoreInterleaved2(even[i], odd[i], d, a.row + 2 * (n + i * lanes));
}

void FillRow(const RowArgs& a) {
  const int lanes = static_cast<int>(hn::Lanes(d)), pairs = (a.count + 1) / 2;
  int n = 0;
  for (; n + 3 * lanes < pairs; n += 4 * lanes) FillBlock<4>(a, n);
  if (n + 2 * lanes < pairs)
    FillBlock<3>(a, n);
  else if (n + lanes < pairs)
    FillBlock<2>(a, n);
  else if (n < pairs)
    FillBlock<1>(a, n);
}

#endif
} // namespace HWY_NAMESPACE
} // namespace bccsplat::bench
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat::bench {
HWY_EXPORT(FillRow);

void fill_row(const RowArgs& a) { HWY_DYNAMIC_DISPATCH(FillRow)(a); }

} // namespace bccsplat::bench
#endif

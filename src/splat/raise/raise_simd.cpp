// SPDX-License-Identifier: Apache-2.0
// The loops of raise.h through Highway: one body is compiled for every target, and the best is chosen at run
// time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/raise/raise_simd.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <algorithm>

#include "base/grid.h"
#include "splat/raise/raise.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR
void Raise(const RaiseArgs& a) { raise_reference(a); }
void Blend(const BlendArgs& a) { blend_reference(a); }
#else

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<float, 16>;
using V = hn::Vec<D>;
constexpr D d;
constexpr hn::RebindToSigned<D> di;

// Raises rows [y, end) along y, over all samples [first, last) that they need.
template<int kTaps> HWY_INLINE void RaiseRows(const RaiseArgs& a, int y, int end, int first, int last) {
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (int r = y; r < end; ++r) {
    const float* from = a.sheet + plane_offset(0, a.sample_y[r] - a.origin_y, a.sheet_pitch);
    float* to = a.scratch + plane_offset(0, r - y, a.scratch_pitch);
    V w[kTaps];
    for (int t = 0; t < kTaps; ++t) w[t] = hn::Set(d, a.weight_y[t * a.weight_pitch_y + r]);
    for (int c = first; c < last; c += lanes) {
      V sum = hn::Mul(w[0], hn::LoadU(d, from + c));
      for (int t = 1; t < kTaps; ++t)
        sum = hn::MulAdd(w[t], hn::LoadU(d, from + plane_offset(c, t, a.sheet_pitch)), sum);
      hn::StoreU(sum, d, to + (c - first));
    }
  }
}

template<int kTaps> void RaiseTaps(const RaiseArgs& a) {
  const int lanes = static_cast<int>(hn::Lanes(d));
  const int first = a.sample_x[a.x0] - a.origin_x, last = a.sample_x[a.x1 - 1] - a.origin_x + kTaps;
  for (int y = a.y0; y < a.y1; y += raise_rows) {
    const int end = std::min(y + raise_rows, a.y1);
    RaiseRows<kTaps>(a, y, end, first, last);
    for (int x = a.x0; x < a.x1; x += lanes) {
      // Where pixels are closer than samples, the samples of neighbouring pixels fit into one vector, else
      // into two.
      const int32_t base = a.sample_x[x];
      const auto offset = hn::Sub(hn::LoadU(di, a.sample_x + x), hn::Set(di, base));
      const auto place = hn::IndicesFromVec(d, hn::And(offset, hn::Set(di, lanes - 1)));
      const auto second = hn::RebindMask(d, hn::Gt(offset, hn::Set(di, lanes - 1)));
      V w[kTaps];
      for (int t = 0; t < kTaps; ++t) w[t] = hn::LoadU(d, a.weight_x + t * a.weight_pitch_x + x);
      const float* from = a.scratch + (base - a.origin_x - first);
      float* to = a.plane + plane_offset(x, y, a.plane_pitch);
      const auto rows = [&](auto pick) HWY_ATTR {
        for (int r = y; r < end; ++r, from += a.scratch_pitch, to += a.plane_pitch) {
          V sum = hn::Mul(w[0], pick(from));
          for (int t = 1; t < kTaps; ++t) sum = hn::MulAdd(w[t], pick(from + t), sum);
          hn::StoreU(sum, d, to);
        }
      };
      if (a.sample_x[x + lanes - 1] - base < lanes)
        rows([&](const float* p) HWY_ATTR { return hn::TableLookupLanes(hn::LoadU(d, p), place); });
      else
        rows([&](const float* p) HWY_ATTR {
          return hn::IfThenElse(second, hn::TableLookupLanes(hn::LoadU(d, p + lanes), place),
                                hn::TableLookupLanes(hn::LoadU(d, p), place));
        });
    }
  }
}

void Blend(const BlendArgs& a) {
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (int y = a.y0; y < a.y1; ++y) {
    float* const out = a.out + plane_offset(0, y, a.out_pitch);
    const std::ptrdiff_t row = plane_offset(0, y, a.pitch);
    for (int x = a.x0; x < a.x1; x += lanes) {
      V sum = hn::Zero(d);
      for (int t = 0; t < a.taps; ++t)
        sum = hn::MulAdd(hn::Set(d, a.weight[t]), hn::LoadU(d, a.plane[t] + row + x), sum);
      hn::StoreU(sum, d, out + x);
    }
  }
}

void Raise(const RaiseArgs& a) {
  if (a.x0 >= a.x1 || a.y0 >= a.y1) return;
  if (a.taps == 4) return RaiseTaps<4>(a);
  if (a.taps == 6) return RaiseTaps<6>(a);
  RaiseTaps<8>(a);
}

#endif

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {
HWY_EXPORT(Raise);
HWY_EXPORT(Blend);

void raise_sheet(const RaiseArgs& a) { HWY_DYNAMIC_DISPATCH(Raise)(a); }
void blend_planes(const BlendArgs& a) { HWY_DYNAMIC_DISPATCH(Blend)(a); }

} // namespace bccsplat
#endif

// SPDX-License-Identifier: Apache-2.0
// Adds points to the ring through Highway: one body is compiled for every target, and the best is chosen at
// run time. SplatForm() chooses the loop for a window; the loops for isotropic windows are in
// splat_isotropic-inl.h. SSE4 has nothing that these loops use and SSSE3 has not
// (tests/bench/notes/splat.md).
#ifndef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS HWY_SSE4
#endif
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/loop/splat_simd.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <algorithm>

#include "base/grid.h"
#include "splat/loop/loops.h"
#include "splat/loop/splat_isotropic-inl.h"
#include "splat/loop/splat_weights-inl.h"
HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR
// The reference loops stand in where there are no vectors.
void Splat(const SplatArgs& s) { reference_loops().splat(s); }
#else

template<KernelPolynomial::Form kForm, bool kIsotropic, bool kGradient>
void SplatGeneral(const SplatArgs& s) {
  const int vp = PixelsPerVector();
  const auto step = static_cast<size_t>(s.pitch) * 4;
  const V pixel = hn::Load(d, lane_pixel), one = hn::Set(d, 1.0f), zero = hn::Zero(d),
          depth2 = hn::Set(d, s.depth2);
  const GapLanes& lanes = *s.lanes;
  for (size_t n = 0; n < s.count; ++n) {
    const SplatRecord& p = s.record[n];
    const int r0 = std::max(0, -p.y), r1 = std::min(s.rows, s.height - p.y);
    // Vectors of the window that touch the tile; they may reach into the spare pixels.
    const int v0 = p.x >= 0 ? 0 : (-p.x) / vp * vp, v1 = std::min(s.columns, s.width - p.x);
    const V fx = hn::Set(d, p.fx), z = hn::Set(d, p.z);
    const Weights<kForm> weights(*s.kernel, p.c);
    const std::ptrdiff_t start = plane_offset(p.x, p.y + r0, s.pitch) * 4;
    for (int g = 0; g < s.groups; ++g) {
      const V dk = hn::Sub(Repeat4(lanes.offset + 4 * g), z);
      const V height = hn::NegMulAdd(hn::Mul(dk, depth2), dk, one);
      const V xx = Repeat4(lanes.xx + 4 * g), yy = Repeat4(lanes.yy + 4 * g),
              reach = Repeat4(lanes.reach + 4 * g);
      V x_shift = fx, y_foot = hn::Set(d, p.fy), xy = zero;
      if constexpr (!kIsotropic) {
        const V delta = Repeat4(lanes.delta + 4 * g);
        x_shift = hn::MulAdd(hn::Set(d, p.lateral_x), delta, fx);
        y_foot = hn::MulAdd(hn::Set(d, p.lateral_y), delta, y_foot);
        xy = Repeat4(lanes.xy + 4 * g);
      }
      const std::ptrdiff_t base = start + g * static_cast<std::ptrdiff_t>(s.group_floats);
      for (int v = v0; v < v1; v += vp) {
        const V di = hn::Sub(hn::Add(pixel, hn::Set(d, static_cast<float>(v))), x_shift);
        // No row of these columns and sheets is in reach.
        if (hn::AllFalse(d, hn::Gt(hn::NegMulAdd(hn::Mul(di, reach), di, height), zero))) continue;
        const V level = hn::NegMulAdd(hn::Mul(di, xx), di, height);
        const V slant = hn::Mul(di, xy);
        float* sum = s.ring[0] + base + 4 * v;
        for (int r = r0; r < r1; ++r, sum += step) {
          const V dj = hn::Sub(hn::Set(d, static_cast<float>(r)), y_foot);
          const V across = kIsotropic ? hn::Mul(dj, yy) : hn::MulAdd(dj, yy, slant);
          const V u = hn::Max(hn::NegMulAdd(across, dj, level), zero);
          if constexpr (!kGradient) {
            hn::StoreU(weights.add(u, hn::LoadU(d, sum)), d, sum);
          } else {
            const std::ptrdiff_t at = sum - s.ring[0];
            V w;
            hn::StoreU(weights.add(u, hn::LoadU(d, sum), w), d, sum);
            hn::StoreU(hn::MulAdd(w, di, hn::LoadU(d, s.ring[1] + at)), d, s.ring[1] + at);
            hn::StoreU(hn::MulAdd(w, dj, hn::LoadU(d, s.ring[2] + at)), d, s.ring[2] + at);
            hn::StoreU(hn::MulAdd(w, dk, hn::LoadU(d, s.ring[3] + at)), d, s.ring[3] + at);
          }
        }
      }
    }
  }
}

// The body for a window:
//
//   isotropic, more than 16 rows                         SplatIsotropic, large
//   at most two vectors wide, no gradient, spare pixels  SplatSmall
//   at most 16 x 16 pixels                               SplatBlocks
//   at most 16 rows, wider                               SplatIsotropic
//   sheared, and all windows of the general form         SplatGeneral
template<KernelPolynomial::Form kForm> void SplatForm(const SplatArgs& s) {
  const bool gradient = s.ring[1] != nullptr;
  if constexpr (kForm != KernelPolynomial::Form::general) {
    if (s.isotropic && s.rows > block_window)
      return gradient ? SplatIsotropic<kForm, true, true>(s) : SplatIsotropic<kForm, false, true>(s);
    if (s.isotropic && s.spare && !gradient && s.columns <= 2 * PixelsPerVector())
      return s.columns <= PixelsPerVector() ? SplatSmall<kForm, false>(s) : SplatSmall<kForm, true>(s);
    if (s.isotropic && s.rows <= block_window && s.columns <= block_window)
      return gradient ? SplatBlocks<kForm, true>(s) : SplatBlocks<kForm, false>(s);
    if (s.isotropic)
      return gradient ? SplatIsotropic<kForm, true, false>(s) : SplatIsotropic<kForm, false, false>(s);
  } else if (s.isotropic) {
    return gradient ? SplatGeneral<kForm, true, true>(s) : SplatGeneral<kForm, true, false>(s);
  }
  gradient ? SplatGeneral<kForm, false, true>(s) : SplatGeneral<kForm, false, false>(s);
}

void Splat(const SplatArgs& s) {
  using Form = KernelPolynomial::Form;
  switch (s.kernel->form) {
  case Form::flat_form:
    return SplatForm<Form::flat_form>(s);
  case Form::short_form:
    return SplatForm<Form::short_form>(s);
  case Form::square_8:
    return SplatForm<Form::square_8>(s);
  case Form::general:
    break;
  }
  SplatForm<Form::general>(s);
}

#endif

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {
HWY_EXPORT(Splat);

void splat_points(const SplatArgs& s) { HWY_DYNAMIC_DISPATCH(Splat)(s); }

} // namespace bccsplat
#endif

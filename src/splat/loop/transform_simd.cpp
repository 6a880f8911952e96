// SPDX-License-Identifier: Apache-2.0
// Moves points to the screen and takes finished sheets out of the ring, through Highway: one body is compiled
// for every target, and the best is chosen at run time. The formulae are those of reference.cpp.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/loop/transform_simd.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <algorithm>
#include <cstring>

#include "splat/loop/loops.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR
// Without vectors the reference loops do it.
TransformCounts Transform(const TransformArgs& t) { return reference_loops().transform(t); }
void Extract(const ExtractArgs& e) { reference_loops().extract(e); }
#else

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, 16>;
using V = hn::Vec<D>;
constexpr D d;

// The pixels of a tile that may look at windows of samples, see fan_window() in reference.cpp.
struct FanWindow {
  using I = hn::Vec<hn::RebindToSigned<D>>;
  const FanArgs& fan;
  V near, far;
  HWY_INLINE FanWindow(const FanArgs& f, I gap)
      : fan(f), near(hn::GatherIndex(d, f.inverse_near, gap)), far(hn::GatherIndex(d, f.inverse_far, gap)) {}
  HWY_INLINE void pixels(float per, float foot, int sample_foot, I start, I count, I& begin, I& end) const {
    const hn::RebindToSigned<D> di;
    const auto sample = hn::Sub(start, hn::Set(di, sample_foot + fan.around));
    const auto after = hn::Add(hn::Add(sample, count), hn::Set(di, 2 * fan.around));
    const V low = hn::Mul(hn::ConvertTo(d, sample), hn::Set(d, per)),
            high = hn::Mul(hn::ConvertTo(d, after), hn::Set(d, per)), at = hn::Set(d, foot),
            limit = hn::Set(d, 1e8f);
    const V first = hn::Add(hn::Min(hn::Mul(low, near), hn::Mul(low, far)), at),
            last = hn::Add(hn::Max(hn::Mul(high, near), hn::Mul(high, far)), at);
    begin = hn::Sub(hn::ConvertTo(di, hn::Max(hn::Floor(first), hn::Neg(limit))), hn::Set(di, fan.border));
    end = hn::Add(hn::ConvertTo(di, hn::Min(hn::Ceil(last), limit)), hn::Set(di, 1 + fan.border));
  }
};

template<bool kIsotropic> TransformCounts TransformPoints(const TransformArgs& t) {
  using I = hn::RebindToSigned<D>;
  const I di;
  const hn::Rebind<uint16_t, D> d16;
  const size_t lanes = hn::Lanes(d);
  const BrickAxes& f = *t.axes;
  const auto base = static_cast<int32_t>(f.k - t.base_gap);
  const auto first = hn::Set(di, static_cast<int32_t>(t.first_gap - t.base_gap) - 1),
             last = hn::Set(di, static_cast<int32_t>(t.last_gap - t.base_gap) + 1);
  const auto low4 = hn::Set(di, 15);
  const V limit = hn::Set(d, 1e8f), one = hn::Set(d, 1.0f);
  alignas(64) float front[64];  // fx fy z c of each point
  alignas(64) int32_t back[64]; // x y X Y
  alignas(64) int32_t bin[16];
  const int32_t trash = static_cast<int32_t>(t.bin_mask) + 1;
  const bool all_cells = t.cells == ~uint64_t{0};
  const auto cells_low = hn::Set(di, static_cast<int32_t>(static_cast<uint32_t>(t.cells))),
             cells_high = hn::Set(di, static_cast<int32_t>(static_cast<uint32_t>(t.cells >> 32)));
  TransformCounts counts;
  for (size_t n = 0; n < t.count; n += lanes) {
    // Points past the end are read as points of the next brick, or of the array's spare end, and rejected.
    const auto packed = hn::PromoteTo(di, hn::LoadU(d16, t.position + n));
    auto good = hn::Lt(hn::Iota(di, 0), hn::Set(di, static_cast<int32_t>(std::min(lanes, t.count - n))));
    if (!all_cells) {
      const auto cell = hn::Or(hn::Or(hn::And(hn::ShiftRight<2>(packed), hn::Set(di, 3)),
                                      hn::And(hn::ShiftRight<4>(packed), hn::Set(di, 12))),
                               hn::And(hn::ShiftRight<6>(packed), hn::Set(di, 48)));
      const auto word = hn::IfThenElse(hn::Lt(cell, hn::Set(di, 32)), cells_low, cells_high);
      const auto bit = hn::And(hn::Shr(word, hn::And(cell, hn::Set(di, 31))), hn::Set(di, 1));
      const size_t before = hn::CountTrue(di, good);
      good = hn::And(good, hn::Gt(bit, hn::Zero(di)));
      counts.invisible += before - hn::CountTrue(di, good);
      if (hn::AllFalse(di, good)) continue;
    }
    const V x = hn::ConvertTo(d, hn::And(packed, low4));
    const V y = hn::ConvertTo(d, hn::And(hn::ShiftRight<4>(packed), low4));
    const V z = hn::ConvertTo(d, hn::ShiftRight<8>(packed));
    const auto affine = [&](const std::array<float, 4>& a) HWY_ATTR {
      return hn::MulAdd(hn::Set(d, a[0]), x,
                        hn::MulAdd(hn::Set(d, a[1]), y, hn::MulAdd(hn::Set(d, a[2]), z, hn::Set(d, a[3]))));
    };
    const V depth = affine(f.dk), whole = hn::Floor(depth);
    const auto gap = hn::Add(hn::ConvertTo(di, whole), hn::Set(di, base));
    const auto within = hn::And(hn::Gt(gap, first), hn::Lt(gap, last));
    good = hn::And(good, within);
    const auto safe = hn::IfThenElse(within, gap, hn::Sub(last, hn::Set(di, 1)));
    V foot_x = affine(f.di), foot_y = affine(f.dj), half_x, half_y;
    V lateral_x = hn::Zero(d), lateral_y = hn::Zero(d);
    hn::Vec<I> columns, rows;
    if constexpr (kIsotropic) {
      half_x = hn::Set(d, t.half_x[0]), half_y = hn::Set(d, t.half_y[0]);
      columns = hn::Set(di, t.columns[0]), rows = hn::Set(di, t.rows[0]);
    } else {
      const V shift = hn::Sub(hn::GatherIndex(d, t.lateral, safe), hn::Set(d, f.m));
      lateral_x = affine(f.dX), lateral_y = affine(f.dY);
      foot_x = hn::MulAdd(lateral_x, shift, foot_x), foot_y = hn::MulAdd(lateral_y, shift, foot_y);
      half_x = hn::GatherIndex(d, t.half_x, safe), half_y = hn::GatherIndex(d, t.half_y, safe);
      columns = hn::GatherIndex(di, t.columns, safe), rows = hn::GatherIndex(di, t.rows, safe);
    }
    const auto begin = [&](V foot, V half) HWY_ATTR {
      return hn::Add(hn::Floor(hn::Min(hn::Max(hn::Sub(foot, half), hn::Neg(limit)), limit)), one);
    };
    const V start_x = begin(foot_x, half_x), start_y = begin(foot_y, half_y);
    const auto px = hn::Add(hn::ConvertTo(di, start_x), hn::Set(di, f.i - t.tile_x));
    const auto py = hn::Add(hn::ConvertTo(di, start_y), hn::Set(di, f.j - t.tile_y));
    const auto none = hn::Zero(di);
    good = hn::And(good, hn::And(hn::Lt(px, hn::Set(di, t.width)), hn::Lt(py, hn::Set(di, t.height))));
    good = hn::And(good, hn::And(hn::Gt(hn::Add(px, columns), none), hn::Gt(hn::Add(py, rows), none)));
    if (t.fan) {
      const auto at = hn::ShiftLeft<2>(safe);
      const auto rect = [&](int n) HWY_ATTR {
        return hn::GatherIndex(di, t.fan->rect, hn::Add(at, hn::Set(di, n)));
      };
      good = hn::And(good, hn::And(hn::Lt(px, rect(2)), hn::Lt(py, rect(3))));
      good =
          hn::And(good, hn::And(hn::Gt(hn::Add(px, columns), rect(0)), hn::Gt(hn::Add(py, rows), rect(1))));
    }
    if (hn::AllFalse(di, good)) continue;
    if (t.open_sum) {
      // Pixels that are open in the window and around it, from the sums over the rectangles above and left of
      // its corners.
      const auto clamp = [&](hn::Vec<I> a, int size)
                             HWY_ATTR { return hn::Min(hn::Max(a, none), hn::Set(di, size)); };
      const auto around = hn::Set(di, t.around);
      auto x0 = hn::Sub(px, around), x1 = hn::Add(hn::Add(px, columns), around);
      auto y0 = hn::Sub(py, around), y1 = hn::Add(hn::Add(py, rows), around);
      if (t.fan) {
        const FanArgs& a = *t.fan;
        const FanWindow window(a, safe);
        window.pixels(a.per_x, a.foot_x, a.sample_foot_x, px, columns, x0, x1);
        window.pixels(a.per_y, a.foot_y, a.sample_foot_y, py, rows, y0, y1);
      }
      const int width = t.fan ? t.fan->width : t.width, height = t.fan ? t.fan->height : t.height;
      const auto pitch = hn::Set(di, width + 1);
      x0 = clamp(x0, width), x1 = clamp(x1, width);
      y0 = hn::Mul(clamp(y0, height), pitch), y1 = hn::Mul(clamp(y1, height), pitch);
      const auto sum = [&](hn::Vec<I> y, hn::Vec<I> x)
                           HWY_ATTR { return hn::GatherIndex(di, t.open_sum, hn::Add(y, x)); };
      const auto open = hn::Sub(hn::Sub(sum(y1, x1), sum(y1, x0)), hn::Sub(sum(y0, x1), sum(y0, x0)));
      const size_t before = hn::CountTrue(di, good);
      good = hn::And(good, hn::Gt(open, none));
      counts.occluded += before - hn::CountTrue(di, good);
      if (hn::AllFalse(di, good)) continue;
    }
    counts.accepted += hn::CountTrue(di, good);
    hn::StoreInterleaved4(hn::Sub(foot_x, start_x), hn::Sub(foot_y, start_y), hn::Sub(depth, whole),
                          hn::LoadU(d, t.coefficient + n), d, front);
    hn::StoreInterleaved4(px, py, hn::BitCast(di, lateral_x), hn::BitCast(di, lateral_y), di, back);
    hn::Store(
        hn::IfThenElse(good, hn::And(gap, hn::Set(di, static_cast<int32_t>(t.bin_mask))), hn::Set(di, trash)),
        di, bin);
    for (size_t l = 0; l < lanes; ++l) {
      SplatRecord*& end = t.bin_end[bin[l]];
      std::memcpy(&end->fx, front + 4 * l, 16);
      std::memcpy(&end->x, back + 4 * l, 16);
      ++end;
    }
  }
  return counts;
}

TransformCounts Transform(const TransformArgs& t) {
  return t.isotropic ? TransformPoints<true>(t) : TransformPoints<false>(t);
}

// Copies the sums of one lane out of groups of four and sets them to zero.
void Extract(const ExtractArgs& e) {
  const int lanes = static_cast<int>(hn::Lanes(d));
  alignas(64) uint32_t others[16];
  for (int l = 0; l < 16; ++l) others[l] = l % 4 == e.lane ? 0u : ~0u;
  const V keep = hn::BitCast(d, hn::Load(hn::RebindToUnsigned<D>(), others));
  const auto rows = [&](auto pick) HWY_ATTR {
    for (int y = 0; y < e.height; ++y) {
      float* from = e.ring + static_cast<std::ptrdiff_t>(y) * e.pitch * 4;
      float* to = e.plane + static_cast<std::ptrdiff_t>(y) * e.plane_pitch;
      for (int x = 0; x < e.width; x += lanes, from += 4 * lanes) {
        V v0, v1, v2, v3;
        hn::LoadInterleaved4(d, from, v0, v1, v2, v3);
        hn::StoreU(pick(v0, v1, v2, v3), d, to + x);
        for (int i = 0; i < 4; ++i)
          hn::StoreU(hn::And(hn::LoadU(d, from + i * lanes), keep), d, from + i * lanes);
      }
    }
  };
  switch (e.lane) {
  case 0:
    rows([](V v0, V, V, V) HWY_ATTR { return v0; });
    break;
  case 1:
    rows([](V, V v1, V, V) HWY_ATTR { return v1; });
    break;
  case 2:
    rows([](V, V, V v2, V) HWY_ATTR { return v2; });
    break;
  default:
    rows([](V, V, V, V v3) HWY_ATTR { return v3; });
    break;
  }
}

#endif
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {
HWY_EXPORT(Transform);
HWY_EXPORT(Extract);

const SplatLoops& simd_loops() {
  static constexpr SplatLoops loops{
      splat_points,
      [](const TransformArgs& t) { return HWY_DYNAMIC_DISPATCH(Transform)(t); },
      [](const ExtractArgs& e) {
        HWY_DYNAMIC_DISPATCH(Extract)
        (e);
      },
      raise_sheet,
      blend_planes,
  };
  return loops;
}

} // namespace bccsplat
#endif

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

#include "base/grid.h"
#include "splat/loop/loops.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR
// The reference loops stand in where there are no vectors.
TransformCounts Transform(const TransformArgs& t) { return reference_loops().transform(t); }
void Extract(const ExtractArgs& e) { reference_loops().extract(e); }
#else

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, 16>;
using V = hn::Vec<D>;
constexpr D d;

using I = hn::RebindToSigned<D>;
using VI = hn::Vec<I>;
using M = hn::Mask<I>;
constexpr I di;

// The local planes of a vector of points.
struct Planes {
  V x, y, z;
  HWY_INLINE explicit Planes(VI packed)
      : x(hn::ConvertTo(d, hn::And(packed, hn::Set(di, 15)))),
        y(hn::ConvertTo(d, hn::And(hn::ShiftRight<4>(packed), hn::Set(di, 15)))),
        z(hn::ConvertTo(d, hn::ShiftRight<8>(packed))) {}
  [[nodiscard]] HWY_INLINE V affine(const std::array<float, 4>& a) const {
    return hn::MulAdd(hn::Set(d, a[0]), x,
                      hn::MulAdd(hn::Set(d, a[1]), y, hn::MulAdd(hn::Set(d, a[2]), z, hn::Set(d, a[3]))));
  }
};

// Which points of a vector are in cells that are needed.
struct NeededCells {
  VI low, high; // bits of the cells 0 .. 31 and 32 .. 63
  HWY_INLINE explicit NeededCells(uint64_t cells)
      : low(hn::Set(di, static_cast<int32_t>(static_cast<uint32_t>(cells)))),
        high(hn::Set(di, static_cast<int32_t>(static_cast<uint32_t>(cells >> 32)))) {}
  [[nodiscard]] HWY_INLINE M of(VI packed) const {
    const auto cell = hn::Or(hn::Or(hn::And(hn::ShiftRight<2>(packed), hn::Set(di, 3)),
                                    hn::And(hn::ShiftRight<4>(packed), hn::Set(di, 12))),
                             hn::And(hn::ShiftRight<6>(packed), hn::Set(di, 48)));
    const auto word = hn::IfThenElse(hn::Lt(cell, hn::Set(di, 32)), low, high);
    const auto bit = hn::And(hn::Shr(word, hn::And(cell, hn::Set(di, 31))), hn::Set(di, 1));
    return hn::Gt(bit, hn::Zero(di));
  }
};

// The places of a vector of points on the sheets of their gaps.
struct Feet {
  V x, y, lateral_x, lateral_y, half_x, half_y;
  VI columns, rows;
};

template<bool kIsotropic>
HWY_INLINE Feet FindFeet(const GapTables& gaps, const BrickAxes& f, const Planes& planes, VI gap) {
  Feet feet;
  feet.x = planes.affine(f.di), feet.y = planes.affine(f.dj);
  if constexpr (kIsotropic) {
    feet.lateral_x = feet.lateral_y = hn::Zero(d);
    feet.half_x = hn::Set(d, gaps.half_x[0]), feet.half_y = hn::Set(d, gaps.half_y[0]);
    feet.columns = hn::Set(di, gaps.columns[0]), feet.rows = hn::Set(di, gaps.rows[0]);
  } else {
    const V shift = hn::Sub(hn::GatherIndex(d, gaps.lateral, gap), hn::Set(d, f.m));
    feet.lateral_x = planes.affine(f.dX), feet.lateral_y = planes.affine(f.dY);
    feet.x = hn::MulAdd(feet.lateral_x, shift, feet.x), feet.y = hn::MulAdd(feet.lateral_y, shift, feet.y);
    feet.half_x = hn::GatherIndex(d, gaps.half_x, gap), feet.half_y = hn::GatherIndex(d, gaps.half_y, gap);
    feet.columns = hn::GatherIndex(di, gaps.columns, gap), feet.rows = hn::GatherIndex(di, gaps.rows, gap);
  }
  return feet;
}

// The first pixel of a window, as a whole number.
HWY_INLINE V WindowStart(V foot, V half) {
  const V limit = hn::Set(d, 1e8f);
  return hn::Add(hn::Floor(hn::Min(hn::Max(hn::Sub(foot, half), hn::Neg(limit)), limit)), hn::Set(d, 1.0f));
}

// Windows of samples in the ring of a tile.
struct Windows {
  VI x, y, columns, rows;
  [[nodiscard]] HWY_INLINE M meet(VI x0, VI y0, VI x1, VI y1) const {
    return hn::And(hn::And(hn::Lt(x, x1), hn::Lt(y, y1)),
                   hn::And(hn::Gt(hn::Add(x, columns), x0), hn::Gt(hn::Add(y, rows), y0)));
  }
};

HWY_INLINE M MeetTile(const TileWindow& tile, const Windows& w, VI gap) {
  const auto none = hn::Zero(di);
  const auto in_ring = w.meet(none, none, hn::Set(di, tile.width), hn::Set(di, tile.height));
  if (!tile.fan) return in_ring;
  const auto at = hn::ShiftLeft<2>(gap);
  const auto rect = [&](int n)
                        HWY_ATTR { return hn::GatherIndex(di, tile.fan->rect, hn::Add(at, hn::Set(di, n))); };
  return hn::And(in_ring, w.meet(rect(0), rect(1), rect(2), rect(3)));
}

// The pixels of a tile that may look at windows of samples, see fan_window() in reference.cpp.
struct FanWindow {
  const FanArgs& fan;
  V near, far;
  HWY_INLINE FanWindow(const FanArgs& f, VI gap)
      : fan(f), near(hn::GatherIndex(d, f.inverse_near, gap)), far(hn::GatherIndex(d, f.inverse_far, gap)) {}
  HWY_INLINE void pixels(float per, float foot, int sample_foot, VI start, VI count, VI& begin,
                         VI& end) const {
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

// Returns how many pixels are open in the windows and around them, from the sums over the rectangles above
// and left of their corners.
HWY_INLINE VI CountOpen(const TileWindow& tile, const Windows& w, VI gap) {
  const auto around = hn::Set(di, tile.around);
  auto x0 = hn::Sub(w.x, around), x1 = hn::Add(hn::Add(w.x, w.columns), around);
  auto y0 = hn::Sub(w.y, around), y1 = hn::Add(hn::Add(w.y, w.rows), around);
  int width = tile.width, height = tile.height;
  if (tile.fan) {
    const FanArgs& a = *tile.fan;
    const FanWindow window(a, gap);
    window.pixels(a.per_x, a.foot_x, a.sample_foot_x, w.x, w.columns, x0, x1);
    window.pixels(a.per_y, a.foot_y, a.sample_foot_y, w.y, w.rows, y0, y1);
    width = a.width, height = a.height;
  }
  const auto clamp = [](VI a, int size)
                         HWY_ATTR { return hn::Min(hn::Max(a, hn::Zero(di)), hn::Set(di, size)); };
  const auto pitch = hn::Set(di, width + 1);
  x0 = clamp(x0, width), x1 = clamp(x1, width);
  y0 = hn::Mul(clamp(y0, height), pitch), y1 = hn::Mul(clamp(y1, height), pitch);
  const auto sum = [&](VI y, VI x) HWY_ATTR { return hn::GatherIndex(di, tile.open_sum, hn::Add(y, x)); };
  return hn::Sub(hn::Sub(sum(y1, x1), sum(y1, x0)), hn::Sub(sum(y0, x1), sum(y0, x0)));
}

template<bool kIsotropic> TransformCounts TransformPoints(const TransformArgs& t) {
  const hn::Rebind<uint16_t, D> d16;
  const size_t lanes = hn::Lanes(d);
  const BrickAxes& f = *t.axes;
  const auto base = hn::Set(di, static_cast<int32_t>(f.k - t.gaps.base));
  const auto first = hn::Set(di, static_cast<int32_t>(t.first_gap - t.gaps.base) - 1),
             last = hn::Set(di, static_cast<int32_t>(t.last_gap - t.gaps.base) + 1);
  const bool all_cells = t.cells == ~uint64_t{0};
  const NeededCells needed(t.cells);
  const auto bin_mask = hn::Set(di, static_cast<int32_t>(t.bin_mask)),
             trash = hn::Set(di, static_cast<int32_t>(t.bin_mask) + 1);
  alignas(64) float front[64];  // fx fy z c of each point
  alignas(64) int32_t back[64]; // x y X Y
  alignas(64) int32_t bin[16];
  TransformCounts counts;
  for (size_t n = 0; n < t.count; n += lanes) {
    // Points past the end are read as points of the next brick, or of the array's spare end, and rejected.
    const auto packed = hn::PromoteTo(di, hn::LoadU(d16, t.position + n));
    auto good = hn::Lt(hn::Iota(di, 0), hn::Set(di, static_cast<int32_t>(std::min(lanes, t.count - n))));
    if (!all_cells) {
      const size_t before = hn::CountTrue(di, good);
      good = hn::And(good, needed.of(packed));
      counts.invisible += before - hn::CountTrue(di, good);
      if (hn::AllFalse(di, good)) continue;
    }
    const Planes planes(packed);
    const V depth = planes.affine(f.dk), whole = hn::Floor(depth);
    const auto gap = hn::Add(hn::ConvertTo(di, whole), base);
    const auto within = hn::And(hn::Gt(gap, first), hn::Lt(gap, last));
    const auto safe = hn::IfThenElse(within, gap, hn::Sub(last, hn::Set(di, 1)));
    const Feet feet = FindFeet<kIsotropic>(t.gaps, f, planes, safe);
    const V start_x = WindowStart(feet.x, feet.half_x), start_y = WindowStart(feet.y, feet.half_y);
    const Windows window{hn::Add(hn::ConvertTo(di, start_x), hn::Set(di, f.i - t.tile.x)),
                         hn::Add(hn::ConvertTo(di, start_y), hn::Set(di, f.j - t.tile.y)), feet.columns,
                         feet.rows};
    good = hn::And(hn::And(good, within), MeetTile(t.tile, window, safe));
    if (hn::AllFalse(di, good)) continue;
    if (t.tile.open_sum) {
      const size_t before = hn::CountTrue(di, good);
      good = hn::And(good, hn::Gt(CountOpen(t.tile, window, safe), hn::Zero(di)));
      counts.occluded += before - hn::CountTrue(di, good);
      if (hn::AllFalse(di, good)) continue;
    }
    counts.accepted += hn::CountTrue(di, good);
    hn::StoreInterleaved4(hn::Sub(feet.x, start_x), hn::Sub(feet.y, start_y), hn::Sub(depth, whole),
                          hn::LoadU(d, t.coefficient + n), d, front);
    hn::StoreInterleaved4(window.x, window.y, hn::BitCast(di, feet.lateral_x),
                          hn::BitCast(di, feet.lateral_y), di, back);
    hn::Store(hn::IfThenElse(good, hn::And(gap, bin_mask), trash), di, bin);
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
      float* from = e.ring + plane_offset(0, y, e.pitch) * 4;
      float* to = e.plane + plane_offset(0, y, e.plane_pitch);
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

} // namespace
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

// SPDX-License-Identifier: Apache-2.0
// The loops of matter.h through Highway: one body is compiled for every target, and the best is chosen at run
// time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/sheet/matter_simd.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include "splat/sheet/matter.h"
#include "splat/sheet/sheet_classify-inl.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR
// The reference loops stand in where there are no vectors.
void Absorb(const SheetArgs& s, float weight, const MatterPlanes& out) {
  reference_matter_loops().absorb(s, weight, out);
}
int Join(const JoinArgs& j) { return reference_matter_loops().join(j); }
std::array<float, 2> Mix(const MixArgs& m) { return reference_matter_loops().mix(m); }
#else

// Replaces the colours where they are from elsewhere.
HWY_INLINE void Paint(const Pixels& px, V& red, V& green, V& blue) {
  const SheetPaint& paint = px.s.paint;
  if (paint.red) red = px.load(paint.red), green = px.load(paint.green), blue = px.load(paint.blue);
}

template<class Shade>
void AbsorbWith(const SheetArgs& s, float share, const MatterPlanes& out, const Shade& shade) {
  const ClassTable& table = *s.classes.table;
  const V low = Set(table.low), scale = Set(table.scale), top = Set(static_cast<float>(table.size() - 1));
  const auto first = hn::Set(di, table.first_visible - 1), last = hn::Set(di, table.last_visible + 1);
  const V stop = Set(s.classes.stop);
  const int lanes = static_cast<int>(hn::Lanes(d));
  const PixelRect seen = s.tile.seen.within(s.tile.width, s.tile.height);
  for (int y = seen.y0; y < seen.y1; ++y)
    for (int x = seen.x0 & -lanes; x < seen.x1; x += lanes) {
      const Pixels px{s, x, y, s.tile.pixel(x, y), s.tile.sample(x, y)};
      const V value = s.paint.value ? px.load(s.paint.value) : px.value();
      const auto index =
          hn::NearestInt(hn::Min(hn::Max(hn::Mul(hn::Sub(value, low), scale), hn::Zero(d)), top));
      const M visible = hn::RebindMask(d, hn::And(hn::Gt(index, first), hn::Lt(index, last)));
      if (hn::AllFalse(d, visible)) continue;
      const V weight = px.weight();
      M active = hn::And(hn::And(visible, hn::Lt(px.load(s.pixel.alpha), stop)), hn::Gt(weight, hn::Zero(d)));
      if (s.hole) active = hn::And(active, px.solid());
      if (hn::AllFalse(d, active)) continue;
      V red, green, blue, extinction;
      LookUp(table.entry.data(), index, red, green, blue, extinction);
      Paint(px, red, green, blue);
      const V path = hn::Mul(hn::Mul(Set(share), weight), px.load(s.pixel.path));
      const V depth = hn::IfThenElseZero(active, hn::Mul(extinction, path));
      const V open = hn::Sub(Set(1.0f), px.load(s.pixel.alpha));
      // No segment absorbs more than its depth.
      if (s.differences.halves && LitInHalves(hn::Mul(open, depth))) {
        const V part = Absorbed(depth);
        shade.halves(px, {hn::Mul(open, part), FrontShare(part)}, red, green, blue);
      } else {
        shade(px, red, green, blue);
      }
      const auto add = [&](float* plane, V part) HWY_ATTR {
        hn::StoreU(hn::MulAdd(depth, part, hn::LoadU(d, plane + px.p)), d, plane + px.p);
      };
      add(out.red, red), add(out.green, green), add(out.blue, blue);
      hn::StoreU(hn::Add(hn::LoadU(d, out.depth + px.p), depth), d, out.depth + px.p);
      if (out.value) add(out.value, value);
      if (out.time) add(out.time, px.time());
    }
}

// The same by the table's integrals.
template<class Shade>
void AbsorbIntegrals(const SheetArgs& s, float share, const MatterPlanes& out, const Shade& shade) {
  const ByIntegrals classify(*s.classes.table, out.value != nullptr, share);
  const V stop = Set(s.classes.stop);
  const int lanes = static_cast<int>(hn::Lanes(d));
  const PixelRect seen = s.tile.seen.within(s.tile.width, s.tile.height);
  for (int y = seen.y0; y < seen.y1; ++y)
    for (int x = seen.x0 & -lanes; x < seen.x1; x += lanes) {
      const Pixels px{s, x, y, s.tile.pixel(x, y), s.tile.sample(x, y)};
      Extent extent;
      SegmentColor segment;
      M active;
      classify.begin();
      if (!classify(s, px, px.load(s.pixel.alpha), px.load(s.pixel.enter), px.load(s.pixel.leave), stop,
                    extent, segment, active))
        continue;
      Paint(px, segment.red, segment.green, segment.blue);
      const V depth = hn::IfThenElseZero(active, segment.depth);
      const V open = hn::Sub(Set(1.0f), px.load(s.pixel.alpha));
      const V added = hn::IfThenElseZero(active, hn::Mul(open, segment.absorbed));
      if (s.differences.halves && LitInHalves(added))
        shade.halves(px, {added, segment.front}, segment.red, segment.green, segment.blue);
      else
        shade(px, segment.red, segment.green, segment.blue);
      const auto add = [&](float* plane, V part) HWY_ATTR {
        hn::StoreU(hn::MulAdd(depth, part, hn::LoadU(d, plane + px.p)), d, plane + px.p);
      };
      add(out.red, segment.red), add(out.green, segment.green), add(out.blue, segment.blue);
      hn::StoreU(hn::Add(hn::LoadU(d, out.depth + px.p), depth), d, out.depth + px.p);
      if (out.value) add(out.value, segment.value);
      if (out.time) add(out.time, px.time());
    }
}

void Absorb(const SheetArgs& s, float share, const MatterPlanes& out) {
  WithLight(s, [&](const auto& shade) {
    if (s.halves.preintegrated)
      AbsorbIntegrals(s, share, out, shade);
    else
      AbsorbWith(s, share, out, shade);
  });
}

int Join(const JoinArgs& j) {
  const V one = Set(1.0f), half = Set(0.5f), stop = Set(j.stop), zero = hn::Zero(d), tiny = Set(1e-30f);
  const V depth_at = Set(j.depth_at), passes = hn::Max(Set(1 - j.depth_at), tiny);
  const MatterPlanes *const slice = j.group[0], *const trail = j.group[1];
  const int lanes = static_cast<int>(hn::Lanes(d));
  int closed = 0;
  for (int y = 0; y < j.height; ++y)
    for (int x = 0; x < j.width; x += lanes) {
      const size_t p = plane_index(x, y, j.pitch);
      const V before = hn::LoadU(d, j.pixel.alpha + p);
      const V a = slice ? hn::LoadU(d, slice->depth + p) : zero;
      const V b = trail ? hn::LoadU(d, trail->depth + p) : zero;
      const M active = hn::And(hn::Lt(before, stop), hn::Gt(hn::Add(a, b), zero));
      if (hn::AllFalse(d, active)) continue;
      const V open = hn::IfThenElseZero(active, hn::Sub(one, before));
      V fa, fb; // per optical depth
      if (j.combine == TrailCombine::interleaved) {
        const auto part = [&](V depth) HWY_ATTR {
          return hn::Mul(open, hn::Div(hn::Mul(half, Absorbed(depth)), hn::Max(depth, tiny)));
        };
        fa = part(a), fb = part(b);
      } else {
        const V sum = hn::Add(a, b);
        fa = fb = hn::Mul(open, hn::Div(Absorbed(sum), hn::Max(sum, tiny)));
      }
      const auto add = [&](float* out, float* MatterPlanes::*plane) HWY_ATTR {
        if (!out) return;
        V sum = hn::LoadU(d, out + p);
        if (slice) sum = hn::MulAdd(fa, hn::LoadU(d, slice->*plane + p), sum);
        if (trail) sum = hn::MulAdd(fb, hn::LoadU(d, trail->*plane + p), sum);
        hn::StoreU(sum, d, out + p);
      };
      add(j.pixel.red, &MatterPlanes::red), add(j.pixel.green, &MatterPlanes::green);
      add(j.pixel.blue, &MatterPlanes::blue);
      add(j.pixel.value, &MatterPlanes::value), add(j.pixel.time, &MatterPlanes::time);
      const V after = hn::Add(before, hn::MulAdd(fa, a, hn::Mul(fb, b)));
      hn::StoreU(after, d, j.pixel.alpha + p);
      const M passed = hn::And(hn::Lt(before, depth_at), hn::Ge(after, depth_at));
      if (!hn::AllFalse(d, passed)) {
        // The transmittance falls exponentially through the segment, as in Composite.
        const V begin = hn::Max(Set(j.k - j.front), hn::LoadU(d, j.pixel.enter + p));
        const V end = hn::Min(Set(j.k + 0.5f), hn::LoadU(d, j.pixel.leave + p));
        const V left = hn::Max(hn::Sub(one, before), tiny);
        const V all = hn::Log(d, hn::Max(hn::Div(hn::Sub(one, after), left), tiny));
        const V part = hn::Div(hn::Log(d, hn::Div(passes, left)), hn::Min(all, Set(-1e-20f)));
        const V depth = hn::MulAdd(hn::IfThenElseZero(hn::Lt(after, one), part),
                                   hn::Max(hn::Sub(end, begin), zero), begin);
        hn::StoreU(hn::IfThenElse(passed, depth, hn::LoadU(d, j.pixel.depth + p)), d, j.pixel.depth + p);
      }
      closed += static_cast<int>(hn::CountTrue(d, hn::And(active, hn::Ge(after, stop))));
    }
  return closed;
}

// Mixes `kVectors` vectors side by side.
template<int kVectors> HWY_INLINE void MixVectors(const MixArgs& m, std::ptrdiff_t at, V& low, V& high) {
  const std::ptrdiff_t lanes = hn::Lanes(d);
  V sum[kVectors];
  for (V& s : sum) s = hn::Zero(d);
  for (size_t i = 0; i < m.plane.size(); ++i) {
    const V weight = Set(m.weight[i]);
    const float* const from = m.plane[i] + at;
    for (int n = 0; n < kVectors; ++n) sum[n] = hn::MulAdd(weight, hn::LoadU(d, from + n * lanes), sum[n]);
  }
  for (int n = 0; n < kVectors; ++n) {
    hn::StoreU(sum[n], d, m.out + at + n * lanes);
    low = hn::Min(low, sum[n]), high = hn::Max(high, sum[n]);
  }
}

std::array<float, 2> Mix(const MixArgs& m) {
  constexpr int most = 4; // vectors at once: weights are read once for all of them
  const int lanes = static_cast<int>(hn::Lanes(d));
  V low = hn::Zero(d), high = low;
  for (int y = 0; y < m.height; ++y) {
    const std::ptrdiff_t row = plane_offset(0, y, m.pitch);
    int x = 0;
    for (; x + (most - 1) * lanes < m.width; x += most * lanes) MixVectors<most>(m, row + x, low, high);
    for (; x < m.width; x += lanes) MixVectors<1>(m, row + x, low, high);
  }
  return {hn::GetLane(hn::MinOfLanes(d, low)), hn::GetLane(hn::MaxOfLanes(d, high))};
}

#endif

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {
HWY_EXPORT(Absorb);
HWY_EXPORT(Join);
HWY_EXPORT(Mix);

const MatterLoops& simd_matter_loops() {
  static constexpr MatterLoops loops{
      [](const SheetArgs& s, float weight, const MatterPlanes& out) {
        HWY_DYNAMIC_DISPATCH(Absorb)(s, weight, out);
      },
      [](const JoinArgs& j) { return HWY_DYNAMIC_DISPATCH(Join)(j); },
      [](const MixArgs& m) { return HWY_DYNAMIC_DISPATCH(Mix)(m); },
  };
  return loops;
}

} // namespace bccsplat
#endif

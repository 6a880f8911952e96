// SPDX-License-Identifier: Apache-2.0
// The loops of sheet.h through Highway: one body is compiled for every target, and the best is chosen at run
// time. Pixels and light are in sheet_pixels-inl.h, classification in sheet_classify-inl.h.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/sheet/sheet_simd.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include "splat/sheet/sheet_classify-inl.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR
// The reference loops stand in where there are no vectors.
int Composite(std::span<const SheetArgs> sheets) { return reference_sheet_loops().composite(sheets); }
void Integrate(const SheetArgs& s) { reference_sheet_loops().integrate(s); }
void Maximum(const SheetArgs& s) { reference_sheet_loops().maximum(s); }
size_t Crossings(const CrossingArgs& c) { return reference_sheet_loops().crossings(c); }
#else

template<class Classify, class Shade>
int CompositeWith(std::span<const SheetArgs> sheets, const Classify& classify, const Shade& shade) {
  const SheetArgs& front = sheets.front();
  const PixelPlanes& plane = front.pixel;
  const V one = Set(1.0f), stop = Set(front.classes.stop), none = hn::Zero(d);
  const V depth_at = Set(front.classes.depth_at), passes = Set(1 - front.classes.depth_at);
  const V begins = Set(front.segment.begin()), ends = Set(sheets.back().segment.end());
  const int lanes = static_cast<int>(hn::Lanes(d));
  PixelRect seen;
  for (const SheetArgs& s : sheets) seen.include(s.tile.seen);
  seen = seen.within(front.tile.width, front.tile.height);
  int closed = 0;
  for (int y = seen.y0; y < seen.y1; ++y)
    for (int x = seen.x0 & -lanes; x < seen.x1; x += lanes) {
      const size_t p = front.tile.pixel(x, y);
      const std::ptrdiff_t at = front.tile.sample(x, y);
      V alpha = hn::LoadU(d, plane.alpha + p);
      const V enter = hn::LoadU(d, plane.enter + p), leave = hn::LoadU(d, plane.leave + p);
      // Nothing happens where pixels are finished or their rays miss all of the sheets.
      if (hn::AllFalse(d, hn::And(hn::Lt(alpha, stop), hn::And(hn::Gt(leave, begins), hn::Lt(enter, ends)))))
        continue;
      V sum_r = none, sum_g = none, sum_b = none;
      bool touched = false;
      classify.begin();
      for (const SheetArgs& s : sheets) {
        const Pixels px{s, x, y, p, at};
        Extent extent;
        SegmentColor segment;
        M active;
        if (!classify(s, px, alpha, enter, leave, stop, extent, segment, active)) continue;
        if (!touched) {
          touched = true;
          sum_r = hn::LoadU(d, plane.red + p), sum_g = hn::LoadU(d, plane.green + p),
          sum_b = hn::LoadU(d, plane.blue + p);
        }
        const V f = hn::IfThenElseZero(active, hn::Mul(hn::Sub(one, alpha), segment.absorbed));
        if (s.differences.halves && LitInHalves(f))
          shade.halves(px, {f, classify.front_share(segment)}, segment.red, segment.green, segment.blue);
        else
          shade(px, segment.red, segment.green, segment.blue);
        sum_r = hn::MulAdd(f, segment.red, sum_r), sum_g = hn::MulAdd(f, segment.green, sum_g),
        sum_b = hn::MulAdd(f, segment.blue, sum_b);
        const V before = alpha;
        alpha = hn::Add(before, f);
        const auto add = [&](float* to, V part)
                             HWY_ATTR { hn::StoreU(hn::MulAdd(f, part, hn::LoadU(d, to + p)), d, to + p); };
        if (plane.value) add(plane.value, segment.value);
        if (plane.time) add(plane.time, px.time());
        const M passed = hn::And(hn::Lt(before, depth_at), hn::Ge(alpha, depth_at));
        if (!hn::AllFalse(d, passed)) {
          // The transmittance falls exponentially through the part of the segment inside the domain.
          const Passage in = classify.passage(extent, before, alpha, depth_at);
          const V tiny = Set(1e-30f), left = hn::Max(hn::Sub(one, in.before), tiny);
          const V all = hn::Log(d, hn::Max(hn::Div(hn::Sub(one, in.after), left), tiny));
          const V part =
              hn::Div(hn::Log(d, hn::Div(hn::Max(passes, tiny), left)), hn::Min(all, Set(-1e-20f)));
          const V depth = hn::MulAdd(hn::IfThenElseZero(hn::Lt(in.after, one), part), in.weight, in.begin);
          hn::StoreU(hn::IfThenElse(passed, depth, hn::LoadU(d, plane.depth + p)), d, plane.depth + p);
        }
        closed += static_cast<int>(hn::CountTrue(d, hn::And(active, hn::Ge(alpha, stop))));
      }
      if (!touched) continue;
      hn::StoreU(sum_r, d, plane.red + p), hn::StoreU(sum_g, d, plane.green + p),
          hn::StoreU(sum_b, d, plane.blue + p), hn::StoreU(alpha, d, plane.alpha + p);
    }
  return closed;
}

template<class Classify> int CompositeBy(std::span<const SheetArgs> sheets, const Classify& classify) {
  return WithLight(sheets.front(), [&](const auto& shade) { return CompositeWith(sheets, classify, shade); });
}

int Composite(std::span<const SheetArgs> sheets) {
  const SheetArgs& front = sheets.front();
  if (!front.halves.preintegrated) return CompositeBy(sheets, ByEntry(*front.classes.table));
  return CompositeBy(sheets, ByIntegrals(*front.classes.table, front.pixel.value != nullptr));
}

void Integrate(const SheetArgs& s) {
  ForPixels(s, [&](const Pixels& px) HWY_ATTR {
    // Beside the tile and outside the domain the weight is 0, and the planes may hold anything finite.
    const V weight = hn::IfThenElseZero(px.solid(), px.weight());
    const V value = hn::Add(Set(s.field.above_air), hn::LoadU(d, s.field.value + px.at));
    const V part = hn::Mul(hn::Mul(value, weight), px.load(s.pixel.path));
    hn::StoreU(hn::Add(px.load(s.pixel.red), part), d, s.pixel.red + px.p);
    if (!s.pixel.time) return;
    const V size = hn::Abs(part);
    hn::StoreU(hn::Add(px.load(s.pixel.alpha), size), d, s.pixel.alpha + px.p);
    hn::StoreU(hn::MulAdd(size, px.time(), px.load(s.pixel.time)), d, s.pixel.time + px.p);
  });
}

void Maximum(const SheetArgs& s) {
  ForPixels(s, [&](const Pixels& px) HWY_ATTR {
    const V value = px.value(), before = px.load(s.pixel.red);
    const M larger = hn::And(hn::And(px.solid(), hn::Gt(px.weight(), hn::Zero(d))), hn::Gt(value, before));
    if (hn::AllFalse(d, larger)) return;
    hn::StoreU(hn::IfThenElse(larger, value, before), d, s.pixel.red + px.p);
    hn::StoreU(hn::IfThenElse(larger, Set(s.segment.k), px.load(s.pixel.depth)), d, s.pixel.depth + px.p);
  });
}

size_t Crossings(const CrossingArgs& c) {
  const int lanes = static_cast<int>(hn::Lanes(d));
  const V target = Set(c.target), stop = Set(c.stop), one = Set(1.0f), half = Set(0.5f), zero = hn::Zero(d);
  const V first = Set(c.k - 1), last = Set(c.k + static_cast<float>(c.count - 1));
  size_t count = 0;
  uint8_t crossed[CrossingArgs::most][8] = {}, grazed[CrossingArgs::most][8] = {}; // one bit per lane
  const PixelRect seen = c.seen.within(c.width, c.height);
  for (int y = seen.y0; y < seen.y1; ++y)
    for (int x = seen.x0 & -lanes; x < seen.x1; x += lanes) {
      const std::ptrdiff_t at = plane_offset(x, y, c.plane_pitch);
      const size_t p = plane_index(x, y, c.pitch);
      const V enter = hn::LoadU(d, c.enter + p), leave = hn::LoadU(d, c.leave + p);
      const M open = hn::And(hn::Lt(hn::LoadU(d, c.alpha + p), stop),
                             hn::And(hn::Le(enter, last), hn::Le(first, leave)));
      if (hn::AllFalse(d, open)) continue;
      V low = hn::LoadU(d, c.plane[0] + at), high = low;
      for (size_t n = 1; n < static_cast<size_t>(c.count) + 3; ++n) {
        const V v = hn::LoadU(d, c.plane[n] + at);
        low = hn::Min(low, v), high = hn::Max(high, v);
      }
      // Tangents meet no farther beyond the values than half of their range.
      const V beyond = hn::Mul(half, hn::Sub(high, low));
      if (hn::AllFalse(d, hn::And(open, hn::And(hn::Le(hn::Sub(low, beyond), target),
                                                hn::Ge(hn::Add(high, beyond), target)))))
        continue;
      bool any = false;
      for (int n = 0; n < c.count; ++n) {
        const auto value = [&](int sheet) HWY_ATTR { return hn::LoadU(d, c.plane[n + sheet] + at); };
        const V v0 = value(1), v1 = value(2);
        V d0 = hn::Sub(v0, target), d1 = hn::Sub(v1, target);
        const M below = hn::Lt(d0, zero);
        const M cross = hn::Xor(below, hn::Lt(d1, zero));
        // The test is that of may_graze() in sheet.cpp.
        const V side = hn::IfThenElse(below, one, hn::Neg(one));
        const V s0 = hn::Mul(side, hn::Mul(half, hn::Sub(v1, value(0))));
        const V s1 = hn::Mul(side, hn::Mul(half, hn::Sub(value(3), v0)));
        d0 = hn::Mul(side, d0), d1 = hn::Mul(side, d1);
        const V meet = hn::Sub(hn::Sub(d1, d0), s1), over = hn::Sub(s0, s1);
        M graze = hn::And(hn::And(hn::Gt(s0, zero), hn::Lt(s1, zero)),
                          hn::And(hn::Gt(meet, zero), hn::Lt(meet, over)));
        graze = hn::And(graze, hn::Ge(hn::Add(hn::Mul(d0, over), hn::Mul(s0, meet)), zero));
        graze = hn::AndNot(cross, graze);
        const float k = c.k + static_cast<float>(n);
        const M inside = hn::And(hn::Le(enter, Set(k)), hn::Le(Set(k - 1), leave));
        const M found = hn::And(hn::And(open, inside), hn::Or(cross, graze));
        any |= !hn::AllFalse(d, found);
        hn::StoreMaskBits(d, found, crossed[n]);
        hn::StoreMaskBits(d, graze, grazed[n]);
      }
      if (!any) continue;
      for (int l = 0; l < std::min(lanes, c.width - x); ++l)
        for (int n = 0; n < c.count; ++n)
          if (crossed[n][l / 8] >> (l % 8) & 1)
            c.found[count++] = {static_cast<uint16_t>(x + l), static_cast<uint16_t>(y),
                                static_cast<uint8_t>(n), (grazed[n][l / 8] >> (l % 8) & 1) != 0};
    }
  return count;
}

#endif

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {
HWY_EXPORT(Composite);
HWY_EXPORT(Integrate);
HWY_EXPORT(Maximum);
HWY_EXPORT(Crossings);

const SheetLoops& simd_sheet_loops() {
  static constexpr SheetLoops loops{
      [](std::span<const SheetArgs> sheets) { return HWY_DYNAMIC_DISPATCH(Composite)(sheets); },
      [](const SheetArgs& s) { return HWY_DYNAMIC_DISPATCH(Integrate)(s); },
      [](const CrossingArgs& c) { return HWY_DYNAMIC_DISPATCH(Crossings)(c); },
      [](const SheetArgs& s) { return HWY_DYNAMIC_DISPATCH(Maximum)(s); },
  };
  return loops;
}

} // namespace bccsplat
#endif

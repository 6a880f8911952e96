// The sheets of sheet.h through Highway: one body, compiled for every target, the best chosen at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/sheet_simd.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include "splat/sheet_pixels-inl.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR
// No vectors: the plain loops.
int Composite(std::span<const SheetArgs> sheets) { return scalar_sheet_kernels().composite(sheets); }
void Integrate(const SheetArgs& s) { scalar_sheet_kernels().integrate(s); }
void Maximum(const SheetArgs& s) { scalar_sheet_kernels().maximum(s); }
size_t Crossings(const CrossingArgs& c) { return scalar_sheet_kernels().crossings(c); }
#else

template<class Shade> int CompositeWith(std::span<const SheetArgs> sheets, const Shade& shade) {
  const SheetArgs& front = sheets.front();
  const ClassTable& table = *front.table;
  const PixelPlanes& plane = front.pixel;
  const V low = set(table.low), scale = set(table.scale), top = set(static_cast<float>(table.size() - 1));
  const auto first = hn::Set(di, table.first_visible - 1), last = hn::Set(di, table.last_visible + 1);
  const V one = set(1.0f), half = set(0.5f), stop = set(front.stop), none = hn::Zero(d);
  const V begins = set(front.k - front.front), ends = set(sheets.back().k + 0.5f);
  const M none_of = hn::Lt(one, one);
  const int lanes = static_cast<int>(hn::Lanes(d));
  PixelRect seen;
  for (const SheetArgs& s : sheets) seen.include(s.seen);
  seen = seen.within(front.width, front.height);
  int closed = 0;
  for (int y = seen.y0; y < seen.y1; ++y)
    for (int x = seen.x0 & -lanes; x < seen.x1; x += lanes) {
      const size_t p = static_cast<size_t>(y) * static_cast<size_t>(front.pitch) + static_cast<size_t>(x);
      const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(y) * front.plane_pitch + x;
      V alpha = hn::LoadU(d, plane.alpha + p);
      const V enter = hn::LoadU(d, plane.enter + p), leave = hn::LoadU(d, plane.leave + p);
      // Pixels that are finished, or whose rays miss all of the sheets.
      if (hn::AllFalse(d, hn::And(hn::Lt(alpha, stop), hn::And(hn::Gt(leave, begins), hn::Lt(enter, ends)))))
        continue;
      V sum_r = none, sum_g = none, sum_b = none;
      bool touched = false;
      for (const SheetArgs& s : sheets) {
        const Pixels px{s, x, y, p, at};
        const V value = px.value();
        const auto index = hn::NearestInt(hn::Min(hn::Max(hn::Mul(hn::Sub(value, low), scale), none), top));
        const M visible = hn::RebindMask(d, hn::And(hn::Gt(index, first), hn::Lt(index, last)));
        const V begin = hn::Max(set(s.k - s.front), enter);
        const V weight = hn::Max(hn::Sub(hn::Min(set(s.k + 0.5f), leave), begin), none);
        M active = hn::And(hn::And(visible, hn::Lt(alpha, stop)), hn::Gt(weight, none));
        if (s.hole) active = hn::And(active, px.solid());
        if (hn::AllFalse(d, active)) continue;
        if (!touched) {
          touched = true;
          sum_r = hn::LoadU(d, plane.red + p), sum_g = hn::LoadU(d, plane.green + p),
          sum_b = hn::LoadU(d, plane.blue + p);
        }
        V red, green, blue, absorbed;
        const M whole = s.whole ? hn::And(active, hn::Eq(weight, one)) : none_of;
        if (!hn::AllFalse(d, whole)) LookUp(s.whole, index, red, green, blue, absorbed);
        const M partial = hn::AndNot(whole, active);
        if (!hn::AllFalse(d, partial)) {
          V extinction;
          LookUp(table.entry.data(), index, red, green, blue, extinction);
          const V part = Absorbed(hn::Mul(hn::Mul(extinction, weight), hn::LoadU(d, plane.path + p)));
          absorbed = hn::AllFalse(d, whole) ? part : hn::IfThenElse(whole, absorbed, part);
        }
        const V f = hn::IfThenElseZero(active, hn::Mul(hn::Sub(one, alpha), absorbed));
        shade(px, red, green, blue);
        sum_r = hn::MulAdd(f, red, sum_r), sum_g = hn::MulAdd(f, green, sum_g),
        sum_b = hn::MulAdd(f, blue, sum_b);
        const V before = alpha;
        alpha = hn::Add(before, f);
        const auto add = [&](float* to, V part)
                             HWY_ATTR { hn::StoreU(hn::MulAdd(f, part, hn::LoadU(d, to + p)), d, to + p); };
        if (plane.value) add(plane.value, value);
        if (plane.time) add(plane.time, px.time());
        const M passed = hn::And(hn::Lt(before, half), hn::Ge(alpha, half));
        if (!hn::AllFalse(d, passed)) {
          // The transmittance falls exponentially through the part of the slab inside the domain.
          const V tiny = set(1e-30f), left = hn::Max(hn::Sub(one, before), tiny);
          const V all = hn::Log(d, hn::Max(hn::Div(hn::Sub(one, alpha), left), tiny));
          const V part = hn::Div(hn::Log(d, hn::Div(half, left)), hn::Min(all, set(-1e-20f)));
          const V depth = hn::MulAdd(hn::IfThenElseZero(hn::Lt(alpha, one), part), weight, begin);
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

int Composite(std::span<const SheetArgs> sheets) {
  const SheetArgs& front = sheets.front();
  if (!front.shading) return CompositeWith(sheets, [](const Pixels&, V&, V&, V&) HWY_ATTR {});
  if (!AlikeLights::fits(front))
    return CompositeWith(sheets, [](const Pixels& px, V& red, V& green, V& blue)
                                     HWY_ATTR { px.light(red, green, blue); });
  const AlikeLights lights(front);
  return CompositeWith(sheets, [&](const Pixels& px, V& red, V& green, V& blue)
                                   HWY_ATTR { lights.shade(px, red, green, blue); });
}

void Integrate(const SheetArgs& s) {
  for_pixels(s, [&](const Pixels& px) HWY_ATTR {
    // Beside the tile and outside the domain the weight is 0 but the planes may hold anything finite.
    const V weight = hn::IfThenElseZero(px.solid(), px.weight());
    const V part = hn::Mul(hn::Mul(hn::LoadU(d, s.value + px.at), weight), px.load(s.pixel.path));
    hn::StoreU(hn::Add(px.load(s.pixel.red), part), d, s.pixel.red + px.p);
    if (!s.pixel.time) return;
    const V size = hn::Abs(part);
    hn::StoreU(hn::Add(px.load(s.pixel.alpha), size), d, s.pixel.alpha + px.p);
    hn::StoreU(hn::MulAdd(size, px.time(), px.load(s.pixel.time)), d, s.pixel.time + px.p);
  });
}

void Maximum(const SheetArgs& s) {
  for_pixels(s, [&](const Pixels& px) HWY_ATTR {
    const V value = px.value(), before = px.load(s.pixel.red);
    const M larger = hn::And(hn::And(px.solid(), hn::Gt(px.weight(), hn::Zero(d))), hn::Gt(value, before));
    if (hn::AllFalse(d, larger)) return;
    hn::StoreU(hn::IfThenElse(larger, value, before), d, s.pixel.red + px.p);
    hn::StoreU(hn::IfThenElse(larger, set(s.k), px.load(s.pixel.depth)), d, s.pixel.depth + px.p);
  });
}

size_t Crossings(const CrossingArgs& c) {
  const int lanes = static_cast<int>(hn::Lanes(d));
  const V target = set(c.target), k = set(c.k), before = set(c.k - 1), one = set(1.0f), half = set(0.5f);
  const V zero = hn::Zero(d);
  size_t count = 0;
  uint8_t crossed[8], grazed[8]; // one bit per lane
  const PixelRect seen = c.seen.within(c.width, c.height);
  for (int y = seen.y0; y < seen.y1; ++y)
    for (int x = seen.x0 & -lanes; x < seen.x1; x += lanes) {
      const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(y) * c.plane_pitch + x;
      const size_t p = static_cast<size_t>(y) * static_cast<size_t>(c.pitch) + static_cast<size_t>(x);
      const V v0 = hn::LoadU(d, c.before + at), v1 = hn::LoadU(d, c.value + at);
      V d0 = hn::Sub(v0, target), d1 = hn::Sub(v1, target);
      const M below = hn::Lt(d0, zero);
      const M cross = hn::Xor(below, hn::Lt(d1, zero));
      // As may_graze.
      const V side = hn::IfThenElse(below, one, hn::Neg(one));
      const V s0 = hn::Mul(side, hn::Mul(half, hn::Sub(v1, hn::LoadU(d, c.before2 + at))));
      const V s1 = hn::Mul(side, hn::Mul(half, hn::Sub(hn::LoadU(d, c.after + at), v0)));
      d0 = hn::Mul(side, d0), d1 = hn::Mul(side, d1);
      const V meet = hn::Sub(hn::Sub(d1, d0), s1), over = hn::Sub(s0, s1);
      M graze = hn::And(hn::And(hn::Gt(s0, zero), hn::Lt(s1, zero)),
                        hn::And(hn::Gt(meet, zero), hn::Lt(meet, over)));
      graze = hn::And(graze, hn::Ge(hn::Add(hn::Mul(d0, over), hn::Mul(s0, meet)), zero));
      graze = hn::AndNot(cross, graze);
      M open = hn::Or(cross, graze);
      if (hn::AllFalse(d, open)) continue;
      open = hn::And(open, hn::Lt(hn::LoadU(d, c.alpha + p), one));
      open = hn::And(
          open, hn::And(hn::Le(hn::LoadU(d, c.enter + p), k), hn::Le(before, hn::LoadU(d, c.leave + p))));
      hn::StoreMaskBits(d, open, crossed);
      hn::StoreMaskBits(d, graze, grazed);
      for (int l = 0; l < std::min(lanes, c.width - x); ++l)
        if (crossed[l / 8] >> (l % 8) & 1)
          c.found[count++] = static_cast<uint32_t>(y) << 16 | static_cast<uint32_t>(x + l) |
                             (grazed[l / 8] >> (l % 8) & 1 ? grazing : 0);
    }
  return count;
}

#endif
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {
HWY_EXPORT(Composite);
HWY_EXPORT(Integrate);
HWY_EXPORT(Maximum);
HWY_EXPORT(Crossings);

const SheetKernels& simd_sheet_kernels() {
  static constexpr SheetKernels kernels{
      [](std::span<const SheetArgs> sheets) { return HWY_DYNAMIC_DISPATCH(Composite)(sheets); },
      [](const SheetArgs& s) { return HWY_DYNAMIC_DISPATCH(Integrate)(s); },
      [](const CrossingArgs& c) { return HWY_DYNAMIC_DISPATCH(Crossings)(c); },
      [](const SheetArgs& s) { return HWY_DYNAMIC_DISPATCH(Maximum)(s); },
  };
  return kernels;
}

} // namespace bccsplat
#endif

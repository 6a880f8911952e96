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
int Composite(const SheetArgs& s) { return scalar_sheet_kernels().composite(s); }
void Integrate(const SheetArgs& s) { scalar_sheet_kernels().integrate(s); }
void Maximum(const SheetArgs& s) { scalar_sheet_kernels().maximum(s); }
size_t Crossings(const CrossingArgs& c) { return scalar_sheet_kernels().crossings(c); }
#else

template<class Shade> int CompositeWith(const SheetArgs& s, const Shade& shade) {
  const ClassTable& table = *s.table;
  const V low = set(table.low), scale = set(table.scale), top = set(static_cast<float>(table.size() - 1));
  const auto first = hn::Set(di, table.first_visible - 1), last = hn::Set(di, table.last_visible + 1);
  const V one = set(1.0f), half = set(0.5f), stop = set(s.stop);
  int closed = 0;
  for_pixels(s, [&](const Pixels& px) HWY_ATTR {
    const V alpha = px.load(s.pixel.alpha);
    const V value = px.value();
    const auto index =
        hn::NearestInt(hn::Min(hn::Max(hn::Mul(hn::Sub(value, low), scale), hn::Zero(d)), top));
    const M visible = hn::RebindMask(d, hn::And(hn::Gt(index, first), hn::Lt(index, last)));
    const V weight = px.weight();
    M active = hn::And(hn::And(visible, hn::Lt(alpha, stop)), hn::Gt(weight, hn::Zero(d)));
    if (s.hole) active = hn::And(active, px.solid());
    if (hn::AllFalse(d, active)) return;
    V red, green, blue, extinction;
    LookUp(table, index, red, green, blue, extinction);
    const V absorbed = Absorbed(hn::Mul(hn::Mul(extinction, weight), px.load(s.pixel.path)));
    const V f = hn::IfThenElseZero(active, hn::Mul(hn::Sub(one, alpha), absorbed));
    shade(px, red, green, blue);
    const auto add = [&](float* plane, V part) HWY_ATTR {
      hn::StoreU(hn::MulAdd(f, part, hn::LoadU(d, plane + px.p)), d, plane + px.p);
    };
    add(s.pixel.red, red), add(s.pixel.green, green), add(s.pixel.blue, blue);
    const V after = hn::Add(alpha, f);
    hn::StoreU(after, d, s.pixel.alpha + px.p);
    if (s.pixel.value) add(s.pixel.value, value);
    if (s.pixel.time) add(s.pixel.time, px.time());
    const M passed = hn::And(hn::Lt(alpha, half), hn::Ge(after, half));
    if (!hn::AllFalse(d, passed)) {
      // The transmittance falls exponentially through the part of the slab inside the domain.
      const V begin = hn::Max(set(s.k - s.front), px.load(s.pixel.enter));
      const V tiny = set(1e-30f), left = hn::Max(hn::Sub(one, alpha), tiny);
      const V all = hn::Log(d, hn::Max(hn::Div(hn::Sub(one, after), left), tiny));
      const V part = hn::Div(hn::Log(d, hn::Div(half, left)), hn::Min(all, set(-1e-20f)));
      const V depth = hn::MulAdd(hn::IfThenElseZero(hn::Lt(after, one), part), weight, begin);
      hn::StoreU(hn::IfThenElse(passed, depth, px.load(s.pixel.depth)), d, s.pixel.depth + px.p);
    }
    closed += static_cast<int>(hn::CountTrue(d, hn::And(active, hn::Ge(after, stop))));
  });
  return closed;
}

int Composite(const SheetArgs& s) {
  if (!s.shading) return CompositeWith(s, [](const Pixels&, V&, V&, V&) HWY_ATTR {});
  if (!AlikeLights::fits(s))
    return CompositeWith(s, [](const Pixels& px, V& red, V& green, V& blue)
                                HWY_ATTR { px.light(red, green, blue); });
  const AlikeLights lights(s);
  return CompositeWith(s, [&](const Pixels& px, V& red, V& green, V& blue)
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
  for (int y = 0; y < c.height; ++y)
    for (int x = 0; x < c.width; x += lanes) {
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
      [](const SheetArgs& s) { return HWY_DYNAMIC_DISPATCH(Composite)(s); },
      [](const SheetArgs& s) { return HWY_DYNAMIC_DISPATCH(Integrate)(s); },
      [](const CrossingArgs& c) { return HWY_DYNAMIC_DISPATCH(Crossings)(c); },
      [](const SheetArgs& s) { return HWY_DYNAMIC_DISPATCH(Maximum)(s); },
  };
  return kernels;
}

} // namespace bccsplat
#endif

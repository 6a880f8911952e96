// The sheets of sheet.h through Highway: one body, compiled for every target, the best chosen at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/sheet_simd.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <hwy/contrib/math/math-inl.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "splat/sheet.h"

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

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, 16>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;
constexpr D d;
constexpr hn::RebindToSigned<D> di;

HWY_INLINE V set(float x) { return hn::Set(d, x); }

// 1 - exp(-x), x >= 0, to a few units in the last place for small x, too: exp(-x) = 2^n e^r, |r| <= ln 2 / 2.
HWY_INLINE V Absorbed(V x) {
  const V y = hn::Max(hn::Neg(x), set(-80.0f));
  const V n = hn::Round(hn::Mul(y, set(1.44269504f)));
  const V r = hn::NegMulAdd(n, set(-2.12194440e-4f), hn::NegMulAdd(n, set(0.693359375f), y));
  V p = hn::MulAdd(set(1.0f / 5040), r, set(1.0f / 720));
  p = hn::MulAdd(p, r, set(1.0f / 120));
  p = hn::MulAdd(p, r, set(1.0f / 24));
  p = hn::MulAdd(p, r, set(1.0f / 6));
  p = hn::MulAdd(p, r, set(0.5f));
  p = hn::MulAdd(hn::Mul(p, r), r, r); // e^r - 1
  const V scale = hn::BitCast(d, hn::ShiftLeft<23>(hn::Add(hn::ConvertTo(di, n), hn::Set(di, 127))));
  return hn::NegMulAdd(scale, p, hn::Sub(set(1.0f), scale));
}

// x^power for x in [0, 1].
HWY_INLINE V Power(V x, float power) {
  if (power >= 0 && power <= 1024 && power == std::floor(power)) {
    V result = set(1.0f);
    for (int n = static_cast<int>(power); n > 0; n >>= 1) {
      if (n & 1) result = hn::Mul(result, x);
      x = hn::Mul(x, x);
    }
    return result;
  }
  return hn::Exp(d, hn::Mul(set(power), hn::Log(d, hn::Max(x, set(1e-30f)))));
}

// 1 / sqrt(x), x > 0.
HWY_INLINE V InverseRoot(V x) {
  const V y = hn::ApproximateReciprocalSqrt(x);
  // One step of Newton's method.
  return hn::Mul(y, hn::NegMulAdd(hn::Mul(hn::Mul(set(0.5f), x), y), y, set(1.5f)));
}

HWY_INLINE V Dot(V ax, V ay, V az, V bx, V by, V bz) {
  return hn::MulAdd(ax, bx, hn::MulAdd(ay, by, hn::Mul(az, bz)));
}

// What happens at `lanes` neighbouring pixels from pixel (x, y) of the tile.
struct Pixels {
  const SheetArgs& s;
  int x, y;
  size_t p;          // into the pixel planes
  std::ptrdiff_t at; // into the sheet planes

  HWY_INLINE V load(const float* plane) const { return hn::LoadU(d, plane + p); }
  HWY_INLINE V weight() const {
    const V end = hn::Min(set(s.k + 0.5f), load(s.pixel.leave));
    return hn::Max(hn::Sub(end, hn::Max(set(s.k - s.front), load(s.pixel.enter))), hn::Zero(d));
  }
  HWY_INLINE V value() const { return hn::Add(set(s.air), hn::LoadU(d, s.value + at)); }
  HWY_INLINE V column() const { return hn::Add(set(static_cast<float>(s.x + x)), hn::Iota(d, 0)); }
  // Pixels that are not holes.
  HWY_INLINE M solid() const {
    if (!s.hole) return hn::Eq(hn::Zero(d), hn::Zero(d));
    alignas(64) float hole[16];
    for (size_t l = 0; l < hn::Lanes(d); ++l) hole[l] = s.hole[p + l];
    return hn::Eq(hn::Load(d, hole), hn::Zero(d));
  }
  HWY_INLINE V time() const {
    return hn::MulAdd(set(s.time[1]), column(), set(s.time[0] + s.time[2] * static_cast<float>(s.y + y)));
  }

  // World gradient.
  HWY_INLINE void gradient(V& gx, V& gy, V& gz) const {
    V gi, gj, gk;
    if (s.central || s.fourth_order) {
      const float* v = s.value + at;
      const auto slope = [&](std::ptrdiff_t step) HWY_ATTR {
        const V near = hn::Sub(hn::LoadU(d, v + step), hn::LoadU(d, v - step));
        if (!s.fourth_order) return hn::Mul(set(0.5f), near);
        const V far = hn::Sub(hn::LoadU(d, v + 2 * step), hn::LoadU(d, v - 2 * step));
        return hn::MulSub(set(8.0f / 12), near, hn::Mul(set(1.0f / 12), far));
      };
      gi = slope(1), gj = slope(s.plane_pitch);
      gk = hn::Mul(set(s.depth_scale), hn::Sub(hn::LoadU(d, s.after + at), hn::LoadU(d, s.before + at)));
      if (s.fourth_order)
        gk = hn::MulAdd(set(s.depth_scale2),
                        hn::Sub(hn::LoadU(d, s.after2 + at), hn::LoadU(d, s.before2 + at)), gk);
      const V slant_x = hn::MulAdd(set(s.basis.slant_per_x), column(), set(s.basis.slant_x));
      const V slant_y = set(s.basis.slant_y + static_cast<float>(s.y + y) * s.basis.slant_per_y);
      gk = hn::NegMulAdd(slant_x, gi, hn::NegMulAdd(slant_y, gj, gk));
    } else {
      gi = hn::LoadU(d, s.sum_i + at), gj = hn::LoadU(d, s.sum_j + at), gk = hn::LoadU(d, s.sum_k + at);
    }
    const auto axis = [&](size_t a) HWY_ATTR {
      return hn::MulAdd(set(s.basis.x[a]), gi,
                        hn::MulAdd(set(s.basis.y[a]), gj, hn::Mul(set(s.basis.z[a]), gk)));
    };
    gx = axis(0), gy = axis(1), gz = axis(2);
  }

  // Multiplies the colours and adds the highlights.
  HWY_INLINE void light(V& red, V& green, V& blue) const {
    V gx, gy, gz;
    gradient(gx, gy, gz);
    const V vx = load(s.pixel.view_x), vy = load(s.pixel.view_y), vz = load(s.pixel.view_z);
    const V square = Dot(gx, gy, gz, gx, gy, gz);
    // Squares below this are no gradient: lit as if facing every light, without highlight.
    const M surface = hn::Gt(square, set(1e-36f));
    const V inverse = InverseRoot(hn::IfThenElse(surface, square, set(1.0f)));
    const auto ambient = set(static_cast<float>(s.lights->ambient));
    V scale_r = ambient, scale_g = ambient, scale_b = ambient;
    V shine_r = hn::Zero(d), shine_g = shine_r, shine_b = shine_r;
    for (const Light& l : s.lights->lights) {
      const bool headlight = dot(l.direction, l.direction) == 0;
      V facing, shine;
      if (headlight) {
        facing = hn::Min(hn::Mul(hn::Abs(Dot(gx, gy, gz, vx, vy, vz)), inverse), set(1.0f));
        shine = facing;
      } else {
        const Vec3 to = normalized(l.direction);
        const V lx = set(static_cast<float>(to[0])), ly = set(static_cast<float>(to[1])),
                lz = set(static_cast<float>(to[2]));
        facing = hn::Min(hn::Mul(hn::Abs(Dot(gx, gy, gz, lx, ly, lz)), inverse), set(1.0f));
        const V hx = hn::Add(lx, vx), hy = hn::Add(ly, vy), hz = hn::Add(lz, vz);
        const V half = Dot(hx, hy, hz, hx, hy, hz);
        const M some = hn::Gt(half, set(1e-12f));
        const V over = InverseRoot(hn::IfThenElse(some, half, set(1.0f)));
        shine = hn::Min(hn::Mul(hn::Mul(hn::Abs(Dot(gx, gy, gz, hx, hy, hz)), inverse), over), set(1.0f));
        shine = hn::IfThenElseZero(some, shine);
      }
      facing =
          hn::Mul(hn::IfThenElse(surface, facing, set(1.0f)), set(static_cast<float>(s.lights->diffuse)));
      shine = hn::IfThenElseZero(surface, Power(shine, static_cast<float>(s.lights->shininess)));
      shine = hn::Mul(shine, set(static_cast<float>(s.lights->specular)));
      const V r = set(static_cast<float>(l.color[0])), g = set(static_cast<float>(l.color[1])),
              b = set(static_cast<float>(l.color[2]));
      scale_r = hn::MulAdd(facing, r, scale_r), scale_g = hn::MulAdd(facing, g, scale_g),
      scale_b = hn::MulAdd(facing, b, scale_b);
      shine_r = hn::MulAdd(shine, r, shine_r), shine_g = hn::MulAdd(shine, g, shine_g),
      shine_b = hn::MulAdd(shine, b, shine_b);
    }
    red = hn::MulAdd(red, scale_r, shine_r), green = hn::MulAdd(green, scale_g, shine_g),
    blue = hn::MulAdd(blue, scale_b, shine_b);
  }
};

// Calls body(Pixels) for every vector of the tile. Pixels beside the tile have an empty ray.
template<class Body> HWY_INLINE void for_pixels(const SheetArgs& s, const Body& body) {
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (int y = 0; y < s.height; ++y)
    for (int x = 0; x < s.width; x += lanes)
      body(Pixels{s, x, y, static_cast<size_t>(y) * static_cast<size_t>(s.pitch) + static_cast<size_t>(x),
                  static_cast<std::ptrdiff_t>(y) * s.plane_pitch + x});
}

int Composite(const SheetArgs& s) {
  const ClassTable& table = *s.table;
  const V low = set(table.low), scale = set(table.scale), top = set(static_cast<float>(table.size() - 1));
  const auto first = hn::Set(di, table.first_visible - 1), last = hn::Set(di, table.last_visible + 1);
  const V one = set(1.0f), half = set(0.5f), stop = set(s.stop);
  int closed = 0;
  alignas(64) int32_t entry[16];
  alignas(64) float looked_up[64];
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
    hn::Store(index, di, entry);
    for (size_t l = 0; l < hn::Lanes(d); ++l)
      std::memcpy(looked_up + 4 * l, table.entry[static_cast<size_t>(entry[l])].data(), 16);
    V red, green, blue, extinction;
    hn::LoadInterleaved4(d, looked_up, red, green, blue, extinction);
    const V absorbed = Absorbed(hn::Mul(hn::Mul(extinction, weight), px.load(s.pixel.path)));
    const V f = hn::IfThenElseZero(active, hn::Mul(hn::Sub(one, alpha), absorbed));
    if (s.shading) px.light(red, green, blue);
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
  const V target = set(c.target), k = set(c.k), before = set(c.k - 1), one = set(1.0f);
  size_t count = 0;
  uint8_t bits[8]; // one per lane
  for (int y = 0; y < c.height; ++y)
    for (int x = 0; x < c.width; x += lanes) {
      const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(y) * c.plane_pitch + x;
      const size_t p = static_cast<size_t>(y) * static_cast<size_t>(c.pitch) + static_cast<size_t>(x);
      M found =
          hn::Xor(hn::Lt(hn::LoadU(d, c.before + at), target), hn::Lt(hn::LoadU(d, c.value + at), target));
      if (hn::AllFalse(d, found)) continue;
      found = hn::And(found, hn::Lt(hn::LoadU(d, c.alpha + p), one));
      found = hn::And(
          found, hn::And(hn::Le(hn::LoadU(d, c.enter + p), k), hn::Le(before, hn::LoadU(d, c.leave + p))));
      hn::StoreMaskBits(d, found, bits);
      for (int l = 0; l < std::min(lanes, c.width - x); ++l)
        if (bits[l / 8] >> (l % 8) & 1)
          c.found[count++] = static_cast<uint32_t>(y) << 16 | static_cast<uint32_t>(x + l);
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

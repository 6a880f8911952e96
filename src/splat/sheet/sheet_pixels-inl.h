// SPDX-License-Identifier: Apache-2.0
// What the sheets' SIMD loops share: pixels side by side, their rays, gradients and light. The file is
// included once per target.
#include <hwy/highway.h>

#include <hwy/contrib/math/math-inl.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "splat/sheet/sheet.h"

#if defined(BCCSPLAT_SHEET_PIXELS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef BCCSPLAT_SHEET_PIXELS_INL
#undef BCCSPLAT_SHEET_PIXELS_INL
#else
#define BCCSPLAT_SHEET_PIXELS_INL
#endif

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
#if HWY_TARGET != HWY_SCALAR

namespace hn = hwy::HWY_NAMESPACE;
namespace {

using D = hn::CappedTag<float, 16>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;
constexpr D d;
constexpr hn::RebindToSigned<D> di;

HWY_INLINE V Set(float x) { return hn::Set(d, x); }

// 1 - exp(-x), x >= 0, to a few units in the last place for small x, too: exp(-x) = 2^n e^r, |r| <= ln 2 / 2.
HWY_INLINE V Absorbed(V x) {
  const V y = hn::Max(hn::Neg(x), Set(-80.0f));
  const V n = hn::Round(hn::Mul(y, Set(1.44269504f)));
  const V r = hn::NegMulAdd(n, Set(-2.12194440e-4f), hn::NegMulAdd(n, Set(0.693359375f), y));
  V p = hn::MulAdd(Set(1.0f / 5040), r, Set(1.0f / 720));
  p = hn::MulAdd(p, r, Set(1.0f / 120));
  p = hn::MulAdd(p, r, Set(1.0f / 24));
  p = hn::MulAdd(p, r, Set(1.0f / 6));
  p = hn::MulAdd(p, r, Set(0.5f));
  p = hn::MulAdd(hn::Mul(p, r), r, r); // e^r - 1
  const V scale = hn::BitCast(d, hn::ShiftLeft<23>(hn::Add(hn::ConvertTo(di, n), hn::Set(di, 127))));
  return hn::NegMulAdd(scale, p, hn::Sub(Set(1.0f), scale));
}

// x^power for x in [0, 1].
HWY_INLINE V Power(V x, float power) {
  if (power == 20) { // the default
    const V x2 = hn::Mul(x, x), x4 = hn::Mul(x2, x2), x5 = hn::Mul(x4, x), x10 = hn::Mul(x5, x5);
    return hn::Mul(x10, x10);
  }
  if (power >= 0 && power <= 1024 && power == std::floor(power)) {
    V result = Set(1.0f);
    for (int n = static_cast<int>(power); n > 0; n >>= 1) {
      if (n & 1) result = hn::Mul(result, x);
      x = hn::Mul(x, x);
    }
    return result;
  }
  return hn::Exp(d, hn::Mul(Set(power), hn::Log(d, hn::Max(x, Set(1e-30f)))));
}

// 1 / sqrt(x), x > 0.
HWY_INLINE V InverseRoot(V x) {
  V y = hn::ApproximateReciprocalSqrt(x);
  // Steps of Newton's method, each of which doubles the digits: NEON's estimate has 8 bits, those of x86
  // have 11.
  constexpr int steps = HWY_ARCH_ARM ? 2 : 1;
  for (int step = 0; step < steps; ++step)
    y = hn::Mul(y, hn::NegMulAdd(hn::Mul(hn::Mul(Set(0.5f), x), y), y, Set(1.5f)));
  return y;
}

HWY_INLINE V Dot(V ax, V ay, V az, V bx, V by, V bz) {
  return hn::MulAdd(ax, bx, hn::MulAdd(ay, by, hn::Mul(az, bz)));
}

// Squares of lengths up to this are of no gradient: the sample is lit as if it faced every light, without
// highlight.
constexpr float least_square = 1e-36f;

// How much light a surface sends on by the cosine of facing it and of mirroring it.
struct Gloss {
  float ambient = 0, diffuse = 0, specular = 0, shininess = 0, least = 0; // least_cosine()
  Gloss() = default;
  explicit Gloss(const Lights& l)
      : ambient(static_cast<float>(l.ambient)), diffuse(static_cast<float>(l.diffuse)),
        specular(static_cast<float>(l.specular)), shininess(static_cast<float>(l.shininess)),
        least(least_cosine(l.shininess)) {}

  HWY_INLINE V highlight(V cosine) const {
    const V least_v = Set(least);
    return hn::IfThenElseZero(hn::Ge(cosine, least_v), Power(hn::Max(cosine, least_v), shininess));
  }
};

// How much of a light a surface sends on, before the light's colour.
struct Lobe {
  V scale, highlight;
  [[nodiscard]] HWY_INLINE Lobe times(V share) const {
    return {hn::Mul(share, scale), hn::Mul(share, highlight)};
  }
};

// A piece of surface: its gradient, one over the length of that, and its weight.
struct Facet {
  V x, y, z, inverse, surface;
  [[nodiscard]] HWY_INLINE V cosine(V to_x, V to_y, V to_z) const {
    const V along = hn::Abs(Dot(to_x, to_y, to_z, x, y, z));
    return hn::Min(hn::Mul(along, inverse), Set(1.0f));
  }
};

// A light as facets see it: its direction, and the halfway vector unless it shines from the viewer.
struct Beam {
  V x, y, z, half_x, half_y, half_z;
  bool headlight;
  [[nodiscard]] HWY_INLINE Lobe on(const Facet& f, const Gloss& gloss) const {
    const V facing = f.cosine(x, y, z);
    const V shine = headlight ? facing : f.cosine(half_x, half_y, half_z);
    const V weighted = hn::MulAdd(f.surface, facing, hn::Sub(Set(1.0f), f.surface));
    return {hn::Mul(weighted, Set(gloss.diffuse)),
            hn::Mul(hn::Mul(f.surface, gloss.highlight(shine)), Set(gloss.specular))};
  }
};

// What lights do to a colour: a factor and a highlight for each part.
struct Lit {
  V scale_r, scale_g, scale_b, shine_r, shine_g, shine_b;
  HWY_INLINE explicit Lit(V ambient)
      : scale_r(ambient), scale_g(scale_r), scale_b(scale_r), shine_r(hn::Zero(d)), shine_g(shine_r),
        shine_b(shine_r) {}

  HWY_INLINE void add(const Lobe& lobe, const std::array<float, 3>& color) {
    const V r = Set(color[0]), g = Set(color[1]), b = Set(color[2]);
    scale_r = hn::MulAdd(lobe.scale, r, scale_r), scale_g = hn::MulAdd(lobe.scale, g, scale_g),
    scale_b = hn::MulAdd(lobe.scale, b, scale_b);
    shine_r = hn::MulAdd(lobe.highlight, r, shine_r), shine_g = hn::MulAdd(lobe.highlight, g, shine_g),
    shine_b = hn::MulAdd(lobe.highlight, b, shine_b);
  }
  HWY_INLINE void apply(V& red, V& green, V& blue) const {
    red = hn::MulAdd(red, scale_r, shine_r), green = hn::MulAdd(green, scale_g, shine_g),
    blue = hn::MulAdd(blue, scale_b, shine_b);
  }
};

// Loads the entries number[0], number[4], ... side by side.
template<class Tag>
HWY_INLINE hn::Vec<Tag> FourthEntries(Tag tag, const std::array<float, 4>* entry, const int32_t* number) {
  if constexpr (hn::MaxLanes(tag) > 4) {
    const hn::Half<Tag> half;
    const auto low = FourthEntries(half, entry, number);
    return hn::Combine(tag, FourthEntries(half, entry, number + hn::MaxLanes(half)), low);
  } else {
    return hn::LoadU(tag, entry[*number].data());
  }
}

// Looks up the colours and extinctions of table entries.
HWY_INLINE void LookUp(const std::array<float, 4>* entry, hn::Vec<hn::RebindToSigned<D>> index, V& red,
                       V& green, V& blue, V& extinction) {
  alignas(64) int32_t number[16];
  hn::Store(index, di, number);
  // Vector j takes the entries of every fourth pixel from j on; then blocks of 4 x 4 are transposed.
  const auto gather = [&](size_t j) HWY_ATTR { return FourthEntries(d, entry, number + j); };
  const hn::RepartitionToWide<D> wide;
  const V v0 = gather(0), v1 = gather(1), v2 = gather(2), v3 = gather(3);
  const auto low01 = hn::BitCast(wide, hn::InterleaveLower(d, v0, v1)),
             low23 = hn::BitCast(wide, hn::InterleaveLower(d, v2, v3)),
             high01 = hn::BitCast(wide, hn::InterleaveUpper(d, v0, v1)),
             high23 = hn::BitCast(wide, hn::InterleaveUpper(d, v2, v3));
  red = hn::BitCast(d, hn::InterleaveLower(wide, low01, low23));
  green = hn::BitCast(d, hn::InterleaveUpper(wide, low01, low23));
  blue = hn::BitCast(d, hn::InterleaveLower(wide, high01, high23));
  extinction = hn::BitCast(d, hn::InterleaveUpper(wide, high01, high23));
}

// One vector of neighbouring pixels, from pixel (x, y) of the tile on.
struct Pixels {
  const SheetArgs& s;
  int x, y;
  size_t p;          // into the pixel planes
  std::ptrdiff_t at; // into the sheet planes

  HWY_INLINE V load(const float* plane) const { return hn::LoadU(d, plane + p); }
  HWY_INLINE V weight() const {
    const V end = hn::Min(Set(s.segment.end()), load(s.pixel.leave));
    return hn::Max(hn::Sub(end, hn::Max(Set(s.segment.begin()), load(s.pixel.enter))), hn::Zero(d));
  }
  HWY_INLINE V value() const { return hn::Add(Set(s.field.base), hn::LoadU(d, s.field.value + at)); }
  HWY_INLINE V column() const { return hn::Add(Set(static_cast<float>(s.tile.x + x)), hn::Iota(d, 0)); }
  // Pixels that are not holes.
  HWY_INLINE M solid() const {
    if (!s.hole) return hn::Eq(hn::Zero(d), hn::Zero(d));
    const auto hole = hn::PromoteTo(di, hn::LoadU(hn::Rebind<uint8_t, D>(), s.hole + p));
    return hn::RebindMask(d, hn::Eq(hole, hn::Zero(di)));
  }
  HWY_INLINE V time() const {
    return hn::MulAdd(Set(s.time[1]), column(),
                      Set(s.time[0] + s.time[2] * static_cast<float>(s.tile.y + y)));
  }

  // The light from all around that comes here, and what a surface sends on of light n.
  HWY_INLINE V ambient(const Gloss& gloss) const {
    const V all = Set(gloss.ambient);
    return s.paint.ambient ? hn::Mul(all, load(s.paint.ambient)) : all;
  }
  HWY_INLINE Lobe of_light(size_t n, const Lobe& lobe) const {
    return s.paint.lights ? lobe.times(load(s.paint.lights + n * s.paint.light_floats)) : lobe;
  }

  // Takes the kernel's ripple off the sums of the analytic gradient, as far as the nearest entry of the table
  // has it.
  HWY_INLINE void take_ripple_off(V& gi, V& gj, V& gk) const {
    const SheetRipple& r = s.analytic.ripple;
    const auto cells = static_cast<int32_t>(r.sums->cells());
    const V across = column(), value = hn::LoadU(d, s.field.value + at);
    const auto from_site = [&](size_t a) HWY_ATTR {
      const V t =
          hn::MulAdd(across, Set(r.per_x[a]), Set(r.at[a] + static_cast<float>(s.tile.y + y) * r.per_y[a]));
      return hn::Sub(t, hn::Round(t));
    };
    const V t0 = from_site(0), t1 = from_site(1), t2 = from_site(2);
    const auto place = [&](V t) HWY_ATTR {
      return hn::NearestInt(hn::Mul(hn::Abs(t), Set(static_cast<float>(2 * cells))));
    };
    const auto row = hn::Set(di, cells + 1);
    const auto index = hn::Add(hn::Mul(hn::Add(hn::Mul(place(t2), row), place(t1)), row), place(t0));
    V g0, g1, g2, unused;
    LookUp(r.sums->table().data(), index, g0, g1, g2, unused);
    const auto mirrored = [&](V g, V t)
                              HWY_ATTR { return hn::Mul(value, hn::Xor(g, hn::And(hn::SignBit(d), t))); };
    g0 = mirrored(g0, t0), g1 = mirrored(g1, t1), g2 = mirrored(g2, t2);
    const auto part = [&](const std::array<float, 3>& sum)
                          HWY_ATTR { return Dot(g0, g1, g2, Set(sum[0]), Set(sum[1]), Set(sum[2])); };
    gi = hn::Sub(gi, part(r.sum_i)), gj = hn::Sub(gj, part(r.sum_j)), gk = hn::Sub(gk, part(r.sum_k));
  }

  // The parts of the world gradient along the vectors of the sheet's basis.
  HWY_INLINE void gradient_parts(V& gi, V& gj, V& gk) const {
    const SheetDifferences& by = s.differences;
    if (by.neighbours > 0) {
      const float* v = s.field.value + at;
      const auto slope = [&](std::ptrdiff_t step) HWY_ATTR {
        const V near = hn::Sub(hn::LoadU(d, v + step), hn::LoadU(d, v - step));
        if (by.neighbours != 2) return hn::Mul(Set(0.5f), near);
        const V far = hn::Sub(hn::LoadU(d, v + 2 * step), hn::LoadU(d, v - 2 * step));
        return hn::MulSub(Set(8.0f / 12), near, hn::Mul(Set(1.0f / 12), far));
      };
      gi = slope(1), gj = slope(s.tile.plane_pitch);
      gk = hn::Mul(Set(by.depth_scale), hn::Sub(hn::LoadU(d, by.after + at), hn::LoadU(d, by.before + at)));
      if (by.neighbours == 2)
        gk = hn::MulAdd(Set(by.depth_scale2),
                        hn::Sub(hn::LoadU(d, by.after2 + at), hn::LoadU(d, by.before2 + at)), gk);
      take_slant_off(gi, gj, gk);
    } else {
      gi = hn::LoadU(d, s.analytic.i + at), gj = hn::LoadU(d, s.analytic.j + at),
      gk = hn::LoadU(d, s.analytic.k + at);
      if (s.analytic.ripple.sums) take_ripple_off(gi, gj, gk);
    }
    const V unit = Set(s.basis.unit);
    gi = hn::Mul(unit, gi), gj = hn::Mul(unit, gj), gk = hn::Mul(unit, gk);
  }

  // What they change by along a quarter of a sheet's distance.
  HWY_INLINE void gradient_change(V& ci, V& cj, V& ck) const {
    const SheetDifferences& by = s.differences;
    const auto slope = [&](std::ptrdiff_t step) HWY_ATTR {
      const auto across = [&](const float* plane) HWY_ATTR {
        return hn::Sub(hn::LoadU(d, plane + at + step), hn::LoadU(d, plane + at - step));
      };
      return hn::Mul(Set(0.0625f * s.basis.unit), hn::Sub(across(by.after), across(by.before)));
    };
    ci = slope(1), cj = slope(s.tile.plane_pitch);
    const V sum = hn::Add(hn::LoadU(d, by.after + at), hn::LoadU(d, by.before + at));
    ck = hn::Mul(Set(0.25f * s.basis.unit), hn::NegMulAdd(Set(2.0f), hn::LoadU(d, s.field.value + at), sum));
    take_slant_off(ci, cj, ck);
  }
  HWY_INLINE void take_slant_off(V gi, V gj, V& gk) const {
    if (s.shading.alike && s.basis.slant_x == 0 && s.basis.slant_y == 0) return;
    const V slant_x = hn::MulAdd(Set(s.basis.slant_per_x), column(), Set(s.basis.slant_x));
    const V slant_y = Set(s.basis.slant_y + static_cast<float>(s.tile.y + y) * s.basis.slant_per_y);
    gk = hn::NegMulAdd(slant_x, gi, hn::NegMulAdd(slant_y, gj, gk));
  }

  // The weight of a surface, 0 to 1, as surface_weight(); square, inverse: of the length of the gradient.
  HWY_INLINE V surface(V square, V inverse) const {
    constexpr auto steepness = static_cast<float>(surface_over_noise / (surface_over_noise - 1));
    const V above_base = hn::Abs(hn::LoadU(d, s.field.value + at));
    const V ratio =
        hn::Mul(hn::MulAdd(above_base, Set(s.shading.noise_of_value), Set(s.shading.noise)), inverse);
    const V rise = hn::NegMulAdd(ratio, Set(steepness), Set(steepness));
    const V t = hn::Min(hn::Max(rise, hn::Zero(d)), Set(1.0f));
    const V weight = hn::Mul(hn::Mul(t, t), hn::NegMulAdd(Set(2.0f), t, Set(3.0f)));
    return hn::IfThenElseZero(hn::Gt(square, Set(least_square)), weight);
  }
};

// The lights of a sheet whose rays are not alike, in world space.
struct WorldLights {
  const SheetArgs& s;
  Gloss gloss;
  explicit WorldLights(const SheetArgs& sheet) : s(sheet), gloss(*sheet.shading.lights) {}
  [[nodiscard]] size_t count() const { return s.shading.lights->lights.size(); }
  [[nodiscard]] std::array<float, 3> color(size_t n) const {
    const Vec3& c = s.shading.lights->lights[n].color;
    return {static_cast<float>(c[0]), static_cast<float>(c[1]), static_cast<float>(c[2])};
  }

  HWY_INLINE Facet facet(const Pixels& px, V gi, V gj, V gk) const {
    const GradientBasis& b = px.s.basis;
    const auto axis = [&](size_t a) HWY_ATTR {
      return hn::MulAdd(Set(b.x[a]), gi, hn::MulAdd(Set(b.y[a]), gj, hn::Mul(Set(b.z[a]), gk)));
    };
    const V gx = axis(0), gy = axis(1), gz = axis(2);
    const V square = Dot(gx, gy, gz, gx, gy, gz);
    const V inverse = InverseRoot(hn::Max(square, Set(least_square)));
    return {gx, gy, gz, inverse, px.surface(square, inverse)};
  }

  HWY_INLINE Beam beam(const Pixels& px, size_t n) const {
    const Light& l = s.shading.lights->lights[n];
    const V vx = px.load(s.pixel.view_x), vy = px.load(s.pixel.view_y), vz = px.load(s.pixel.view_z);
    if (dot(l.direction, l.direction) == 0) return {vx, vy, vz, vx, vy, vz, true};
    const Vec3 to = normalized(l.direction);
    const V lx = Set(static_cast<float>(to[0])), ly = Set(static_cast<float>(to[1])),
            lz = Set(static_cast<float>(to[2]));
    const V hx = hn::Add(lx, vx), hy = hn::Add(ly, vy), hz = hn::Add(lz, vz);
    const V half = Dot(hx, hy, hz, hx, hy, hz);
    const M some = hn::Gt(half, Set(1e-12f));
    const V over = hn::IfThenElseZero(some, InverseRoot(hn::IfThenElse(some, half, Set(1.0f))));
    return {lx, ly, lz, hn::Mul(hx, over), hn::Mul(hy, over), hn::Mul(hz, over), false};
  }
};

// The lights of a sheet whose rays are alike, as forms of the parts of the gradient, which every pixel would
// otherwise make of the same vectors.
struct AlikeLights {
  static constexpr size_t most = 8;
  struct Parts {
    std::array<float, 3> facing{}, half{}; // light . basis; halfway vector, unit length, . basis; 0: none
    std::array<float, 3> color{};
    bool headlight = false;
  };
  size_t lights = 0;
  std::array<Parts, most> light{};
  std::array<float, 6> square{}; // of the gradient: ii ij ik jj jk kk
  Gloss gloss;

  [[nodiscard]] static bool fits(const SheetArgs& s) {
    return s.shading.alike && s.shading.on && s.shading.lights->lights.size() <= most;
  }
  explicit AlikeLights(const SheetArgs& s)
      : lights(s.shading.lights->lights.size()), gloss(*s.shading.lights) {
    const GradientBasis& b = s.basis;
    const auto vector = [](const std::array<float, 3>& of) {
      return Vec3{static_cast<double>(of[0]), static_cast<double>(of[1]), static_cast<double>(of[2])};
    };
    const std::array<Vec3, 3> v{vector(b.x), vector(b.y), vector(b.z)};
    size_t n = 0;
    for (size_t p = 0; p < 3; ++p)
      for (size_t q = p; q < 3; ++q, ++n) square[n] = static_cast<float>((p == q ? 1 : 2) * dot(v[p], v[q]));
    // What is left of the mixed products of an orthogonal basis is rounding.
    const float largest = std::max({square[0], square[3], square[5]});
    for (const size_t mixed : {1u, 2u, 4u})
      if (std::fabs(square[mixed]) < 1e-6f * largest) square[mixed] = 0;
    for (size_t l = 0; l < lights; ++l) {
      const Light& from = s.shading.lights->lights[l];
      Parts& to = light[l];
      to.headlight = dot(from.direction, from.direction) == 0;
      const Vec3 direction = to.headlight ? s.shading.to_viewer : normalized(from.direction);
      const Vec3 between = direction + s.shading.to_viewer;
      const double size = length(between);
      for (size_t a = 0; a < 3; ++a) {
        to.facing[a] = static_cast<float>(dot(v[a], direction));
        to.half[a] = size > 1e-6 ? static_cast<float>(dot(v[a], between) / size) : 0.0f;
        to.color[a] = static_cast<float>(from.color[a]);
      }
    }
  }

  [[nodiscard]] size_t count() const { return lights; }
  [[nodiscard]] const std::array<float, 3>& color(size_t n) const { return light[n].color; }

  HWY_INLINE Facet facet(const Pixels& px, V gi, V gj, V gk) const {
    V square_i = hn::Mul(Set(square[0]), gi), square_j = hn::Mul(Set(square[3]), gj);
    if (square[1] != 0 || square[2] != 0 || square[4] != 0) {
      square_i = hn::MulAdd(Set(square[1]), gj, hn::MulAdd(Set(square[2]), gk, square_i));
      square_j = hn::MulAdd(Set(square[4]), gk, square_j);
    }
    const V norm2 =
        hn::MulAdd(square_i, gi, hn::MulAdd(square_j, gj, hn::Mul(hn::Mul(Set(square[5]), gk), gk)));
    const V inverse = InverseRoot(hn::Max(norm2, Set(least_square)));
    return {gi, gj, gk, inverse, px.surface(norm2, inverse)};
  }

  HWY_INLINE Beam beam(const Pixels&, size_t n) const {
    const Parts& l = light[n];
    return {Set(l.facing[0]), Set(l.facing[1]), Set(l.facing[2]), Set(l.half[0]),
            Set(l.half[1]),   Set(l.half[2]),   l.headlight};
  }
};

// What a segment adds to the opacity of a pixel, and how much of that its front half does.
struct Halves {
  V added, front;
};
HWY_INLINE bool LitInHalves(V added) { return !hn::AllFalse(d, hn::Gt(added, Set(lit_in_halves))); }

// These are structs and not lambdas, which would not be inlined at this size: a call passes all vectors
// through memory.
struct NoLight {
  HWY_INLINE void operator()(const Pixels&, V&, V&, V&) const {}
  HWY_INLINE void halves(const Pixels&, const Halves&, V&, V&, V&) const {}
};
template<class Lighting> struct LightPixels {
  Lighting lights;
  // Multiplies the colours and adds the highlights.
  HWY_INLINE void operator()(const Pixels& px, V& red, V& green, V& blue) const {
    V gi, gj, gk;
    px.gradient_parts(gi, gj, gk);
    const Facet facet = lights.facet(px, gi, gj, gk);
    Lit lit(px.ambient(lights.gloss));
    for (size_t n = 0; n < lights.count(); ++n)
      lit.add(px.of_light(n, lights.beam(px, n).on(facet, lights.gloss)), lights.color(n));
    lit.apply(red, green, blue);
  }
  // The same in halves, as light_segment().
  HWY_INLINE void halves(const Pixels& px, const Halves& of, V& red, V& green, V& blue) const {
    V gi, gj, gk, ci, cj, ck;
    px.gradient_parts(gi, gj, gk);
    px.gradient_change(ci, cj, ck);
    const V rise = hn::MulSub(of.added, Set(1 / lit_in_halves), Set(1.0f));
    const V move = hn::Min(hn::Max(rise, hn::Zero(d)), Set(1.0f));
    ci = hn::Mul(move, ci), cj = hn::Mul(move, cj), ck = hn::Mul(move, ck);
    const Facet front = lights.facet(px, hn::Sub(gi, ci), hn::Sub(gj, cj), hn::Sub(gk, ck));
    const Facet back = lights.facet(px, hn::Add(gi, ci), hn::Add(gj, cj), hn::Add(gk, ck));
    Lit lit(px.ambient(lights.gloss));
    for (size_t n = 0; n < lights.count(); ++n) {
      const Beam beam = lights.beam(px, n);
      const Lobe a = beam.on(front, lights.gloss), b = beam.on(back, lights.gloss);
      lit.add(px.of_light(n, {hn::MulAdd(of.front, hn::Sub(a.scale, b.scale), b.scale),
                              hn::MulAdd(of.front, hn::Sub(a.highlight, b.highlight), b.highlight)}),
              lights.color(n));
    }
    lit.apply(red, green, blue);
  }
};

// Calls body(shade) with what lights the colours of the sheet's pixels.
template<class Body> HWY_INLINE auto WithLight(const SheetArgs& s, const Body& body) {
  if (!s.shading.on) return body(NoLight{});
  if (!AlikeLights::fits(s)) return body(LightPixels<WorldLights>{WorldLights(s)});
  return body(LightPixels<AlikeLights>{AlikeLights(s)});
}

// Calls body(Pixels) for every vector of the tile. The rays of pixels beside the tile are empty.
template<class Body> HWY_INLINE void ForPixels(const SheetArgs& s, const Body& body) {
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (int y = 0; y < s.tile.height; ++y)
    for (int x = 0; x < s.tile.width; x += lanes)
      body(Pixels{s, x, y, s.tile.pixel(x, y), s.tile.sample(x, y)});
}

} // namespace
#endif
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();
#endif

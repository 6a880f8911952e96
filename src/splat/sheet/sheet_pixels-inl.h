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
  const V y = hn::ApproximateReciprocalSqrt(x);
  // One step of Newton's method.
  return hn::Mul(y, hn::NegMulAdd(hn::Mul(hn::Mul(Set(0.5f), x), y), y, Set(1.5f)));
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

// What lights do to a colour: a factor and a highlight for each part.
struct Lit {
  V scale_r, scale_g, scale_b, shine_r, shine_g, shine_b;
  HWY_INLINE explicit Lit(float ambient)
      : scale_r(Set(ambient)), scale_g(scale_r), scale_b(scale_r), shine_r(hn::Zero(d)), shine_g(shine_r),
        shine_b(shine_r) {}

  // Adds a light of which the surface sees `facing` and mirrors `shine` (cosines), as far as there is one.
  HWY_INLINE void add(V facing, V shine, V surface, const Gloss& gloss, const std::array<float, 3>& color) {
    facing = hn::Mul(hn::MulAdd(surface, facing, hn::Sub(Set(1.0f), surface)), Set(gloss.diffuse));
    shine = hn::Mul(hn::Mul(surface, gloss.highlight(shine)), Set(gloss.specular));
    const V r = Set(color[0]), g = Set(color[1]), b = Set(color[2]);
    scale_r = hn::MulAdd(facing, r, scale_r), scale_g = hn::MulAdd(facing, g, scale_g),
    scale_b = hn::MulAdd(facing, b, scale_b);
    shine_r = hn::MulAdd(shine, r, shine_r), shine_g = hn::MulAdd(shine, g, shine_g),
    shine_b = hn::MulAdd(shine, b, shine_b);
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
      if (!s.shading.alike || s.basis.slant_x != 0 || s.basis.slant_y != 0) {
        const V slant_x = hn::MulAdd(Set(s.basis.slant_per_x), column(), Set(s.basis.slant_x));
        const V slant_y = Set(s.basis.slant_y + static_cast<float>(s.tile.y + y) * s.basis.slant_per_y);
        gk = hn::NegMulAdd(slant_x, gi, hn::NegMulAdd(slant_y, gj, gk));
      }
    } else {
      gi = hn::LoadU(d, s.analytic.i + at), gj = hn::LoadU(d, s.analytic.j + at),
      gk = hn::LoadU(d, s.analytic.k + at);
      if (s.analytic.ripple.sums) take_ripple_off(gi, gj, gk);
    }
    const V unit = Set(s.basis.unit);
    gi = hn::Mul(unit, gi), gj = hn::Mul(unit, gj), gk = hn::Mul(unit, gk);
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

  // World gradient, enlarged.
  HWY_INLINE void gradient(V& gx, V& gy, V& gz) const {
    V gi, gj, gk;
    gradient_parts(gi, gj, gk);
    const auto axis = [&](size_t a) HWY_ATTR {
      return hn::MulAdd(Set(s.basis.x[a]), gi,
                        hn::MulAdd(Set(s.basis.y[a]), gj, hn::Mul(Set(s.basis.z[a]), gk)));
    };
    gx = axis(0), gy = axis(1), gz = axis(2);
  }

  // Multiplies the colours and adds the highlights.
  HWY_INLINE void light(V& red, V& green, V& blue) const {
    V gx, gy, gz;
    gradient(gx, gy, gz);
    const V vx = load(s.pixel.view_x), vy = load(s.pixel.view_y), vz = load(s.pixel.view_z);
    const V square = Dot(gx, gy, gz, gx, gy, gz);
    const V inverse = InverseRoot(hn::Max(square, Set(least_square)));
    const V weight = surface(square, inverse);
    const Lights& lights = *s.shading.lights;
    const Gloss gloss(lights);
    Lit lit(gloss.ambient);
    for (const Light& l : lights.lights) {
      const bool headlight = dot(l.direction, l.direction) == 0;
      V facing, shine;
      if (headlight) {
        facing = hn::Min(hn::Mul(hn::Abs(Dot(gx, gy, gz, vx, vy, vz)), inverse), Set(1.0f));
        shine = facing;
      } else {
        const Vec3 to = normalized(l.direction);
        const V lx = Set(static_cast<float>(to[0])), ly = Set(static_cast<float>(to[1])),
                lz = Set(static_cast<float>(to[2]));
        facing = hn::Min(hn::Mul(hn::Abs(Dot(gx, gy, gz, lx, ly, lz)), inverse), Set(1.0f));
        const V hx = hn::Add(lx, vx), hy = hn::Add(ly, vy), hz = hn::Add(lz, vz);
        const V half = Dot(hx, hy, hz, hx, hy, hz);
        const M some = hn::Gt(half, Set(1e-12f));
        const V over = InverseRoot(hn::IfThenElse(some, half, Set(1.0f)));
        shine = hn::Min(hn::Mul(hn::Mul(hn::Abs(Dot(gx, gy, gz, hx, hy, hz)), inverse), over), Set(1.0f));
        shine = hn::IfThenElseZero(some, shine);
      }
      lit.add(
          facing, shine, weight, gloss,
          {static_cast<float>(l.color[0]), static_cast<float>(l.color[1]), static_cast<float>(l.color[2])});
    }
    lit.apply(red, green, blue);
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
  size_t count = 0;
  std::array<Parts, most> light{};
  std::array<float, 6> square{}; // of the gradient: ii ij ik jj jk kk
  Gloss gloss;

  [[nodiscard]] static bool fits(const SheetArgs& s) {
    return s.shading.alike && s.shading.on && s.shading.lights->lights.size() <= most;
  }
  explicit AlikeLights(const SheetArgs& s)
      : count(s.shading.lights->lights.size()), gloss(*s.shading.lights) {
    const GradientBasis& b = s.basis;
    const Lights& lights = *s.shading.lights;
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
    for (size_t l = 0; l < count; ++l) {
      const Light& from = lights.lights[l];
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

  // As Pixels::light.
  HWY_INLINE void shade(const Pixels& px, V& red, V& green, V& blue) const {
    V gi, gj, gk;
    px.gradient_parts(gi, gj, gk);
    V square_i = hn::Mul(Set(square[0]), gi), square_j = hn::Mul(Set(square[3]), gj);
    if (square[1] != 0 || square[2] != 0 || square[4] != 0) {
      square_i = hn::MulAdd(Set(square[1]), gj, hn::MulAdd(Set(square[2]), gk, square_i));
      square_j = hn::MulAdd(Set(square[4]), gk, square_j);
    }
    const V norm2 =
        hn::MulAdd(square_i, gi, hn::MulAdd(square_j, gj, hn::Mul(hn::Mul(Set(square[5]), gk), gk)));
    const V inverse = InverseRoot(hn::Max(norm2, Set(least_square)));
    const V weight = px.surface(norm2, inverse);
    const auto along = [&](const std::array<float, 3>& to) HWY_ATTR {
      const V cosine = hn::Abs(Dot(Set(to[0]), Set(to[1]), Set(to[2]), gi, gj, gk));
      return hn::Min(hn::Mul(cosine, inverse), Set(1.0f));
    };
    Lit lit(gloss.ambient);
    for (size_t n = 0; n < count; ++n) {
      const Parts& l = light[n];
      const V facing = along(l.facing);
      lit.add(facing, l.headlight ? facing : along(l.half), weight, gloss, l.color);
    }
    lit.apply(red, green, blue);
  }
};

// These are structs and not lambdas, which would not be inlined at this size: a call passes all vectors
// through memory.
struct NoLight {
  HWY_INLINE void operator()(const Pixels&, V&, V&, V&) const {}
};
struct LightPixels {
  HWY_INLINE void operator()(const Pixels& px, V& red, V& green, V& blue) const {
    px.light(red, green, blue);
  }
};
struct LightAlike {
  AlikeLights lights;
  HWY_INLINE void operator()(const Pixels& px, V& red, V& green, V& blue) const {
    lights.shade(px, red, green, blue);
  }
};

// Calls body(shade) with what lights the colours of the sheet's pixels.
template<class Body> HWY_INLINE auto WithLight(const SheetArgs& s, const Body& body) {
  if (!s.shading.on) return body(NoLight{});
  if (!AlikeLights::fits(s)) return body(LightPixels{});
  return body(LightAlike{AlikeLights(s)});
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

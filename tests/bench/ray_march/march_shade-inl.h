// SPDX-License-Identifier: Apache-2.0
// Colour and light of a packet of samples. The file is included once per target.
#include <cmath>
#include <cstring>

#include <hwy/contrib/math/math-inl.h>

#include "tests/bench/ray_march/march_packet-inl.h"

#if defined(BCCSPLAT_MARCH_SHADE_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef BCCSPLAT_MARCH_SHADE_INL
#undef BCCSPLAT_MARCH_SHADE_INL
#else
#define BCCSPLAT_MARCH_SHADE_INL
#endif

HWY_BEFORE_NAMESPACE();
namespace bccsplat::bench {
namespace HWY_NAMESPACE {
#if HWY_TARGET != HWY_SCALAR

HWY_INLINE void classify(const MarchPacketArgs& a, V value, V& r, V& g, V& b, V& extinction) {
  const V top = set(static_cast<float>(a.entries - 1));
  const VI index = hn::NearestInt(
      hn::Min(hn::Max(hn::Mul(hn::Sub(value, set(a.table_low)), set(a.table_scale)), hn::Zero(d)), top));
  alignas(64) int32_t entry[16];
  alignas(64) float looked_up[64];
  hn::Store(index, di, entry);
  for (size_t n = 0; n < hn::Lanes(d); ++n)
    std::memcpy(looked_up + 4 * n, a.table + 4 * static_cast<size_t>(entry[n]), 4 * sizeof(float));
  hn::LoadInterleaved4(d, looked_up, r, g, b, extinction);
}

// x^n for whole n by squaring, else by logarithms; x in [0, 1].
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

// shade/light.h for a packet.
HWY_INLINE void light(const MarchPacketArgs& a, const Vector3& g, const Vector3& to_viewer, Vector3& color) {
  const V square = Dot(g.x, g.y, g.z, g.x, g.y, g.z);
  const M surface = hn::Gt(square, set(1e-36f));
  const V inverse = InverseRoot(hn::IfThenElse(surface, square, set(1.0f)));
  Vector3 scale{set(a.ambient), set(a.ambient), set(a.ambient)};
  Vector3 shine{hn::Zero(d), hn::Zero(d), hn::Zero(d)};
  for (int n = 0; n < a.light_count; ++n) {
    const MarchLight& l = a.lights[n];
    V facing, glint;
    if (l.headlight) {
      facing = hn::Mul(hn::Abs(Dot(g.x, g.y, g.z, to_viewer.x, to_viewer.y, to_viewer.z)), inverse);
      glint = facing;
    } else {
      const V lx = set(l.direction[0]), ly = set(l.direction[1]), lz = set(l.direction[2]);
      facing = hn::Mul(hn::Abs(Dot(g.x, g.y, g.z, lx, ly, lz)), inverse);
      const V hx = hn::Add(lx, to_viewer.x), hy = hn::Add(ly, to_viewer.y), hz = hn::Add(lz, to_viewer.z);
      const V over = InverseRoot(hn::Max(Dot(hx, hy, hz, hx, hy, hz), set(1e-12f)));
      glint = hn::Mul(hn::Mul(hn::Abs(Dot(g.x, g.y, g.z, hx, hy, hz)), inverse), over);
    }
    const V one = set(1.0f), least = set(a.least_cosine);
    glint = hn::Min(glint, one);
    const M shines = hn::And(surface, hn::Ge(glint, least));
    facing = hn::Mul(hn::IfThenElse(surface, hn::Min(facing, one), one), set(a.diffuse));
    glint = hn::Mul(hn::IfThenElseZero(shines, Power(hn::Max(glint, least), a.shininess)), set(a.specular));
    scale.x = hn::MulAdd(facing, set(l.color[0]), scale.x),
    shine.x = hn::MulAdd(glint, set(l.color[0]), shine.x);
    scale.y = hn::MulAdd(facing, set(l.color[1]), scale.y),
    shine.y = hn::MulAdd(glint, set(l.color[1]), shine.y);
    scale.z = hn::MulAdd(facing, set(l.color[2]), scale.z),
    shine.z = hn::MulAdd(glint, set(l.color[2]), shine.z);
  }
  color.x = hn::MulAdd(color.x, scale.x, shine.x), color.y = hn::MulAdd(color.y, scale.y, shine.y),
  color.z = hn::MulAdd(color.z, scale.z, shine.z);
}

#endif
} // namespace HWY_NAMESPACE
} // namespace bccsplat::bench
HWY_AFTER_NAMESPACE();

#endif

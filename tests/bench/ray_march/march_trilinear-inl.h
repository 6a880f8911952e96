// SPDX-License-Identifier: Apache-2.0
// Trilinear interpolation of the grid for a packet of points, lane by lane with gathers. The file is included
// once per target.
#include <array>

#include "tests/bench/ray_march/march_packet-inl.h"

#if defined(BCCSPLAT_MARCH_TRILINEAR_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef BCCSPLAT_MARCH_TRILINEAR_INL
#undef BCCSPLAT_MARCH_TRILINEAR_INL
#else
#define BCCSPLAT_MARCH_TRILINEAR_INL
#endif

HWY_BEFORE_NAMESPACE();
namespace bccsplat::bench {
namespace HWY_NAMESPACE {
#if HWY_TARGET != HWY_SCALAR

// Samples of the grid around a packet of points.
struct Fetch {
  const MarchPacketArgs& a;
  V fx, fy, fz;
  VI index;

  HWY_INLINE Fetch(const MarchPacketArgs& args, const Vector3& p) : a(args) {
    const VI x = hn::ConvertTo(di, p.x), y = hn::ConvertTo(di, p.y), z = hn::ConvertTo(di, p.z);
    fx = hn::Sub(p.x, hn::ConvertTo(d, x)), fy = hn::Sub(p.y, hn::ConvertTo(d, y)),
    fz = hn::Sub(p.z, hn::ConvertTo(d, z));
    index = hn::Add(hn::Add(x, hn::Set(di, a.origin)),
                    hn::Add(hn::Mul(y, hn::Set(di, a.row)), hn::Mul(z, hn::Set(di, a.plane))));
  }
  // Samples index + shift and the one after it: one gather of 64 bits each.
  HWY_INLINE void pair(int shift, V& first, V& second) const {
    const hn::Repartition<int64_t, D> d64;
    const hn::Half<DI> dh;
    const VI bytes = hn::ShiftLeft<2>(hn::Add(index, hn::Set(di, shift)));
    const auto* base = reinterpret_cast<const int64_t*>(a.value);
    const V low = hn::BitCast(d, hn::GatherOffset(d64, base, hn::PromoteTo(d64, hn::LowerHalf(dh, bytes))));
    const V high = hn::BitCast(d, hn::GatherOffset(d64, base, hn::PromoteTo(d64, hn::UpperHalf(dh, bytes))));
    first = hn::ConcatEven(d, high, low), second = hn::ConcatOdd(d, high, low);
  }
  HWY_INLINE V single(int shift) const {
    return hn::GatherIndex(d, a.value, hn::Add(index, hn::Set(di, shift)));
  }
  HWY_INLINE V along_x(int shift) const {
    V first, second;
    pair(shift, first, second);
    return lerp(first, second, fx);
  }
};

// The field as the marcher asks for it: values at a packet of points, then the gradient at the same points.
struct Trilinear {
  static constexpr bool lane_by_lane = false; // lanes nobody wants cost what the others do
  const MarchPacketArgs& a;
  std::array<V, 8> corner{}; // x + 2 y + 4 z

  HWY_INLINE explicit Trilinear(const MarchPacketArgs& args) : a(args) {}

  HWY_INLINE V value(const Vector3& p, M /*wanted*/) {
    const Fetch f(a, p);
    f.pair(0, corner[0], corner[1]), f.pair(a.row, corner[2], corner[3]);
    f.pair(a.plane, corner[4], corner[5]), f.pair(a.plane + a.row, corner[6], corner[7]);
    const V near = lerp(lerp(corner[0], corner[1], f.fx), lerp(corner[2], corner[3], f.fx), f.fy);
    const V far = lerp(lerp(corner[4], corner[5], f.fx), lerp(corner[6], corner[7], f.fx), f.fy);
    return lerp(near, far, f.fz);
  }
  HWY_INLINE V value_alone(const Vector3& p, M wanted) { return value(p, wanted); }

  // Twice the interpolated central differences, at the points of the last value().
  HWY_INLINE Vector3 gradient(const Vector3& p, M /*wanted*/) const {
    const Fetch f(a, p);
    const int row = a.row, plane = a.plane;
    Vector3 g;
    const auto x_row = [&](int shift, V c0, V c1) HWY_ATTR {
      const V before = f.single(shift - 1), after = f.single(shift + 2);
      return hn::Sub(lerp(c1, after, f.fx), lerp(before, c0, f.fx));
    };
    g.x =
        lerp(lerp(x_row(0, corner[0], corner[1]), x_row(row, corner[2], corner[3]), f.fy),
             lerp(x_row(plane, corner[4], corner[5]), x_row(plane + row, corner[6], corner[7]), f.fy), f.fz);
    const V r00 = lerp(corner[0], corner[1], f.fx), r10 = lerp(corner[2], corner[3], f.fx);
    const V r01 = lerp(corner[4], corner[5], f.fx), r11 = lerp(corner[6], corner[7], f.fx);
    const V y_before = lerp(f.along_x(-row), f.along_x(plane - row), f.fz);
    const V y_after = lerp(f.along_x(2 * row), f.along_x(plane + 2 * row), f.fz);
    g.y = hn::Sub(lerp(lerp(r10, r11, f.fz), y_after, f.fy), lerp(y_before, lerp(r00, r01, f.fz), f.fy));
    const V z_before = lerp(f.along_x(-plane), f.along_x(row - plane), f.fy);
    const V z_after = lerp(f.along_x(2 * plane), f.along_x(row + 2 * plane), f.fy);
    g.z = hn::Sub(lerp(lerp(r01, r11, f.fy), z_after, f.fz), lerp(z_before, lerp(r00, r10, f.fy), f.fz));
    return g;
  }
};

#endif
} // namespace HWY_NAMESPACE
} // namespace bccsplat::bench
HWY_AFTER_NAMESPACE();

#endif

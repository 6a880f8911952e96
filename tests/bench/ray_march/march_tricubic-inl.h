// SPDX-License-Identifier: Apache-2.0
// Cubic B-splines of the grid's coefficients for a packet of points: 64 taps each. Unlike trilinear samples
// they are taken point by point: four taps along x lie beside each other, so that a point is sixteen
// contiguous loads and no gather, and points that nobody wants cost nothing. The file is included once per
// target.
#include <array>

#include "tests/bench/ray_march/march_packet-inl.h"

#if defined(BCCSPLAT_MARCH_TRICUBIC_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef BCCSPLAT_MARCH_TRICUBIC_INL
#undef BCCSPLAT_MARCH_TRICUBIC_INL
#else
#define BCCSPLAT_MARCH_TRICUBIC_INL
#endif

HWY_BEFORE_NAMESPACE();
namespace bccsplat::bench {
namespace HWY_NAMESPACE {
#if HWY_TARGET != HWY_SCALAR && !HWY_HAVE_SCALABLE

// A plane of 4 x 4 taps is one vector of 16 lanes, or as many shorter ones as it takes.
struct Tricubic {
  static constexpr bool lane_by_lane = true;
  static constexpr size_t lanes = hn::MaxLanes(d), rows = lanes / 4, parts = 16 / lanes;
  using Spread = decltype(hn::SetTableIndices(d, static_cast<const int32_t*>(nullptr)));
  using Weights = std::array<V, 4>; // of four taps along an axis, for every point

  // What is kept of a point for its gradient.
  struct Kept {
    alignas(64) float sum[16];    // over z
    alignas(64) float slope[16];  // the same by the derivative along z
    alignas(64) float weight[16]; // of x times those of y
  };

  const MarchPacketArgs& a;
  std::array<Spread, parts> spread;
  std::array<Kept, lanes> kept;
  // Four numbers of each point.
  alignas(64) float wx[4 * lanes], wy[4 * lanes], wz[4 * lanes], dx[4 * lanes], dy[4 * lanes], dz[4 * lanes];
  alignas(64) int32_t corner[lanes]; // the first tap

  HWY_INLINE explicit Tricubic(const MarchPacketArgs& args) : a(args) {
    alignas(64) int32_t row[lanes];
    for (size_t part = 0; part < parts; ++part) {
      for (size_t n = 0; n < lanes; ++n) row[n] = static_cast<int32_t>(part * rows + n / 4);
      spread[part] = hn::SetTableIndices(d, row);
    }
  }

  HWY_INLINE V value(const Vector3& p, M wanted) { return values<true>(p, wanted); }
  HWY_INLINE V value_alone(const Vector3& p, M wanted) { return values<false>(p, wanted); }

  // At the points of the last value().
  HWY_INLINE Vector3 gradient(const Vector3& p, M wanted) {
    store(slopes(fraction(p.x)), dx), store(slopes(fraction(p.y)), dy);
    alignas(64) float x[lanes] = {}, y[lanes] = {}, z[lanes] = {};
    for_groups(wanted, [&](size_t group, uint32_t some) HWY_ATTR {
      std::array<V, 4> along_x, along_y, along_z;
      for (size_t n = 0; n < 4; ++n) {
        along_x[n] = along_y[n] = along_z[n] = hn::Zero(d);
        if (!(some >> n & 1)) continue;
        const size_t point = group + n;
        const Kept& k = kept[point];
        for (size_t part = 0; part < parts; ++part) {
          const V sum = hn::Load(d, k.sum + part * lanes);
          along_x[n] = hn::MulAdd(hn::Mul(four(dx, point), each_row(wy, point, part)), sum, along_x[n]);
          along_y[n] = hn::MulAdd(hn::Mul(four(wx, point), each_row(dy, point, part)), sum, along_y[n]);
          along_z[n] = hn::MulAdd(hn::Load(d, k.weight + part * lanes), hn::Load(d, k.slope + part * lanes),
                                  along_z[n]);
        }
      }
      store_sums(along_x, x + group), store_sums(along_y, y + group), store_sums(along_z, z + group);
    });
    return {hn::Load(d, x), hn::Load(d, y), hn::Load(d, z)};
  }

 private:
  static HWY_INLINE V fraction(V x) { return hn::Sub(x, hn::ConvertTo(d, hn::ConvertTo(di, x))); }

  static HWY_INLINE Weights weights(V t) {
    const V sixth = set(1.0f / 6), rest = hn::Sub(set(1.0f), t);
    Weights w;
    w[0] = hn::Mul(hn::Mul(sixth, rest), hn::Mul(rest, rest));
    w[3] = hn::Mul(hn::Mul(sixth, t), hn::Mul(t, t));
    w[1] = hn::MulAdd(hn::Mul(t, t), hn::MulAdd(set(0.5f), t, set(-1.0f)), set(2.0f / 3));
    w[2] = hn::Sub(set(1.0f), hn::Add(w[0], hn::Add(w[1], w[3])));
    return w;
  }
  static HWY_INLINE Weights slopes(V t) {
    const V half = set(0.5f), rest = hn::Sub(set(1.0f), t);
    Weights w;
    w[0] = hn::Neg(hn::Mul(hn::Mul(half, rest), rest));
    w[3] = hn::Mul(hn::Mul(half, t), t);
    w[1] = hn::Mul(t, hn::MulAdd(set(1.5f), t, set(-2.0f)));
    w[2] = hn::Neg(hn::Add(w[0], hn::Add(w[1], w[3])));
    return w;
  }
  static HWY_INLINE void store(const Weights& w, float* to) {
    hn::StoreInterleaved4(w[0], w[1], w[2], w[3], d, to);
  }

  // The four numbers of a point, again and again.
  static HWY_INLINE V four(const float* of, size_t point) { return hn::LoadDup128(d, of + 4 * point); }
  // Each of them four times.
  HWY_INLINE V each_row(const float* of, size_t point, size_t part) const {
    return hn::TableLookupLanes(four(of, point), spread[part]);
  }

  // Rows of four taps, one after the other.
  template<class Part> static HWY_INLINE hn::Vec<Part> load_rows(Part part, const float* from, size_t row) {
    if constexpr (hn::MaxLanes(Part()) == 4) {
      return hn::LoadU(part, from);
    } else {
      const hn::Half<Part> half;
      return hn::Combine(part, load_rows(half, from + hn::MaxLanes(half) / 4 * row, row),
                         load_rows(half, from, row));
    }
  }

  // Stores the sums of all lanes of four vectors.
  static HWY_INLINE void store_sums(const std::array<V, 4>& v, float* to) {
    const hn::Repartition<double, D> wide;
    const V first = hn::Add(hn::InterleaveLower(d, v[0], v[1]), hn::InterleaveUpper(d, v[0], v[1]));
    const V second = hn::Add(hn::InterleaveLower(d, v[2], v[3]), hn::InterleaveUpper(d, v[2], v[3]));
    const auto a_wide = hn::BitCast(wide, first), b_wide = hn::BitCast(wide, second);
    store_block(d,
                hn::Add(hn::BitCast(d, hn::InterleaveLower(wide, a_wide, b_wide)),
                        hn::BitCast(d, hn::InterleaveUpper(wide, a_wide, b_wide))),
                to);
  }
  // Stores the sum of the blocks of four lanes.
  template<class Part> static HWY_INLINE void store_block(Part part, hn::Vec<Part> v, float* to) {
    if constexpr (hn::MaxLanes(Part()) == 4) {
      hn::StoreU(v, part, to);
    } else {
      const hn::Half<Part> half;
      store_block(half, hn::Add(hn::LowerHalf(half, v), hn::UpperHalf(half, v)), to);
    }
  }

  // Calls body(first, some) for every four points of which some are wanted, a bit each.
  template<class Body> static HWY_INLINE void for_groups(M wanted, const Body& body) {
    uint8_t bytes[8] = {};
    hn::StoreMaskBits(d, wanted, bytes);
    const uint32_t bits = bytes[0] | static_cast<uint32_t>(bytes[1]) << 8;
    for (size_t group = 0; group < lanes; group += 4)
      if (const uint32_t some = bits >> group & 15) body(group, some);
  }

  template<bool keep> HWY_INLINE V values(const Vector3& p, M wanted) {
    const VI x = hn::ConvertTo(di, p.x), y = hn::ConvertTo(di, p.y), z = hn::ConvertTo(di, p.z);
    const VI place = hn::Add(x, hn::Add(hn::Mul(y, hn::Set(di, a.row)), hn::Mul(z, hn::Set(di, a.plane))));
    hn::Store(hn::Add(place, hn::Set(di, a.origin - 1 - a.row - a.plane)), di, corner);
    const V fz = hn::Sub(p.z, hn::ConvertTo(d, z));
    store(weights(hn::Sub(p.x, hn::ConvertTo(d, x))), wx),
        store(weights(hn::Sub(p.y, hn::ConvertTo(d, y))), wy);
    store(weights(fz), wz);
    if (keep) store(slopes(fz), dz);
    alignas(64) float found[lanes] = {};
    for_groups(wanted, [&](size_t group, uint32_t some) HWY_ATTR {
      std::array<V, 4> sums;
      for (size_t n = 0; n < 4; ++n) sums[n] = some >> n & 1 ? point_sum<keep>(group + n) : hn::Zero(d);
      store_sums(sums, found + group);
    });
    return hn::Load(d, found);
  }

  // Lanes whose sum is the value at a point.
  template<bool keep> HWY_INLINE V point_sum(size_t point) {
    const size_t row = a.row, plane = a.plane;
    const float* const taps = a.value + corner[point];
    const float* const w = wz + 4 * point;
    const float* const by = dz + 4 * point;
    Kept& k = kept[point];
    V out = hn::Zero(d);
    for (size_t part = 0; part < parts; ++part) {
      const float* const from = taps + part * rows * row;
      V sum = hn::Zero(d), slope = hn::Zero(d);
      for (size_t z = 0; z < 4; ++z) {
        const V value = load_rows(d, from + z * plane, row);
        sum = hn::MulAdd(value, set(w[z]), sum);
        if (keep) slope = hn::MulAdd(value, set(by[z]), slope);
      }
      const V weight = hn::Mul(four(wx, point), each_row(wy, point, part));
      if (keep) {
        hn::Store(sum, d, k.sum + part * lanes), hn::Store(slope, d, k.slope + part * lanes);
        hn::Store(weight, d, k.weight + part * lanes);
      }
      out = hn::MulAdd(sum, weight, out);
    }
    return out;
  }
};

#endif
} // namespace HWY_NAMESPACE
} // namespace bccsplat::bench
HWY_AFTER_NAMESPACE();

#endif

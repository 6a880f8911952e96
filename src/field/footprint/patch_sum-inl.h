// SPDX-License-Identifier: Apache-2.0
// The arithmetic of footprints for as many points as a vector has lanes: weights of the sites of a patch, and
// what the weighted sites add up to. Included once per target.
#if defined(BCCSPLAT_SLICE_PATCH_SUM_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef BCCSPLAT_SLICE_PATCH_SUM_INL_H
#undef BCCSPLAT_SLICE_PATCH_SUM_INL_H
#else
#define BCCSPLAT_SLICE_PATCH_SUM_INL_H
#endif

#include <hwy/highway.h>

#include "field/footprint/footprint.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace {

// A lane is a point. Every operation is the same for all lanes, so that a point's sum does not depend on
// which others share its vector.
using Lanes = hn::CappedTag<float, 16>;
using Floats = hn::Vec<Lanes>;
inline constexpr size_t lanes = hn::MaxLanes(Lanes());
HWY_INLINE Floats Set(float v) { return hn::Set(Lanes(), v); }

// phi(r) = sum of c[j] u^j, u = 1 - r^2 scale, and dphi/du, in registers where there are enough.
// `contact`: phi = u^2 (c[2] + .. + c[7] u^5), the form of every kernel but the Gaussians.
template<bool contact> struct Curve {
  Floats scale, c[8], d[8]; // d[j] = j c[j]

  HWY_INLINE explicit Curve(const FootprintPlan& plan) {
    scale = Set(plan.inverse_radius2);
    for (size_t j = 0; j < 8; ++j) {
      c[j] = Set(contact ? plan.a[j] : 0);
      d[j] = hn::Mul(Set(static_cast<float>(j)), c[j]);
    }
  }
};

// Sums over the patches of a point's cosets: weighted sites; with slopes also those in d/dt, and
// sites * dphi/du * distance per axis.
template<int edge, bool slopes> struct Sums { Floats value[edge]; };
template<int edge> struct Sums<edge, true> { Floats value[edge], x[edge], y, z, time; };
template<int edge, bool slopes> HWY_INLINE Sums<edge, slopes> NoSums() {
  Sums<edge, slopes> s;
  const auto zero = Set(0);
  for (auto& v : s.value) v = zero;
  if constexpr (slopes) {
    for (auto& v : s.x) v = zero;
    s.y = s.z = s.time = zero;
  }
  return s;
}
// The sum over the lanes along x.
template<int edge> HWY_INLINE Floats Total(const Floats (&v)[edge]) {
  const auto low = hn::Add(v[0], v[1]);
  return hn::Add(low, edge == 3 ? v[2] : hn::Add(v[2], v[edge - 1]));
}

// How far the points of a vector are from the first site of their patches, in coset pitches.
struct Place {
  const float *x, *y, *z;
};

// The sites of the points' patches: site (x, y, z) of lane i at ((z * edge + y) * edge + x) * lanes + i;
// rate: weighted by the temporal slopes.
struct LaneSites {
  alignas(64) std::array<float, patch_sites * lanes> value;
  alignas(64) std::array<float, patch_sites * lanes> rate;
};

template<int edge, bool timed> struct StoredRows {
  const LaneSites& sites;
  HWY_INLINE void operator()(size_t z, size_t y, Floats (&value)[edge], Floats (&rate)[edge]) const {
    for (size_t x = 0; x < edge; ++x) {
      const size_t at = ((z * edge + y) * edge + x) * lanes;
      value[x] = hn::Load(Lanes(), sites.value.data() + at);
      if constexpr (timed) rate[x] = hn::Load(Lanes(), sites.rate.data() + at);
    }
  }
};

// Adds the patches of one coset. rows(z, y, value, rate) loads a row of sites; timed: with their rates.
template<int edge, bool slopes, bool timed, bool contact, class Rows>
HWY_INLINE void AddPatches(const FootprintPlan& plan, const Curve<contact>& curve, const Rows& rows,
                           const Place& place, Sums<edge, slopes>& sums) {
  const Lanes d;
  const auto zero = hn::Zero(d), one = Set(1);
  const auto distance = [&](const float* from, int site)
                            HWY_ATTR { return hn::Sub(hn::Load(d, from), Set(static_cast<float>(site))); };
  Floats near_x[edge], part_y[edge];
  [[maybe_unused]] Floats along_x[edge];
  for (int x = 0; x < edge; ++x) {
    const auto dx = distance(place.x, x), dy = distance(place.y, x);
    near_x[x] = hn::NegMulAdd(curve.scale, hn::Mul(dx, dx), one);
    part_y[x] = hn::Mul(curve.scale, hn::Mul(dy, dy));
    along_x[x] = zero;
  }
  for (int z = 0; z < edge; ++z) {
    const auto dz = distance(place.z, z);
    const auto part_z = hn::Mul(curve.scale, hn::Mul(dz, dz));
    [[maybe_unused]] Floats plane = zero;
    for (int y = 0; y < edge; ++y) {
      const auto away = hn::Add(part_y[y], part_z);
      // Out of reach of all: where points lie in rows, that is one row of sites in three.
      if (hn::AllFalse(d, hn::Lt(away, one))) continue;
      Floats value[edge], rate[edge];
      rows(z, y, value, rate);
      Floats u[edge], phi[edge], slope[edge], reached[edge];
      for (int x = 0; x < edge; ++x) u[x] = hn::Sub(near_x[x], away);
      if constexpr (contact) {
        // Out of reach u = 0, and with it value and slope.
        for (int x = 0; x < edge; ++x) {
          u[x] = hn::Max(u[x], zero);
          phi[x] = hn::MulAdd(curve.c[7], u[x], curve.c[6]);
          if (slopes) slope[x] = hn::MulAdd(curve.d[7], u[x], curve.d[6]);
        }
        for (size_t j = 5; j >= 2; --j)
          for (int x = 0; x < edge; ++x) {
            phi[x] = hn::MulAdd(phi[x], u[x], curve.c[j]);
            if (slopes) slope[x] = hn::MulAdd(slope[x], u[x], curve.d[j]);
          }
        for (int x = 0; x < edge; ++x) {
          phi[x] = hn::Mul(phi[x], u[x]);
          reached[x] = u[x];
        }
      } else {
        for (int x = 0; x < edge; ++x) {
          phi[x] = Set(plan.a[static_cast<size_t>(plan.terms) - 1]);
          slope[x] = zero;
        }
        for (int j = plan.terms - 2; j >= 0; --j) {
          const auto a = Set(plan.a[j]);
          for (int x = 0; x < edge; ++x) {
            if (slopes) slope[x] = hn::MulAdd(slope[x], u[x], phi[x]);
            phi[x] = hn::MulAdd(phi[x], u[x], a);
          }
        }
        for (int x = 0; x < edge; ++x) reached[x] = hn::IfThenElseZero(hn::Gt(u[x], zero), one);
      }
      Floats steep[edge];
      for (int x = 0; x < edge; ++x) {
        const auto site = hn::Mul(value[x], reached[x]);
        sums.value[x] = hn::MulAdd(phi[x], site, sums.value[x]);
        if constexpr (slopes) {
          if constexpr (timed) {
            const auto change = hn::Mul(rate[x], reached[x]);
            sums.time = hn::MulAdd(phi[x], change, sums.time);
          }
          steep[x] = hn::Mul(slope[x], site);
          along_x[x] = hn::Add(along_x[x], steep[x]);
        }
      }
      if constexpr (slopes) {
        const auto row = Total(steep);
        sums.y = hn::MulAdd(row, distance(place.y, y), sums.y);
        plane = hn::Add(plane, row);
      }
    }
    if constexpr (slopes) sums.z = hn::MulAdd(plane, dz, sums.z);
  }
  if constexpr (slopes)
    for (int x = 0; x < edge; ++x) sums.x[x] = hn::MulAdd(along_x[x], distance(place.x, x), sums.x[x]);
}

// Weights of the layers of a coset at `from` = (t - time of the first one) / pitch, and their slopes per
// pitch. Splines of order 1 to 4 in the fraction between knots, with their bends (kernel.h).
template<bool slopes>
HWY_INLINE void WeighSpline(int order, const std::array<float, 2>& bend, Floats from, Floats (&w)[max_stack],
                            Floats (&dw)[max_stack]) {
  const auto times = [](Floats a, Floats b) HWY_ATTR { return hn::Mul(a, b); };
  const auto plus = [](Floats a, Floats b) HWY_ATTR { return hn::Add(a, b); };
  const auto minus = [](Floats a, Floats b) HWY_ATTR { return hn::Sub(a, b); };
  const auto one = Set(1), two = Set(2), half = Set(0.5f);
  const auto g = minus(from, Set(0.5f * static_cast<float>(order) - 1)), h = minus(one, g);
  const auto outer = Set(bend[0]), middle = Set(bend[1]);
  const auto x = minus(one, times(two, g)), z = minus(one, times(x, x));
  switch (order) {
  case 1:
    w[0] = one, dw[0] = Set(0);
    break;
  case 2: {
    const auto bent = times(middle, times(x, z));
    w[0] = plus(h, bent), w[1] = minus(g, bent);
    if (slopes) {
      dw[1] = plus(one, times(times(two, middle), minus(z, times(two, times(x, x)))));
      dw[0] = hn::Neg(dw[1]);
    }
    break;
  }
  case 3: {
    const auto bent = [&](Floats u, Floats v) HWY_ATTR { // u^2 v (outer (2 u - 1) + middle)
      return times(times(times(u, u), v), plus(times(outer, minus(times(two, u), one)), middle));
    };
    const auto first = bent(h, g), last = bent(g, h);
    w[0] = plus(times(half, times(h, h)), first), w[2] = plus(times(half, times(g, g)), last);
    w[1] = minus(plus(half, times(g, h)), plus(first, last));
    if (slopes) {
      const auto rise = [&](Floats u) HWY_ATTR {
        const auto outside = plus(two, times(u, minus(times(Set(8), u), Set(9))));
        return times(u, minus(times(middle, minus(two, times(Set(3), u))), times(outer, outside)));
      };
      dw[0] = minus(hn::Neg(h), rise(h)), dw[2] = plus(g, rise(g));
      dw[1] = hn::Neg(plus(dw[0], dw[2]));
    }
    break;
  }
  default: {
    const auto sixth = Set(1.0f / 6), third2 = Set(2.0f / 3);
    const auto g2 = times(g, g), h2 = times(h, h);
    const auto ends = times(outer, times(g2, h2)), passes = times(middle, times(x, times(z, z)));
    w[0] = plus(times(sixth, times(h, h2)), ends), w[3] = plus(times(sixth, times(g, g2)), ends);
    w[1] = plus(minus(minus(third2, times(g2, minus(one, times(half, g)))), ends), passes);
    w[2] = minus(minus(minus(third2, times(h2, minus(one, times(half, h)))), ends), passes);
    if (slopes) {
      const auto rise = times(times(two, outer), times(times(g, h), minus(h, g)));
      const auto rate = times(times(two, middle), times(z, minus(z, times(Set(4), times(x, x)))));
      dw[0] = plus(hn::Neg(times(half, h2)), rise), dw[3] = plus(times(half, g2), rise);
      dw[1] = minus(minus(times(g, minus(times(Set(1.5f), g), two)), rise), rate);
      dw[2] = plus(minus(times(h, minus(two, times(Set(1.5f), h))), rise), rate);
    }
    break;
  }
  }
}

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#endif

// The arithmetic of one patch, for the target being compiled: included once per target.
#if defined(BCCSPLAT_SLICE_PATCH_SUM_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef BCCSPLAT_SLICE_PATCH_SUM_INL_H
#undef BCCSPLAT_SLICE_PATCH_SUM_INL_H
#else
#define BCCSPLAT_SLICE_PATCH_SUM_INL_H
#endif

#include <hwy/highway.h>

#include "slice/footprint.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace {

// Four neighbours along x: one vector, or several where vectors are shorter.
using RowTag = hn::CappedTag<float, patch_edge>;
inline constexpr size_t row_step = hn::MaxLanes(RowTag());
inline constexpr size_t row_parts = patch_edge / row_step;
struct Row {
  hn::Vec<RowTag> part[row_parts];
};
HWY_INLINE Row SetRow(float v) {
  Row r;
  for (auto& part : r.part) part = hn::Set(RowTag(), v);
  return r;
}
HWY_INLINE Row LoadRow(const float* p) {
  Row r;
  for (size_t i = 0; i < row_parts; ++i) r.part[i] = hn::LoadU(RowTag(), p + i * row_step);
  return r;
}
HWY_INLINE void StoreRow(const Row& r, float* p) {
  for (size_t i = 0; i < row_parts; ++i) hn::StoreU(r.part[i], RowTag(), p + i * row_step);
}
HWY_INLINE Row Times(const Row& a, const Row& b) {
  Row r;
  for (size_t i = 0; i < row_parts; ++i) r.part[i] = hn::Mul(a.part[i], b.part[i]);
  return r;
}
HWY_INLINE Row Plus(const Row& a, const Row& b) {
  Row r;
  for (size_t i = 0; i < row_parts; ++i) r.part[i] = hn::Add(a.part[i], b.part[i]);
  return r;
}
HWY_INLINE Row TimesPlus(const Row& a, const Row& b, const Row& c) {
  Row r;
  for (size_t i = 0; i < row_parts; ++i) r.part[i] = hn::MulAdd(a.part[i], b.part[i], c.part[i]);
  return r;
}
// The sum of all lanes of both, in double: rounded once, it does not depend on which lane a site stood in.
template<class R> // a template: only the branch that fits the target is compiled
HWY_INLINE float Total(const R& a, const R& b) {
  const hn::CappedTag<double, patch_edge> d;
  if constexpr (hn::MaxLanes(d) == patch_edge && row_parts == 1) {
    return static_cast<float>(
        hn::GetLane(hn::SumOfLanes(d, hn::Add(hn::PromoteTo(d, a.part[0]), hn::PromoteTo(d, b.part[0])))));
  } else {
    alignas(16) std::array<float, 2 * patch_edge> lanes;
    for (size_t i = 0; i < row_parts; ++i) {
      hn::Store(a.part[i], RowTag(), lanes.data() + i * row_step);
      hn::Store(b.part[i], RowTag(), lanes.data() + patch_edge + i * row_step);
    }
    double sum = 0;
    for (const float v : lanes) sum += static_cast<double>(v);
    return static_cast<float>(sum);
  }
}

// Weights of the sites of a patch, z*16 + y*4 + x, for lengths in coset pitches; slope is d weight / d(r^2).
struct Weights {
  alignas(64) std::array<float, patch_sites> value;
  alignas(64) std::array<float, patch_sites> slope;
};

// Where a point stands: `from` its first site strictly in reach, which is site `shift` of the patch, per
// axis. Whatever the shift, the same distances come out, bit for bit.
struct Place {
  std::array<float, 3> from;
  std::array<float, 3> shift{};
  [[nodiscard]] HWY_INLINE float distance(size_t axis, int site) const {
    return from[axis] - (static_cast<float>(site) - shift[axis]);
  }
};

// The polynomial of phi and the places of the sites of a plane, in registers where there are enough.
// `contact`: phi = u^2 (c[2] + .. + c[7] u^5), the form of every kernel but the Gaussians.
template<bool contact> struct Curve {
  using D = hn::CappedTag<float, patch_rows>;
  using V = hn::Vec<D>;
  static constexpr size_t parts = patch_rows / hn::MaxLanes(D());
  V scale, x[parts], y[parts], c[8]; // x, y: of each lane, in pitches

  HWY_INLINE explicit Curve(const FootprintPlan& plan) {
    const D d;
    scale = hn::Set(d, plan.inverse_radius2);
    for (size_t i = 0; i < parts; ++i) {
      x[i] = hn::Load(d, plan.lane_x.data() + i * hn::MaxLanes(d));
      y[i] = hn::Load(d, plan.lane_y.data() + i * hn::MaxLanes(d));
    }
    for (size_t j = 0; j < 8; ++j) c[j] = contact ? hn::Set(d, plan.a[j]) : hn::Zero(d);
  }
};

template<int edge, bool slopes, bool contact>
HWY_INLINE void Weigh(const FootprintPlan& plan, const Curve<contact>& curve, const Place& p,
                      Weights& weights) {
  const typename Curve<contact>::D d;
  constexpr size_t lanes = hn::MaxLanes(typename Curve<contact>::D());
  const auto zero = hn::Zero(d), one = hn::Set(d, 1.0f);
  const auto shift_x = hn::Set(d, p.shift[0]), shift_y = hn::Set(d, p.shift[1]);
  const auto from_x = hn::Set(d, p.from[0]), from_y = hn::Set(d, p.from[1]);
  // One plane of the patch at a time, (y, x) in the lanes.
  for (size_t part = 0; part * lanes < patch_edge * edge; ++part) {
    const auto x = hn::Sub(from_x, hn::Sub(curve.x[part], shift_x));
    const auto y = hn::Sub(from_y, hn::Sub(curve.y[part], shift_y));
    const auto u_xy = hn::NegMulAdd(curve.scale, hn::MulAdd(x, x, hn::Mul(y, y)), one);
    hn::Vec<decltype(d)> u[edge], value[edge], slope[edge];
    for (int z = 0; z < edge; ++z) {
      const float dz = p.distance(2, z);
      u[z] = hn::NegMulAdd(curve.scale, hn::Set(d, dz * dz), u_xy);
    }
    if constexpr (contact) {
      // Out of reach u = 0, and with it value and slope.
      for (int z = 0; z < edge; ++z) {
        u[z] = hn::Max(u[z], zero);
        value[z] = hn::MulAdd(curve.c[7], u[z], curve.c[6]);
        slope[z] = curve.c[7];
      }
      for (size_t j = 5; j >= 2; --j)
        for (int z = 0; z < edge; ++z) {
          if (slopes) slope[z] = hn::MulAdd(slope[z], u[z], value[z]);
          value[z] = hn::MulAdd(value[z], u[z], curve.c[j]);
        }
      for (int z = 0; z < edge; ++z) {
        if (slopes) slope[z] = hn::MulAdd(slope[z], u[z], value[z]);
        value[z] = hn::Mul(value[z], u[z]);
        if (slopes) slope[z] = hn::MulAdd(slope[z], u[z], value[z]);
        value[z] = hn::Mul(value[z], u[z]);
      }
    } else {
      for (int z = 0; z < edge; ++z) {
        value[z] = hn::Set(d, plan.a[static_cast<size_t>(plan.terms) - 1]);
        slope[z] = zero;
      }
      for (int j = plan.terms - 2; j >= 0; --j) {
        const auto a = hn::Set(d, plan.a[static_cast<size_t>(j)]);
        for (int z = 0; z < edge; ++z) {
          if (slopes) slope[z] = hn::MulAdd(slope[z], u[z], value[z]);
          value[z] = hn::MulAdd(value[z], u[z], a);
        }
      }
      for (int z = 0; z < edge; ++z) {
        const auto inside = hn::Gt(u[z], zero);
        value[z] = hn::IfThenElseZero(inside, value[z]);
        if (slopes) slope[z] = hn::IfThenElseZero(inside, slope[z]);
      }
    }
    for (int z = 0; z < edge; ++z) {
      const size_t at = static_cast<size_t>(patch_rows * z) + part * lanes;
      hn::Store(value[z], d, weights.value.data() + at);
      if (slopes) hn::Store(hn::Mul(slope[z], hn::Neg(curve.scale)), d, weights.slope.data() + at);
    }
  }
}

// What a point's patches add up to, 4 lanes along x: the weighted sites; with slopes also those times the
// distance per axis, and those weighted in d/dt.
template<bool slopes> struct Sums { Row value; };
template<> struct Sums<true> { Row value, x, y, z, time; };
template<bool slopes> HWY_INLINE Sums<slopes> NoSums() {
  Sums<slopes> s;
  s.value = SetRow(0);
  if constexpr (slopes) s.x = s.y = s.z = s.time = SetRow(0);
  return s;
}

// The layers of one coset that take part at a point: `count` corners of a patch and their weights in time.
struct Stack {
  int count = 0;
  std::array<const float*, max_stack> corner;
  std::array<float, max_stack> weight, slope;
};

// Adds one patch, row (y, z) of layer k at row_of(k, y, z).
// weighted: false where the only layer weighs 1.
template<int edge, int count, bool slopes, bool weighted = true, class RowOf>
HWY_INLINE Sums<slopes> AddPatch(const Stack& stack, const RowOf& row_of, const Weights& weights,
                                 const Place& p, Sums<slopes> sums) {
  Row w[count], dw[count];
  for (int k = 0; k < count; ++k) {
    w[k] = SetRow(stack.weight[static_cast<size_t>(k)]);
    if (slopes) dw[k] = SetRow(stack.slope[static_cast<size_t>(k)]);
  }
  [[maybe_unused]] Row along_y[edge], all = SetRow(0);
  for (int z = 0; z < edge; ++z) {
    [[maybe_unused]] Row value = SetRow(0), rate = SetRow(0), plane = SetRow(0);
    for (int y = 0; y < edge; ++y) {
      const int r = patch_edge * z + y;
      const Row first = LoadRow(row_of(0, static_cast<size_t>(y), static_cast<size_t>(z)));
      Row c = weighted ? Times(w[0], first) : first, dc;
      if (slopes && weighted) dc = Times(dw[0], first);
      for (int k = 1; k < count; ++k) {
        const Row row =
            LoadRow(row_of(static_cast<size_t>(k), static_cast<size_t>(y), static_cast<size_t>(z)));
        c = TimesPlus(w[k], row, c);
        if (slopes) dc = TimesPlus(dw[k], row, dc);
      }
      const Row weight = LoadRow(weights.value.data() + patch_edge * r);
      value = TimesPlus(c, weight, value);
      if constexpr (slopes) {
        if (weighted) rate = TimesPlus(dc, weight, rate);
        const Row steep = Times(c, LoadRow(weights.slope.data() + patch_edge * r));
        along_y[y] = z == 0 ? steep : Plus(along_y[y], steep);
        plane = Plus(plane, steep);
      }
    }
    sums.value = Plus(sums.value, value);
    if constexpr (slopes) {
      if (weighted) sums.time = Plus(sums.time, rate);
      all = Plus(all, plane);
      sums.z = TimesPlus(plane, SetRow(p.distance(2, z)), sums.z);
    }
  }
  if constexpr (slopes) {
    for (int y = 0; y < edge; ++y) sums.y = TimesPlus(along_y[y], SetRow(p.distance(1, y)), sums.y);
    std::array<float, patch_edge> along_x;
    for (int x = 0; x < patch_edge; ++x) along_x[static_cast<size_t>(x)] = p.distance(0, x);
    sums.x = TimesPlus(all, LoadRow(along_x.data()), sums.x);
  }
  return sums;
}

template<int edge, bool slopes, class RowOf>
HWY_INLINE Sums<slopes> AddStack(const Stack& stack, const RowOf& row_of, const Weights& weights,
                                 const Place& p, Sums<slopes> sums) {
  switch (stack.count) {
  case 1:
    return AddPatch<edge, 1, slopes>(stack, row_of, weights, p, sums);
  case 2:
    return AddPatch<edge, 2, slopes>(stack, row_of, weights, p, sums);
  case 3:
    return AddPatch<edge, 3, slopes>(stack, row_of, weights, p, sums);
  default:
    return AddPatch<edge, 4, slopes>(stack, row_of, weights, p, sums);
  }
}

// Weights of the layers of a coset at `from` = (t - time of the first one) / pitch, and their slopes per
// pitch. B-splines of order 2 to 4 in the fraction between knots; the value is never negative.
template<bool slopes>
HWY_INLINE void WeighSpline(int order, float from, std::array<float, max_stack>& w,
                            std::array<float, max_stack>& dw) {
  const float g = from - (0.5f * static_cast<float>(order) - 1), h = 1 - g;
  switch (order) {
  case 1:
    w[0] = 1, dw[0] = 0;
    break;
  case 2:
    w[0] = h, w[1] = g;
    dw[0] = -1, dw[1] = 1;
    break;
  case 3:
    w[0] = 0.5f * h * h, w[2] = 0.5f * g * g, w[1] = 0.5f + g * h;
    if (slopes) dw[0] = -h, dw[2] = g, dw[1] = h - g;
    break;
  default:
    constexpr float sixth = 1.0f / 6, third2 = 2.0f / 3;
    w[0] = sixth * h * h * h, w[3] = sixth * g * g * g;
    w[1] = third2 - g * g * (1 - 0.5f * g), w[2] = third2 - h * h * (1 - 0.5f * h);
    if (slopes)
      dw[0] = -0.5f * h * h, dw[3] = 0.5f * g * g, dw[1] = g * (1.5f * g - 2), dw[2] = h * (2 - 1.5f * h);
    break;
  }
}

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#endif

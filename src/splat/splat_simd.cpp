// Points into the ring, through Highway: one body, compiled for every target, the best chosen at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/splat_simd.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <algorithm>

#include "splat/kernels.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR
// No vectors: the plain loops.
void Splat(const SplatArgs& s) { scalar_kernels().splat(s); }
#else

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, 16>; // 4 sheets x 4, 2 or 1 pixels
using V = hn::Vec<D>;
constexpr D d;
HWY_INLINE int pixels_per_vector() { return static_cast<int>(hn::Lanes(d)) / 4; }

// Four sheets, repeated for every pixel of a vector.
HWY_INLINE V repeat4(const float* p) { return hn::LoadDup128(d, p); }

alignas(64) constexpr float lane_pixel[16] = {0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3};

// The kernel's polynomial with the point's coefficient multiplied in, and its slope.
template<bool kSquare8> struct Weights;

// a_2 u^2 + ... + a_7 u^7: all radial kernels.
template<> struct Weights<true> {
  V a2, a3, a4, a5, a6, a7;
  HWY_INLINE Weights(const KernelPolynomial&, const std::array<float, RadialKernel::max_terms>& a, float c) {
    a2 = hn::Set(d, c * a[2]), a3 = hn::Set(d, c * a[3]), a4 = hn::Set(d, c * a[4]);
    a5 = hn::Set(d, c * a[5]), a6 = hn::Set(d, c * a[6]), a7 = hn::Set(d, c * a[7]);
  }
  HWY_INLINE V add(V u, V sum) const {
    const V q =
        hn::MulAdd(hn::MulAdd(hn::MulAdd(hn::MulAdd(hn::MulAdd(a7, u, a6), u, a5), u, a4), u, a3), u, a2);
    return hn::MulAdd(hn::Mul(u, u), q, sum);
  }
  // slope = u (2 a_2 + 3 a_3 u + ...)
  HWY_INLINE V slope(V u) const {
    V q = hn::MulAdd(hn::Mul(hn::Set(d, 7.0f), a7), u, hn::Mul(hn::Set(d, 6.0f), a6));
    q = hn::MulAdd(q, u, hn::Mul(hn::Set(d, 5.0f), a5));
    q = hn::MulAdd(q, u, hn::Mul(hn::Set(d, 4.0f), a4));
    q = hn::MulAdd(q, u, hn::Mul(hn::Set(d, 3.0f), a3));
    q = hn::MulAdd(q, u, hn::Add(a2, a2));
    return hn::Mul(q, u);
  }
};

template<> struct Weights<false> {
  const KernelPolynomial& kernel;
  V c;
  HWY_INLINE Weights(const KernelPolynomial& k, const std::array<float, RadialKernel::max_terms>&,
                     float coefficient)
      : kernel(k), c(hn::Set(d, coefficient)) {}
  HWY_INLINE V add(V u, V sum) const {
    V q = hn::Set(d, kernel.a[static_cast<size_t>(kernel.terms) - 1]);
    for (int j = kernel.terms - 2; j >= 0; --j)
      q = hn::MulAdd(q, u, hn::Set(d, kernel.a[static_cast<size_t>(j)]));
    // phi(0) need not vanish: nothing outside the radius.
    return hn::MulAdd(c, hn::IfThenElseZero(hn::Gt(u, hn::Zero(d)), q), sum);
  }
  HWY_INLINE V slope(V u) const {
    V q = hn::Set(d, kernel.slope[static_cast<size_t>(kernel.terms) - 2]);
    for (int j = kernel.terms - 3; j >= 0; --j)
      q = hn::MulAdd(q, u, hn::Set(d, kernel.slope[static_cast<size_t>(j)]));
    return hn::Mul(c, hn::IfThenElseZero(hn::Gt(u, hn::Zero(d)), q));
  }
};

template<bool kIsotropic, bool kGradient, bool kSquare8> void SplatGeneral(const SplatArgs& s) {
  const int vp = pixels_per_vector();
  const auto step = static_cast<size_t>(s.pitch) * 4;
  const V pixel = hn::Load(d, lane_pixel), one = hn::Set(d, 1.0f), zero = hn::Zero(d),
          depth2 = hn::Set(d, s.depth2);
  const SlabLanes& lanes = *s.lanes;
  for (size_t n = 0; n < s.count; ++n) {
    const SplatRecord& p = s.record[n];
    const int r0 = std::max(0, -p.y), r1 = std::min(s.rows, s.height - p.y);
    // Vectors of the window that touch the tile; they may hang over into the spare pixels.
    const int v0 = p.x >= 0 ? 0 : (-p.x) / vp * vp, v1 = std::min(s.columns, s.width - p.x);
    const V fx = hn::Set(d, p.fx), z = hn::Set(d, p.z);
    const Weights<kSquare8> weights(*s.kernel, s.kernel->a, p.c);
    const std::ptrdiff_t start = (static_cast<std::ptrdiff_t>(p.y + r0) * s.pitch + p.x) * 4;
    for (int g = 0; g < s.groups; ++g) {
      const V dk = hn::Sub(repeat4(lanes.offset + 4 * g), z);
      const V height = hn::NegMulAdd(hn::Mul(dk, depth2), dk, one);
      const V xx = repeat4(lanes.xx + 4 * g), yy = repeat4(lanes.yy + 4 * g),
              reach = repeat4(lanes.reach + 4 * g);
      V x_shift = fx, y_foot = hn::Set(d, p.fy), xy = zero;
      if constexpr (!kIsotropic) {
        const V delta = repeat4(lanes.delta + 4 * g);
        x_shift = hn::MulAdd(hn::Set(d, p.lateral_x), delta, fx);
        y_foot = hn::MulAdd(hn::Set(d, p.lateral_y), delta, y_foot);
        xy = repeat4(lanes.xy + 4 * g);
      }
      const std::ptrdiff_t base = start + g * static_cast<std::ptrdiff_t>(s.group_floats);
      for (int v = v0; v < v1; v += vp) {
        const V di = hn::Sub(hn::Add(pixel, hn::Set(d, static_cast<float>(v))), x_shift);
        // No row of these columns and sheets is in reach.
        if (hn::AllFalse(d, hn::Gt(hn::NegMulAdd(hn::Mul(di, reach), di, height), zero))) continue;
        const V level = hn::NegMulAdd(hn::Mul(di, xx), di, height);
        const V slant = hn::Mul(di, xy);
        float* sum = s.ring[0] + base + 4 * v;
        for (int r = r0; r < r1; ++r, sum += step) {
          const V dj = hn::Sub(hn::Set(d, static_cast<float>(r)), y_foot);
          const V across = kIsotropic ? hn::Mul(dj, yy) : hn::MulAdd(dj, yy, slant);
          const V u = hn::Max(hn::NegMulAdd(across, dj, level), zero);
          hn::StoreU(weights.add(u, hn::LoadU(d, sum)), d, sum);
          if constexpr (kGradient) {
            const std::ptrdiff_t at = sum - s.ring[0];
            const V w = weights.slope(u);
            hn::StoreU(hn::MulAdd(w, di, hn::LoadU(d, s.ring[1] + at)), d, s.ring[1] + at);
            hn::StoreU(hn::MulAdd(w, dj, hn::LoadU(d, s.ring[2] + at)), d, s.ring[2] + at);
            hn::StoreU(hn::MulAdd(w, dk, hn::LoadU(d, s.ring[3] + at)), d, s.ring[3] + at);
          }
        }
      }
    }
  }
}

// The same for u = level - yy dj^2, level constant down the rows, and the radial kernels' polynomial
//   phi = u^2 ((a2 + a3 u) + u^2 ((a4 + a5 u) + u^2 (a6 + a7 u))):
// nine operations per vector. What is known per row goes through memory: it is written for several points at
// a time, because reading a scalar back from a vector that was only just stored stalls.
template<bool kGradient, bool kLarge> void SplatIsotropic(const SplatArgs& s) {
  constexpr size_t batch = kLarge ? 1 : 8;
  constexpr int chunk = kLarge ? 64 : 16; // rows at a time
  struct PointRows {
    alignas(64) std::array<float, chunk> u, j;
  };
  std::array<PointRows, batch> prepared;
  alignas(64) float heights[16 * max_ring_sheets / 4];
  const int vp = pixels_per_vector(), lanes = static_cast<int>(hn::Lanes(d));
  const auto step = static_cast<std::ptrdiff_t>(s.pitch) * 4;
  const V pixel = hn::Load(d, lane_pixel), one = hn::Set(d, 1.0f), zero = hn::Zero(d),
          depth2 = hn::Set(d, s.depth2);
  const V metric = hn::Set(d, s.lanes->xx[0]), count = hn::Iota(d, 0);
  for (size_t first = 0; first < s.count; first += batch) {
    const size_t points = std::min(batch, s.count - first);
    for (int from = 0; from < s.rows; from += chunk) {
      for (size_t n = 0; n < points; ++n) {
        const SplatRecord& p = s.record[first + n];
        PointRows& rows = prepared[n];
        for (int r = 0; r < chunk; r += lanes) {
          const V dj = hn::Sub(hn::Add(count, hn::Set(d, static_cast<float>(from + r))), hn::Set(d, p.fy));
          hn::Store(hn::Mul(hn::Mul(dj, dj), metric), d, rows.u.data() + r);
          if constexpr (kGradient) hn::Store(dj, d, rows.j.data() + r);
        }
      }
      for (size_t n = 0; n < points; ++n) {
        const SplatRecord& p = s.record[first + n];
        const PointRows& rows = prepared[n];
        int begin = 0, end = std::min(chunk, s.rows - from), v0 = 0, v1 = s.columns;
        begin = std::max(0, -p.y - from), end = std::min(end, s.height - p.y - from);
        // Vectors of the window that touch the tile; they may hang over into the spare pixels.
        v0 = p.x >= 0 ? 0 : (-p.x) / vp * vp, v1 = std::min(s.columns, s.width - p.x);
        const auto& a = s.kernel->a;
        const V a2 = hn::Set(d, p.c * a[2]), a3 = hn::Set(d, p.c * a[3]), a4 = hn::Set(d, p.c * a[4]);
        const V a5 = hn::Set(d, p.c * a[5]), a6 = hn::Set(d, p.c * a[6]), a7 = hn::Set(d, p.c * a[7]);
        const V left = hn::Sub(pixel, hn::Set(d, p.fx)), z = hn::Set(d, p.z);
        float* const start = s.ring[0] + (static_cast<std::ptrdiff_t>(p.y + from) * s.pitch + p.x) * 4;
        const auto add = [&](V level, V row_u, float* sum) HWY_ATTR {
          const V u = hn::Max(hn::Sub(level, row_u), zero);
          const V q0 = hn::MulAdd(a3, u, a2), q1 = hn::MulAdd(a5, u, a4), q2 = hn::MulAdd(a7, u, a6);
          const V w = hn::Mul(u, u);
          const V q = hn::MulAdd(hn::MulAdd(q2, w, q1), w, q0);
          hn::StoreU(hn::MulAdd(q, w, hn::LoadU(d, sum)), d, sum);
        };
        // d phi / du = u (2 a2 + 3 a3 u + u^2 (4 a4 + 5 a5 u + u^2 (6 a6 + 7 a7 u)))
        const auto add_slopes = [&](V level, V row_u, V di, V dj, V dk, float* sum) HWY_ATTR {
          const V u = hn::Max(hn::Sub(level, row_u), zero);
          const V q0 = hn::MulAdd(a3, u, a2), q1 = hn::MulAdd(a5, u, a4), q2 = hn::MulAdd(a7, u, a6);
          const V w = hn::Mul(u, u);
          const V q = hn::MulAdd(hn::MulAdd(q2, w, q1), w, q0);
          hn::StoreU(hn::MulAdd(q, w, hn::LoadU(d, sum)), d, sum);
          const V d0 = hn::MulSub(hn::Set(d, 3.0f), q0, a2), d1 = hn::MulSub(hn::Set(d, 5.0f), q1, a4);
          const V d2 = hn::MulSub(hn::Set(d, 7.0f), q2, a6);
          const V slope = hn::Mul(u, hn::MulAdd(hn::MulAdd(d2, w, d1), w, d0));
          const std::ptrdiff_t at = sum - s.ring[0];
          hn::StoreU(hn::MulAdd(slope, di, hn::LoadU(d, s.ring[1] + at)), d, s.ring[1] + at);
          hn::StoreU(hn::MulAdd(slope, dj, hn::LoadU(d, s.ring[2] + at)), d, s.ring[2] + at);
          hn::StoreU(hn::MulAdd(slope, dk, hn::LoadU(d, s.ring[3] + at)), d, s.ring[3] + at);
        };
        for (int g = 0; g < s.groups; ++g) {
          const V dk = hn::Sub(repeat4(s.lanes->offset + 4 * g), z);
          hn::Store(hn::NegMulAdd(hn::Mul(dk, depth2), dk, one), d, heights + 16 * g);
        }
        // Two vectors of columns side by side share their rows.
        for (int v = v0; v < v1; v += kGradient ? vp : 2 * vp) {
          const bool both = !kGradient && v + vp < v1;
          const V di = hn::Add(left, hn::Set(d, static_cast<float>(v)));
          const V across = hn::Mul(hn::Mul(di, metric), di);
          const V di_next = hn::Add(left, hn::Set(d, static_cast<float>(v + vp)));
          const V across_next = hn::Mul(hn::Mul(di_next, metric), di_next);
          for (int g = 0; g < s.groups; ++g) {
            int r0 = begin, r1 = end;
            if (s.lanes->row_range) {
              const int16_t* range = s.lanes->row_range + 2 * (g * s.lanes->row_columns + v / 4);
              const int16_t* next =
                  both ? s.lanes->row_range + 2 * (g * s.lanes->row_columns + (v + vp) / 4) : range;
              r0 = std::max<int>(r0, std::min(range[0], next[0]) - from),
              r1 = std::min<int>(r1, std::max(range[1], next[1]) - from);
            }
            const V height = hn::Load(d, heights + 16 * g), level = hn::Sub(height, across);
            float* sum = start + g * static_cast<std::ptrdiff_t>(s.group_floats) + 4 * v + r0 * step;
            if (both) {
              const V level_next = hn::Sub(height, across_next);
              for (int r = r0; r < r1; ++r, sum += step) {
                const V row_u = hn::Set(d, rows.u[static_cast<size_t>(r)]);
                add(level, row_u, sum);
                add(level_next, row_u, sum + hn::Lanes(d));
              }
            } else if constexpr (kGradient) {
              const V dk = hn::Sub(repeat4(s.lanes->offset + 4 * g), z);
              for (int r = r0; r < r1; ++r, sum += step)
                add_slopes(level, hn::Set(d, rows.u[static_cast<size_t>(r)]), di,
                           hn::Set(d, rows.j[static_cast<size_t>(r)]), dk, sum);
            } else {
              for (int r = r0; r < r1; ++r, sum += step)
                add(level, hn::Set(d, rows.u[static_cast<size_t>(r)]), sum);
            }
          }
        }
      }
    }
  }
}

// The same for windows of one or two vectors of columns and at most 16 rows, in a ring with room for them
// around the tile: nothing is clipped, so every point takes the same path.
template<bool kPair> void SplatSmall(const SplatArgs& s) {
  constexpr size_t batch = 8;
  alignas(64) float row_u[batch][16];
  const int lanes = static_cast<int>(hn::Lanes(d)), rows = s.rows, groups = s.groups;
  const auto step = static_cast<std::ptrdiff_t>(s.pitch) * 4,
             group_floats = static_cast<std::ptrdiff_t>(s.group_floats);
  const V pixel = hn::Load(d, lane_pixel), one = hn::Set(d, 1.0f), zero = hn::Zero(d),
          depth2 = hn::Set(d, s.depth2);
  const V metric = hn::Set(d, s.lanes->xx[0]), count = hn::Iota(d, 0);
  const V next = hn::Set(d, static_cast<float>(pixels_per_vector()));
  const float* const offset = s.lanes->offset;
  float* const ring = s.ring[0];
  const float c2 = s.kernel->a[2], c3 = s.kernel->a[3], c4 = s.kernel->a[4];
  const float c5 = s.kernel->a[5], c6 = s.kernel->a[6], c7 = s.kernel->a[7];
  for (size_t first = 0; first < s.count; first += batch) {
    const size_t points = std::min(batch, s.count - first);
    for (size_t n = 0; n < points; ++n)
      for (int r = 0; r < rows; r += lanes) {
        const V dj =
            hn::Sub(hn::Add(count, hn::Set(d, static_cast<float>(r))), hn::Set(d, s.record[first + n].fy));
        hn::Store(hn::Mul(hn::Mul(dj, dj), metric), d, row_u[n] + r);
      }
    for (size_t n = 0; n < points; ++n) {
      const SplatRecord& p = s.record[first + n];
      const V a2 = hn::Set(d, p.c * c2), a3 = hn::Set(d, p.c * c3), a4 = hn::Set(d, p.c * c4);
      const V a5 = hn::Set(d, p.c * c5), a6 = hn::Set(d, p.c * c6), a7 = hn::Set(d, p.c * c7);
      const V z = hn::Set(d, p.z), di = hn::Sub(pixel, hn::Set(d, p.fx)),
              across = hn::Mul(hn::Mul(di, metric), di);
      const V di_next = hn::Add(di, next), across_next = hn::Mul(hn::Mul(di_next, metric), di_next);
      float* start = ring + (static_cast<std::ptrdiff_t>(p.y) * s.pitch + p.x) * 4;
      const auto add = [&](V level, V row, float* sum) HWY_ATTR {
        const V u = hn::Max(hn::Sub(level, row), zero);
        const V q0 = hn::MulAdd(a3, u, a2), q1 = hn::MulAdd(a5, u, a4), q2 = hn::MulAdd(a7, u, a6);
        const V w = hn::Mul(u, u);
        const V q = hn::MulAdd(hn::MulAdd(q2, w, q1), w, q0);
        hn::StoreU(hn::MulAdd(q, w, hn::LoadU(d, sum)), d, sum);
      };
      for (int g = 0; g < groups; ++g, start += group_floats) {
        const V dk = hn::Sub(repeat4(offset + 4 * g), z);
        const V height = hn::NegMulAdd(hn::Mul(dk, depth2), dk, one);
        const V level = hn::Sub(height, across), level_next = hn::Sub(height, across_next);
        float* sum = start;
        for (int r = 0; r < rows; ++r, sum += step) {
          const V row = hn::Set(d, row_u[n][r]);
          add(level, row, sum);
          if constexpr (kPair) add(level_next, row, sum + hn::Lanes(d));
        }
      }
    }
  }
}

void Splat(const SplatArgs& s) {
  const bool square = s.kernel->from_square && s.kernel->terms == 8, gradient = s.ring[1] != nullptr;
  if (s.isotropic && square) {
    if (s.rows > 16) return gradient ? SplatIsotropic<true, true>(s) : SplatIsotropic<false, true>(s);
    if (s.spare && !gradient && s.columns <= 2 * pixels_per_vector())
      return s.columns <= pixels_per_vector() ? SplatSmall<false>(s) : SplatSmall<true>(s);
    return gradient ? SplatIsotropic<true, false>(s) : SplatIsotropic<false, false>(s);
  }
  if (s.isotropic) return gradient ? SplatGeneral<true, true, false>(s) : SplatGeneral<true, false, false>(s);
  if (square) return gradient ? SplatGeneral<false, true, true>(s) : SplatGeneral<false, false, true>(s);
  return gradient ? SplatGeneral<false, true, false>(s) : SplatGeneral<false, false, false>(s);
}

#endif
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {
HWY_EXPORT(Splat);

void splat_points(const SplatArgs& s) { HWY_DYNAMIC_DISPATCH(Splat)(s); }

} // namespace bccsplat
#endif

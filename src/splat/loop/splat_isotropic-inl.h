// SPDX-License-Identifier: Apache-2.0
// Adds points to the ring where a sheet's metric is a multiple of the identity and rays run along its normal,
// for the target being compiled; the file is included once per target.
//
//   u = level - yy dj^2, level = 1 - depth2 dk^2 - xx di^2 constant down the rows
//
// What is known per row goes through memory: it is written for several points at a time, because reading a
// scalar back from a vector that was only just stored stalls.
#if defined(BCCSPLAT_SPLAT_ISOTROPIC_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef BCCSPLAT_SPLAT_ISOTROPIC_INL_H
#undef BCCSPLAT_SPLAT_ISOTROPIC_INL_H
#else
#define BCCSPLAT_SPLAT_ISOTROPIC_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>

#include "base/grid.h"
#include "splat/loop/splat_weights-inl.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace {

#if HWY_TARGET != HWY_SCALAR

// Writes for rows `from` on of a point's window the part of 1 - u that the distance dj from its foot makes,
// and dj itself unless `distance` is null, in whole vectors.
HWY_INLINE void MeasureRows(const SplatRecord& p, V metric, int from, int rows, float* part,
                            float* distance) {
  const int lanes = static_cast<int>(hn::Lanes(d));
  const V count = hn::Iota(d, 0);
  for (int r = 0; r < rows; r += lanes) {
    const V dj = hn::Sub(hn::Add(count, hn::Set(d, static_cast<float>(from + r))), hn::Set(d, p.fy));
    hn::Store(hn::Mul(hn::Mul(dj, dj), metric), d, part + r);
    if (distance) hn::Store(dj, d, distance + r);
  }
}

// Rows begin .. end, as far as the sheets of group g reach them at column v of a large window and, with
// `both`, at the next vector's.
HWY_INLINE std::array<int, 2> ReachedRows(const GapLanes& lanes, int g, int v, bool both, int from, int begin,
                                          int end) {
  if (!lanes.row_range) return {begin, end};
  const int16_t* range = lanes.row_range + 2 * (g * lanes.row_columns + v / 4);
  const int16_t* next =
      both ? lanes.row_range + 2 * (g * lanes.row_columns + (v + PixelsPerVector()) / 4) : range;
  return {std::max<int>(begin, std::min(range[0], next[0]) - from),
          std::min<int>(end, std::max(range[1], next[1]) - from)};
}

template<KernelPolynomial::Form kForm, bool kGradient, bool kLarge> void SplatIsotropic(const SplatArgs& s) {
  constexpr size_t batch = kLarge ? 1 : 8;
  constexpr int chunk = kLarge ? 64 : 16; // rows at a time
  struct PointRows {
    alignas(64) std::array<float, chunk> u, j;
  };
  std::array<PointRows, batch> prepared;
  alignas(64) float heights[16 * max_ring_sheets / 4];
  const int vp = PixelsPerVector();
  const auto step = static_cast<std::ptrdiff_t>(s.pitch) * 4;
  const V pixel = hn::Load(d, lane_pixel), one = hn::Set(d, 1.0f), zero = hn::Zero(d),
          depth2 = hn::Set(d, s.depth2), metric = hn::Set(d, s.lanes->xx[0]);
  for (size_t first = 0; first < s.count; first += batch) {
    const size_t points = std::min(batch, s.count - first);
    for (int from = 0; from < s.rows; from += chunk) {
      for (size_t n = 0; n < points; ++n)
        MeasureRows(s.record[first + n], metric, from, chunk, prepared[n].u.data(),
                    kGradient ? prepared[n].j.data() : nullptr);
      for (size_t n = 0; n < points; ++n) {
        const SplatRecord& p = s.record[first + n];
        const PointRows& rows = prepared[n];
        const int begin = std::max(0, -p.y - from),
                  end = std::min({chunk, s.rows - from, s.height - p.y - from});
        // Vectors of the window that touch the tile; they may reach into the spare pixels.
        const int v0 = p.x >= 0 ? 0 : (-p.x) / vp * vp, v1 = std::min(s.columns, s.width - p.x);
        const Weights<kForm> weights(*s.kernel, p.c);
        const V fx = hn::Set(d, p.fx), z = hn::Set(d, p.z);
        float* const start = s.ring[0] + plane_offset(p.x, p.y + from, s.pitch) * 4;
        const auto add = [&](V level, V row_u, float* sum) HWY_ATTR {
          const V u = hn::Max(hn::Sub(level, row_u), zero);
          hn::StoreU(weights.add(u, hn::LoadU(d, sum)), d, sum);
        };
        const auto add_slopes = [&](V level, V row_u, V di, V dj, V dk, float* sum) HWY_ATTR {
          const V u = hn::Max(hn::Sub(level, row_u), zero);
          V slope;
          hn::StoreU(weights.add(u, hn::LoadU(d, sum), slope), d, sum);
          const std::ptrdiff_t at = sum - s.ring[0];
          hn::StoreU(hn::MulAdd(slope, di, hn::LoadU(d, s.ring[1] + at)), d, s.ring[1] + at);
          hn::StoreU(hn::MulAdd(slope, dj, hn::LoadU(d, s.ring[2] + at)), d, s.ring[2] + at);
          hn::StoreU(hn::MulAdd(slope, dk, hn::LoadU(d, s.ring[3] + at)), d, s.ring[3] + at);
        };
        for (int g = 0; g < s.groups; ++g) {
          const V dk = hn::Sub(Repeat4(s.lanes->offset + 4 * g), z);
          hn::Store(hn::NegMulAdd(hn::Mul(dk, depth2), dk, one), d, heights + 16 * g);
        }
        // Two vectors of columns side by side share their rows.
        for (int v = v0; v < v1; v += kGradient ? vp : 2 * vp) {
          const bool both = !kGradient && v + vp < v1;
          const V di = hn::Sub(hn::Add(pixel, hn::Set(d, static_cast<float>(v))), fx);
          const V across = hn::Mul(hn::Mul(di, metric), di);
          const V di_next = hn::Sub(hn::Add(pixel, hn::Set(d, static_cast<float>(v + vp))), fx);
          const V across_next = hn::Mul(hn::Mul(di_next, metric), di_next);
          for (int g = 0; g < s.groups; ++g) {
            const std::array<int, 2> reached = ReachedRows(*s.lanes, g, v, both, from, begin, end);
            const int r0 = reached[0], r1 = reached[1];
            const V height = hn::Load(d, heights + 16 * g), level = hn::Sub(height, across);
            float* sum = start + g * static_cast<std::ptrdiff_t>(s.group_floats) + 4 * v + r0 * step;
            if (both) {
              const V level_next = hn::Sub(height, across_next);
              for (int r = r0; r < r1; ++r, sum += step) {
                const V row_u = hn::Set(d, rows.u[r]);
                add(level, row_u, sum);
                add(level_next, row_u, sum + hn::Lanes(d));
              }
            } else if constexpr (kGradient) {
              const V dk = hn::Sub(Repeat4(s.lanes->offset + 4 * g), z);
              for (int r = r0; r < r1; ++r, sum += step)
                add_slopes(level, hn::Set(d, rows.u[r]), di, hn::Set(d, rows.j[r]), dk, sum);
            } else {
              for (int r = r0; r < r1; ++r, sum += step) add(level, hn::Set(d, rows.u[r]), sum);
            }
          }
        }
      }
    }
  }
}

// Windows of at most 16 x 16 pixels are drawn by blocks of vectors side by side. Up to a width of 12 pixels
// the vectors start on cache lines: stores that cross a line cost more than the columns that this adds to a
// window. All blocks of a point take the same rows: loops whose length changes from point to point cost more
// than the corners that they would skip.
template<KernelPolynomial::Form kForm, bool kGradient> struct BlockRows {
  const SplatArgs& s;
  std::ptrdiff_t step;
  V metric, depth2;

  template<int kBlocks>
  HWY_INLINE void add(const SplatRecord& p, const float* row_u, int column, int begin, int end) const {
    const Weights<kForm> weights(*s.kernel, p.c);
    const V pixel = hn::Load(d, lane_pixel), zero = hn::Zero(d), fx = hn::Set(d, p.fx), z = hn::Set(d, p.z);
    V di[kBlocks], across[kBlocks];
    for (int b = 0; b < kBlocks; ++b) {
      const int from = column - p.x + b * PixelsPerVector();
      di[b] = hn::Sub(hn::Add(pixel, hn::Set(d, static_cast<float>(from))), fx);
      across[b] = hn::Mul(hn::Mul(di[b], metric), di[b]);
    }
    for (int g = 0; g < s.groups; ++g) {
      const V dk = hn::Sub(Repeat4(s.lanes->offset + 4 * g), z);
      const V height = hn::NegMulAdd(hn::Mul(dk, depth2), dk, hn::Set(d, 1.0f));
      V level[kBlocks];
      for (int b = 0; b < kBlocks; ++b) level[b] = hn::Sub(height, across[b]);
      int r0 = begin, r1 = end;
      if (s.lanes->group_rows) {
        r0 = std::max<int>(r0, s.lanes->group_rows[2 * g]);
        r1 = std::min<int>(r1, s.lanes->group_rows[2 * g + 1]);
      }
      const std::ptrdiff_t at =
          g * static_cast<std::ptrdiff_t>(s.group_floats) + plane_offset(column, p.y + r0, s.pitch) * 4;
      float* sum = s.ring[0] + at;
      for (int r = r0; r < r1; ++r, sum += step) {
        const V row = hn::Set(d, row_u[r]);
        for (int b = 0; b < kBlocks; ++b) {
          const V u = hn::Max(hn::Sub(level[b], row), zero);
          float* const to = sum + b * static_cast<std::ptrdiff_t>(hn::Lanes(d));
          if constexpr (!kGradient) {
            hn::StoreU(weights.add(u, hn::LoadU(d, to)), d, to);
          } else {
            V slope;
            hn::StoreU(weights.add(u, hn::LoadU(d, to), slope), d, to);
            const std::ptrdiff_t n = to - s.ring[0];
            const V dj = hn::Sub(hn::Set(d, static_cast<float>(r)), hn::Set(d, p.fy));
            hn::StoreU(hn::MulAdd(slope, di[b], hn::LoadU(d, s.ring[1] + n)), d, s.ring[1] + n);
            hn::StoreU(hn::MulAdd(slope, dj, hn::LoadU(d, s.ring[2] + n)), d, s.ring[2] + n);
            hn::StoreU(hn::MulAdd(slope, dk, hn::LoadU(d, s.ring[3] + n)), d, s.ring[3] + n);
          }
        }
      }
    }
  }
};

template<KernelPolynomial::Form kForm, bool kGradient> void SplatBlocks(const SplatArgs& s) {
  constexpr size_t batch = 8;
  constexpr int most = 16; // rows
  alignas(64) float row_u[batch][most];
  const int vp = PixelsPerVector();
  const V metric = hn::Set(d, s.lanes->xx[0]);
  const float half = s.half + 1e-3f;
  const BlockRows<kForm, kGradient> rows{s, static_cast<std::ptrdiff_t>(s.pitch) * 4, metric,
                                         hn::Set(d, s.depth2)};
  for (size_t first = 0; first < s.count; first += batch) {
    const size_t points = std::min(batch, s.count - first);
    for (size_t n = 0; n < points; ++n)
      MeasureRows(s.record[first + n], metric, 0, s.rows, row_u[n], nullptr);
    for (size_t n = 0; n < points; ++n) {
      const SplatRecord& p = s.record[first + n];
      const int begin = std::max(0, -p.y), end = std::min(s.rows, s.height - p.y);
      // Four vectors from the window's start cost less than five on cache lines.
      const bool on_lines = s.columns <= 3 * 4;
      int column = on_lines ? std::max(p.x, 0) & -vp : p.x + std::max(0, -p.x) / vp * vp;
      const int last = std::min(p.x + static_cast<int>(p.fx + half), s.width - 1);
      int blocks = (last - column) / vp + 1;
      for (; blocks > 4; blocks -= 2, column += 2 * vp) rows.template add<2>(p, row_u[n], column, begin, end);
      switch (blocks) {
      case 4:
        rows.template add<4>(p, row_u[n], column, begin, end);
        break;
      case 3:
        rows.template add<3>(p, row_u[n], column, begin, end);
        break;
      case 2:
        rows.template add<2>(p, row_u[n], column, begin, end);
        break;
      default:
        rows.template add<1>(p, row_u[n], column, begin, end);
      }
    }
  }
}

// Windows of one or two vectors of columns and at most 16 rows are drawn whole, in a ring with room for them
// around the tile: nothing is clipped, so every point takes the same path. kRows is the number of rows where
// the loop is worth unrolling, else 0.
template<KernelPolynomial::Form kForm, bool kPair, int kRows> void SplatSmallRows(const SplatArgs& s) {
  constexpr size_t batch = 8;
  alignas(64) float row_u[batch][16];
  const int rows = kRows ? kRows : s.rows, groups = s.groups;
  const auto step = static_cast<std::ptrdiff_t>(s.pitch) * 4,
             group_floats = static_cast<std::ptrdiff_t>(s.group_floats);
  const V pixel = hn::Load(d, lane_pixel), one = hn::Set(d, 1.0f), zero = hn::Zero(d),
          depth2 = hn::Set(d, s.depth2), metric = hn::Set(d, s.lanes->xx[0]);
  const V next = hn::Set(d, static_cast<float>(PixelsPerVector()));
  const float* const offset = s.lanes->offset;
  float* const ring = s.ring[0];
  const KernelPolynomial kernel = *s.kernel;
  for (size_t first = 0; first < s.count; first += batch) {
    const size_t points = std::min(batch, s.count - first);
    for (size_t n = 0; n < points; ++n) MeasureRows(s.record[first + n], metric, 0, rows, row_u[n], nullptr);
    for (size_t n = 0; n < points; ++n) {
      const SplatRecord& p = s.record[first + n];
      const Weights<kForm> weights(kernel, p.c);
      const V z = hn::Set(d, p.z), di = hn::Sub(pixel, hn::Set(d, p.fx)),
              across = hn::Mul(hn::Mul(di, metric), di);
      const V di_next = hn::Add(di, next), across_next = hn::Mul(hn::Mul(di_next, metric), di_next);
      float* start = ring + plane_offset(p.x, p.y, s.pitch) * 4;
      const auto add = [&](V level, V row, float* sum) HWY_ATTR {
        const V u = hn::Max(hn::Sub(level, row), zero);
        hn::StoreU(weights.add(u, hn::LoadU(d, sum)), d, sum);
      };
      for (int g = 0; g < groups; ++g, start += group_floats) {
        const V dk = hn::Sub(Repeat4(offset + 4 * g), z);
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

// Windows at 1.15 pixels per T and those of raised sheets have 5 or 6 rows.
template<KernelPolynomial::Form kForm, bool kPair> void SplatSmall(const SplatArgs& s) {
  if (s.rows == 5) return SplatSmallRows<kForm, kPair, 5>(s);
  if (s.rows == 6) return SplatSmallRows<kForm, kPair, 6>(s);
  SplatSmallRows<kForm, kPair, 0>(s);
}

#endif

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#endif

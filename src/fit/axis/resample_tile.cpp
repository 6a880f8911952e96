// SPDX-License-Identifier: Apache-2.0
// The passes along z, y and x over one tile, as loops over sixteen floats. Products are rounded before they
// are added (no fused operation), so that every target computes the same: the parts of a series may come from
// different machines.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fit/axis/resample_tile.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include "fit/axis/filter.h"
#include "fit/axis/resample_tile.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace {

// Vectors hold at most one row of a brick, so that lanes never cross bricks.
using D = hn::CappedTag<float, 16>;
using V = hn::Vec<D>;

template<int taps, bool first>
HWY_INLINE void Accumulate(const float* in, const int32_t* row, size_t pitch, const float* weight,
                           size_t count, float* HWY_RESTRICT out) {
  const D d;
  const float* p[taps];
  for (int k = 0; k < taps; ++k) p[k] = in + row[k] * pitch;
  for (size_t x = 0; x < count; x += hn::Lanes(d)) {
    const auto term = [&](int k) HWY_ATTR { return hn::Mul(hn::Set(d, weight[k]), hn::LoadU(d, p[k] + x)); };
    V sum = first ? term(0) : hn::Add(term(0), hn::LoadU(d, out + x));
    for (int k = 1; k < taps; ++k) sum = hn::Add(term(k), sum);
    hn::StoreU(sum, d, out + x);
  }
}

template<bool first>
HWY_INLINE int AccumulateSome(int taps, const float* in, const int32_t* row, size_t pitch,
                              const float* weight, size_t count, float* out) {
  if (taps >= 8) return Accumulate<8, first>(in, row, pitch, weight, count, out), 8;
  if (taps >= 6) return Accumulate<6, first>(in, row, pitch, weight, count, out), 6;
  if (taps >= 4) return Accumulate<4, first>(in, row, pitch, weight, count, out), 4;
  if (taps >= 2) return Accumulate<2, first>(in, row, pitch, weight, count, out), 2;
  return Accumulate<1, first>(in, row, pitch, weight, count, out), 1;
}

// out = sum over k of weight[k] * row[k].
HWY_INLINE void WeightedRows(int taps, const float* in, const int32_t* row, size_t pitch, const float* weight,
                             size_t count, float* out) {
  int k = AccumulateSome<true>(taps, in, row, pitch, weight, count, out);
  while (k < taps) k += AccumulateSome<false>(taps - k, in, row + k, pitch, weight + k, count, out);
}

// Lane i is in[index[i]], 0 <= index[i] < 2 * Lanes.
struct Picker {
  HWY_INLINE explicit Picker(const int32_t* index) {
    const hn::RebindToSigned<D> di;
    const auto i = hn::LoadU(di, index);
#if HWY_TARGET == HWY_AVX3
    index_ = i.raw;
#else
    const auto lanes = static_cast<int32_t>(hn::Lanes(di));
    low_ = hn::IndicesFromVec(D(), hn::And(i, hn::Set(di, lanes - 1)));
    upper_ = hn::RebindMask(D(), hn::Gt(i, hn::Set(di, lanes - 1)));
#endif
  }
  HWY_INLINE V operator()(const float* in) const {
    const D d;
    const V a = hn::LoadU(d, in), b = hn::LoadU(d, in + hn::Lanes(d));
#if HWY_TARGET == HWY_AVX3
    return V{_mm512_permutex2var_ps(a.raw, index_, b.raw)};
#else
    return hn::IfThenElse(upper_, hn::TableLookupLanes(b, low_), hn::TableLookupLanes(a, low_));
#endif
  }

 private:
#if HWY_TARGET == HWY_AVX3
  __m512i index_;
#else
  decltype(hn::IndicesFromVec(D(), hn::Zero(hn::RebindToSigned<D>()))) low_;
  hn::Mask<D> upper_;
#endif
};

// One row of a brick along x.
HWY_INLINE void PolyphaseRow(const float* row, const TileBrickX& brick, int taps, float pivot, float* out) {
  const D d;
  const size_t lanes = hn::Lanes(d);
  for (size_t g = 0; g < 16; g += lanes) {
    const int32_t* index = brick.index + g;
    const float* in = row + brick.base + index[0];
    const float* weight = brick.weight + g;
    V sum = hn::Zero(d);
    if (index[lanes - 1] - index[0] < static_cast<int32_t>(2 * lanes)) {
      alignas(64) int32_t relative[16];
      for (size_t i = 0; i < lanes; ++i) relative[i] = index[i] - index[0];
      const Picker pick(relative);
      for (int k = 0; k < taps; ++k, weight += 16)
        sum = hn::Add(hn::Mul(hn::LoadU(d, weight), pick(in + k)), sum);
    } else { // a lattice much coarser than the source
      alignas(64) float picked[16];
      for (int k = 0; k < taps; ++k, weight += 16) {
        for (size_t i = 0; i < lanes; ++i) picked[i] = in[index[i] - index[0] + k];
        sum = hn::Add(hn::Mul(hn::LoadU(d, weight), hn::Load(d, picked)), sum);
      }
    }
    hn::StoreU(hn::Add(sum, hn::Set(d, pivot)), d, out + g);
  }
}

// Bits of the sites whose nearest sample is not 0.
HWY_INLINE uint16_t NearestBits(const float* row, const TileNearestX& brick) {
  const D d;
  const size_t lanes = hn::Lanes(d);
  uint32_t bits = 0;
  for (size_t g = 0; g < 16; g += lanes) {
    const int32_t* index = brick.index + g;
    const float* in = row + brick.base + index[0];
    alignas(64) int32_t relative[16];
    for (size_t i = 0; i < lanes; ++i) relative[i] = index[i] - index[0];
    if (relative[lanes - 1] < static_cast<int32_t>(2 * lanes)) {
      uint8_t bytes[8] = {};
      hn::StoreMaskBits(d, hn::Ne(Picker(relative)(in), hn::Zero(d)), bytes);
      bits |= (bytes[0] | uint32_t{bytes[1]} << 8) << g;
    } else {
      for (size_t i = 0; i < lanes; ++i) {
        const uint32_t set = in[relative[i]] != 0;
        bits |= set << (g + i);
      }
    }
  }
  return static_cast<uint16_t>(bits);
}

void Nearest(const float* row, std::span<const TileNearestX> bricks) {
  for (const TileNearestX& b : bricks) *b.out = NearestBits(row, b);
}

void PassZ(const float* rows, size_t pitch, const TileTaps& z, float* out) {
  for (int i = 0; i < z.count; ++i)
    WeightedRows(z.taps, rows, z.row + i * z.taps, pitch, z.weight + i * z.taps, pitch, out + i * pitch);
}

void PassYX(const float* in, size_t pitch, int z_count, const TileTaps& y, const TileRow& row, int x_taps,
            std::span<const TileBrickX> bricks, float pivot, float* extended) {
  const size_t inner = row.inner_begin - row.begin;
  for (int z = 0; z < z_count; ++z)
    for (int i = 0; i < y.count; ++i) {
      WeightedRows(y.taps, in + z * pitch, y.row + i * y.taps, pitch * z_count, y.weight + i * y.taps, pitch,
                   extended + inner);
      for (int64_t x = row.begin; x < row.inner_begin; ++x)
        extended[x - row.begin] = extended[end_index(x, row.n, row.turns) - row.begin];
      for (int64_t x = row.inner_end; x < row.end; ++x)
        extended[x - row.begin] = extended[end_index(x, row.n, row.turns) - row.begin];
      for (const TileBrickX& b : bricks) PolyphaseRow(extended, b, x_taps, pivot, b.out + (z * 16 + i) * 16);
    }
}

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {
HWY_EXPORT(Nearest);
HWY_EXPORT(PassZ);
HWY_EXPORT(PassYX);

void tile_nearest(const float* row, std::span<const TileNearestX> bricks) {
  HWY_DYNAMIC_DISPATCH(Nearest)(row, bricks);
}

void tile_pass_z(const float* rows, size_t pitch, const TileTaps& z, float* out) {
  HWY_DYNAMIC_DISPATCH(PassZ)(rows, pitch, z, out);
}

void tile_pass_yx(const float* in, size_t pitch, int z_count, const TileTaps& y, const TileRow& row,
                  int x_taps, std::span<const TileBrickX> bricks, float pivot, float* extended) {
  HWY_DYNAMIC_DISPATCH(PassYX)(in, pitch, z_count, y, row, x_taps, bricks, pivot, extended);
}

} // namespace bccsplat
#endif

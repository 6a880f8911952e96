// SPDX-License-Identifier: Apache-2.0
// Decodes codes of 32 bits. Their cells are kept modulo 2^32, so that they take no more room than those of
// other types. This file is included once per target.
#if defined(BCCSPLAT_UNPREDICT_WIDE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef BCCSPLAT_UNPREDICT_WIDE_INL_H
#undef BCCSPLAT_UNPREDICT_WIDE_INL_H
#else
#define BCCSPLAT_UNPREDICT_WIDE_INL_H
#endif

#include <hwy/highway.h>

#include <bit>
#include <span>

#include "formats/bcc4/coding/unpredict_rows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace {

// Taps of the rows of one layer but x - 1 whose weights are whole units, each as often as its weight says.
struct UnitTaps {
  static constexpr size_t most = 8; // the magnitudes of all weights sum to less than 8 units
  size_t plus_count = 0, minus_count = 0;
  std::array<std::ptrdiff_t, most> plus, minus;

  void Set(const LayerTaps& taps) {
    plus_count = minus_count = 0;
    for (size_t t = 0; t < taps.count; ++t)
      for (int32_t w = taps.weight[t]; w != 0;) {
        if (w > 0)
          plus[plus_count++] = taps.offset[t], w -= 1 << fraction_bits;
        else
          minus[minus_count++] = taps.offset[t], w += 1 << fraction_bits;
      }
  }
};

// The air of floats is in the middle of the codes: a cell then is the code minus air itself, not modulo 2^32.
constexpr uint32_t middle = uint32_t{1} << 31;

#if HWY_TARGET != HWY_SCALAR
// Sums the taps modulo 2^32, and the taps divided by 16, for the sites from `own` on.
template<class D>
HWY_INLINE void UnitSums(D d, const int32_t* own, const UnitTaps& taps, size_t length,
                         int32_t* HWY_RESTRICT sum, int32_t* HWY_RESTRICT rough) {
  for (size_t x = 0; x < length; x += hn::Lanes(d)) {
    auto s = hn::Zero(d), r = hn::Zero(d);
    for (size_t t = 0; t < taps.plus_count; ++t) {
      const auto g = hn::LoadU(d, own + taps.plus[t] + x);
      s = hn::Add(s, g);
      r = hn::Add(r, hn::ShiftRight<4>(g));
    }
    for (size_t t = 0; t < taps.minus_count; ++t) {
      const auto g = hn::LoadU(d, own + taps.minus[t] + x);
      s = hn::Sub(s, g);
      r = hn::Sub(r, hn::ShiftRight<4>(g));
    }
    hn::StoreU(s, d, sum + x);
    hn::StoreU(r, d, rough + x);
  }
}

// Decodes a run of sites whose predictions are the cell before plus whole multiples of others, as sums along
// the row, four sites at a time. Nothing is clamped as long as each prediction lies well within 32 bits; its
// terms divided by 16, each rounded down, tell that to within 7 times 15. Returns false if one does not, and
// the row must be decoded exactly.
HWY_INLINE bool DecodeWideSums(int32_t* own, const UnitTaps& taps, unsigned kept,
                               PackedRows<uint32_t>& rows) {
  const size_t first = std::countr_zero(kept);
  const auto length = std::bit_width(kept) - first;
  int32_t* const run = own + first;
  alignas(64) int32_t sum[brick_edge], rough[brick_edge];
  const hn::CappedTag<int32_t, brick_edge> all;
  const hn::CappedTag<int32_t, brick_edge / 2> half;
  if (length > brick_edge / 2)
    UnitSums(all, run, taps, length, sum, rough);
  else
    UnitSums(half, run, taps, length, sum, rough);
  const hn::FixedTag<int32_t, 4> d;
  const hn::FixedTag<uint32_t, 4> du;
  const hn::FixedTag<uint8_t, 4> d8;
  const auto* from = reinterpret_cast<const uint8_t*>(rows.planes) + rows.at;
  auto* const to = reinterpret_cast<uint32_t*>(rows.packed) + rows.at;
  auto before = hn::Set(d, run[-1]), largest = hn::Zero(d);
  for (size_t x = 0; x < length; x += 4) {
    const auto byte = [&](std::ptrdiff_t plane) HWY_ATTR {
      return hn::PromoteTo(du, hn::LoadU(d8, from + plane * rows.count + x));
    };
    const auto residual = hn::Or(hn::Or(byte(0), hn::ShiftLeft<8>(byte(1))),
                                 hn::Or(hn::ShiftLeft<16>(byte(2)), hn::ShiftLeft<24>(byte(3))));
    const auto sign = hn::Neg(hn::BitCast(d, hn::And(residual, hn::Set(du, 1))));
    const auto step = hn::Xor(hn::BitCast(d, hn::ShiftRight<1>(residual)), sign);
    const auto rise = hn::Add(hn::Load(d, sum + x), step);
    const auto two = hn::Add(rise, hn::ShiftLeftLanes<1>(d, rise));
    const auto cell = hn::Add(hn::Add(two, hn::ShiftLeftLanes<2>(d, two)), before);
    const auto here = hn::FirstN(d, length - x);
    const auto about = hn::Add(hn::ShiftRight<4>(hn::Sub(cell, rise)), hn::Load(d, rough + x));
    largest = hn::Max(largest, hn::IfThenElseZero(here, hn::Abs(about)));
    hn::StoreU(hn::Add(hn::BitCast(du, cell), hn::Set(du, middle)), du, to + x);
    hn::StoreU(hn::IfThenElseZero(here, cell), d, run + x);
    before = hn::Broadcast<3>(cell);
  }
  if (!hn::AllTrue(d, hn::Lt(largest, hn::Set(d, (1 << 27) - 8)))) return false;
  rows.at += static_cast<std::ptrdiff_t>(length);
  return true;
}
#endif

// Decodes the rows of a chunk.
struct WideRows {
  std::span<const BrickMask> kept;
  std::array<Taps, classes> all;
  int64_t air;
  PackedRows<uint32_t> rows;
  LayerTaps layer_taps;
  UnitTaps units;
  int units_layer = -1;

  WideRows(std::span<const BrickMask> masks, const ChunkCodes& codes, const ClassWeights& weights,
           std::span<const std::byte> planes, std::byte* packed)
      : kept(masks), all(TapsOf(weights)),
        air(codes.air), rows{planes.data(), static_cast<std::ptrdiff_t>(planes.size() / sizeof(uint32_t)),
                             packed} {}

  // The code minus air, not modulo 2^32.
  [[nodiscard]] HWY_INLINE int64_t Exact(int32_t cell) const {
    return (cell + static_cast<uint32_t>(air)) - air;
  }

  HWY_INLINE void DecodeRow(const Row<int32_t>& row) {
    const Taps& taps = TapsFor(all, row);
    const unsigned here = kept[row.layer][row.index];
    layer_taps.Set(row, taps);
#if HWY_TARGET != HWY_SCALAR
    if (taps.whole && air == middle && OneRun(here)) {
      if (units_layer != row.layer) units.Set(layer_taps), units_layer = row.layer;
      if (DecodeWideSums(row.own, units, here, rows)) return;
    }
#endif
    DecodeExactly(row, taps, here);
  }

  void DecodeExactly(const Row<int32_t>& row, const Taps& taps, unsigned here) {
    constexpr int64_t most = UINT32_MAX;
    RowCodes q;
    rows.GetResiduals(here, q.residual);
    int64_t sum[brick_edge];
    std::fill_n(sum, brick_edge, int64_t{1} << (fraction_bits - 1));
    for (size_t t = 0; t < layer_taps.count; ++t) {
      const int32_t* cells = row.own + layer_taps.offset[t];
      const int64_t w = layer_taps.weight[t];
      for (size_t x = 0; x < brick_edge; ++x) sum[x] += w * Exact(cells[x]);
    }
    const size_t first = std::countr_zero(here);
    const size_t end = std::bit_width(here);
    int64_t before = Exact(row.own[static_cast<std::ptrdiff_t>(first) - 1]);
    for (size_t x = 0; x < brick_edge; ++x) {
      if (x < first || x >= end || !(here >> x & 1)) {
        row.own[x] = 0;
        before = x < first ? before : 0;
        continue;
      }
      const auto p =
          static_cast<uint32_t>(Limited<int64_t>(sum[x] + taps.west * before, -air, most - air) + air);
      q.code[x] = p + Unfold(q.residual[x], UINT32_MAX);
      before = int64_t{q.code[x]} - air;
      row.own[x] = q.code[x] - static_cast<uint32_t>(air);
    }
    rows.PutCodes(here, q.code);
  }
};

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#endif

// SPDX-License-Identifier: Apache-2.0
// Decodes rows in which each site is predicted from the one before. This file is included once per target.
#if defined(BCCSPLAT_UNPREDICT_CHAINS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef BCCSPLAT_UNPREDICT_CHAINS_INL_H
#undef BCCSPLAT_UNPREDICT_CHAINS_INL_H
#else
#define BCCSPLAT_UNPREDICT_CHAINS_INL_H
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

// Sums from the lowest lane of four, or of one, on.
template<class D> HWY_INLINE hn::Vec<D> RunningSums(D d, hn::Vec<D> v) {
#if HWY_TARGET == HWY_SCALAR
  (void)d;
  return v;
#else
  v = hn::Add(v, hn::ShiftLeftLanes<1>(d, v));
  return hn::Add(v, hn::ShiftLeftLanes<2>(d, v));
#endif
}

// Decodes a run of sites whose predictions are the cell before plus `sum`, half of a unit included. They are
// sums along the row as long as nothing is clamped and nothing wraps; returns false if something does.
HWY_INLINE bool DecodeSums(const int32_t* HWY_RESTRICT sum, unsigned kept, const CodeLimits& limits,
                           int32_t* own, RowCodes& q) {
  const hn::CappedTag<int32_t, 4> d;
  const hn::RebindToUnsigned<decltype(d)> du;
  constexpr int last_lane = HWY_TARGET == HWY_SCALAR ? 0 : 3;
  alignas(16) static constexpr int32_t bit[4] = {1, 2, 4, 8};
  alignas(64) int32_t cell[brick_edge];
  const auto low = hn::Set(d, limits.low), high = hn::Set(d, limits.high);
  auto before = hn::Set(d, own[std::countr_zero(kept) - 1]);
  auto outside = hn::Zero(d); // negative if anything is; the zeros beside the run are inside
  for (size_t x = 0; x < brick_edge; x += hn::Lanes(d)) {
    const auto here = hn::TestBit(hn::Set(d, static_cast<int32_t>(kept >> x)), hn::Load(d, bit));
    const auto residual = hn::Load(du, q.residual + x);
    const auto sign = hn::Neg(hn::BitCast(d, hn::And(residual, hn::Set(du, 1))));
    const auto step = hn::Xor(hn::BitCast(d, hn::ShiftRight<1>(residual)), sign);
    const auto units = hn::ShiftRight<fraction_bits>(hn::LoadU(d, sum + x));
    const auto all = hn::Add(before, RunningSums(d, hn::IfThenElseZero(here, hn::Add(units, step)))); // wraps
    before = hn::Broadcast<last_lane>(all);
    const auto code = hn::IfThenElseZero(here, all);
    const auto prediction = hn::IfThenElseZero(here, hn::Sub(all, step));
    outside = hn::Or(outside, hn::Or(hn::Sub(code, low), hn::Sub(high, code)));
    outside = hn::Or(outside, hn::Or(hn::Sub(prediction, low), hn::Sub(high, prediction)));
    hn::Store(code, d, cell + x);
  }
  if (!hn::AllFalse(d, hn::Lt(outside, hn::Zero(d)))) return false;
  for (size_t x = 0; x < brick_edge; ++x) {
    own[x] = cell[x];
    q.code[x] = cell[x] + limits.air;
  }
  return true;
}

// Decodes those rows of a chunk of codes of up to 16 bits whose weight of x - 1 is not 0.
template<class Stored> struct ChainedRows {
  std::span<const BrickMask> kept;
  std::array<Taps, classes> all;
  CodeLimits limits;
  PackedRows<Stored> rows;
  LayerTaps layer_taps;

  ChainedRows(std::span<const BrickMask> masks, const ChunkCodes& codes, const ClassWeights& weights,
              std::span<const std::byte> planes, std::byte* packed)
      : kept(masks), all(TapsOf(weights)), limits{codes.mask(), codes.air, -static_cast<int32_t>(codes.air),
                                                  static_cast<int32_t>(codes.mask() - codes.air)},
        rows{planes.data(), static_cast<std::ptrdiff_t>(planes.size() / sizeof(Stored)), packed} {}

  [[nodiscard]] unsigned Kept(const Row<int32_t>& row) const { return kept[row.layer][row.index]; }

  HWY_INLINE void DecodeRow(const Row<int32_t>& row, const Taps& taps) {
    const unsigned here = Kept(row);
    const uint32_t mask = limits.mask, air = limits.air;
    const int32_t low = limits.low, high = limits.high;
    RowCodes q;
    rows.GetResiduals(here, q.residual);
    int32_t sum[brick_edge];
    Sums<sizeof(Stored)>(row, taps, taps.own, sum);
    if (taps.whole && OneRun(here) && DecodeSums(sum, here, limits, row.own, q)) {
      rows.PutCodes(here, q.code);
      return;
    }
    // The chain goes from code to code and is short, as the air in x - 1 is part of the sum beforehand. The
    // step is the difference to the prediction, plus air, which the prediction lacks.
    const uint32_t west = taps.west;
    uint32_t step[brick_edge];
    for (size_t x = 0; x < brick_edge; ++x) {
      step[x] = Unfold(q.residual[x], mask) + air;
      sum[x] = sum[x] - west * air;
    }
    const size_t first = std::countr_zero(here);
    const size_t end = std::bit_width(here);
    uint32_t code = row.own[static_cast<std::ptrdiff_t>(first) - 1] + air;
    for (size_t x = first; x < end; ++x) {
      const int32_t p = Limited(static_cast<int32_t>(sum[x] + west * code), low, high);
      code = here >> x & 1 ? (p + step[x]) & mask : air;
      q.code[x] = code;
      row.own[x] = code - air;
    }
    rows.PutCodes(here, q.code);
  }

  // Decodes two full rows at once, the second one two sites behind, where all it is predicted from is known:
  // the two chains do not wait for each other. Returns false when it did nothing.
  HWY_INLINE bool DecodePair(const Row<int32_t>& a, const Row<int32_t>& b, bool repeats) {
    const size_t width = a.width;
    const unsigned full = (1u << width) - 1;
    if (width < 2 || Kept(a) != full || Kept(b) != full) return false;
    const Taps& taps = TapsFor(all, a);
    if (taps.west == 0 || taps.whole) return false;
    const uint32_t mask = limits.mask, air = limits.air;
    const int32_t low = limits.low, high = limits.high;
    int32_t sum_a[brick_edge], sum_b[brick_edge];
    Sums<sizeof(Stored)>(a, taps, taps.own, sum_a);
    Sums<sizeof(Stored)>(b, taps, taps.far, sum_b);
    const uint32_t west = taps.west;
    RowCodes row_a, row_b;
    rows.GetResiduals(full, row_a.residual);
    rows.at += a.width;
    rows.GetResiduals(full, row_b.residual);
    rows.at -= a.width;
    uint32_t step_a[brick_edge], step_b[brick_edge];
    for (size_t x = 0; x < brick_edge; ++x) {
      step_a[x] = Unfold(row_a.residual[x], mask) + air;
      step_b[x] = Unfold(row_b.residual[x], mask) + air;
      sum_a[x] = sum_a[x] - west * air;
      sum_b[x] = sum_b[x] - west * air;
    }
    int32_t above[brick_edge + 2]; // the first row with the cells beside it
    above[0] = a.own[-1];
    uint32_t q_a = a.own[-1] + air, q_b = 0;
    const auto next_a = [&](size_t x) HWY_ATTR {
      const int32_t p = Limited(static_cast<int32_t>(sum_a[x] + west * q_a), low, high);
      q_a = (p + step_a[x]) & mask;
      row_a.code[x] = q_a;
      above[x + 1] = q_a - air;
    };
    const auto next_b = [&](size_t x) HWY_ATTR {
      const int32_t near =
          taps.north * above[x + 1] + taps.northwest * above[x] + taps.northeast * above[x + 2];
      const int32_t p =
          Limited(static_cast<int32_t>(static_cast<uint32_t>(sum_b[x]) + near + west * q_b), low, high);
      q_b = (p + step_b[x]) & mask;
      row_b.code[x] = q_b;
    };
    next_a(0);
    next_a(1);
    q_b = (repeats ? above[1] : b.own[-1]) + air;
    for (size_t x = 2; x < width; ++x) {
      next_a(x);
      next_b(x - 2);
    }
    above[width + 1] = above[width];
    next_b(width - 2);
    next_b(width - 1);
    for (size_t x = 0; x < width; ++x) {
      a.own[x] = above[x + 1];
      b.own[x] = row_b.code[x] - air;
    }
    rows.PutCodes(full, row_a.code);
    rows.PutCodes(full, row_b.code);
    return true;
  }
};

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#endif

// SPDX-License-Identifier: Apache-2.0
// Reads rows of residuals, writes rows of codes, and decodes rows whose sites do not depend on each other.
// This file is included once per target.
#if defined(BCCSPLAT_UNPREDICT_ROWS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef BCCSPLAT_UNPREDICT_ROWS_INL_H
#undef BCCSPLAT_UNPREDICT_ROWS_INL_H
#else
#define BCCSPLAT_UNPREDICT_ROWS_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cstring>

#include "formats/bcc4/coding/predict_taps-inl.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace {

HWY_INLINE uint32_t Unfold(uint32_t f, uint32_t mask) { return (f >> 1 ^ (0 - (f & 1))) & mask; }

struct CodeLimits {
  uint32_t mask, air;
  int32_t low, high; // of predictions, relative to air, for codes of up to 16 bits
};

// The codes of one row at the places of its sites, undefined where none is kept, and the residuals they come
// from.
struct RowCodes {
  alignas(64) uint32_t residual[brick_edge], code[brick_edge]{};
};

// Reads the residuals of a row from byte planes and writes its codes packed. A row of one run is moved as
// sixteen sites; what is written beside the run, the rows that follow overwrite.
template<class Stored> struct PackedRows {
  const std::byte* planes;
  std::ptrdiff_t count; // of kept sites, in each plane
  std::byte* packed;
  std::ptrdiff_t at = 0; // the next kept site

  HWY_INLINE uint32_t Residual(std::ptrdiff_t i) const {
    uint32_t r = 0;
    for (size_t b = 0; b < sizeof(Stored); ++b)
      r |= static_cast<uint32_t>(planes[static_cast<std::ptrdiff_t>(b) * count + i]) << (8 * b);
    return r;
  }
  HWY_INLINE void GetResiduals(unsigned kept, uint32_t* HWY_RESTRICT residual) const {
    if (!OneRun(kept)) {
      std::fill_n(residual, brick_edge, 0u);
      std::ptrdiff_t i = at;
      for (unsigned bits = kept; bits; bits &= bits - 1) residual[std::countr_zero(bits)] = Residual(i++);
      return;
    }
    const hn::CappedTag<uint32_t, brick_edge> d;
    const hn::Rebind<uint8_t, decltype(d)> d8;
    const auto* from = reinterpret_cast<const uint8_t*>(planes) + (at - std::countr_zero(kept));
    for (size_t x = 0; x < brick_edge; x += hn::Lanes(d)) {
      const auto byte = [&](std::ptrdiff_t plane)
                            HWY_ATTR { return hn::PromoteTo(d, hn::LoadU(d8, from + plane * count + x)); };
      auto r = byte(0);
      if constexpr (sizeof(Stored) >= 2) r = hn::Or(r, hn::ShiftLeft<8>(byte(1)));
      if constexpr (sizeof(Stored) == 4)
        r = hn::Or(r, hn::Or(hn::ShiftLeft<16>(byte(2)), hn::ShiftLeft<24>(byte(3))));
      hn::StoreU(r, d, residual + x);
    }
  }
  HWY_INLINE void PutCodes(unsigned kept, const uint32_t* HWY_RESTRICT code) {
    std::byte* const to = packed + at * static_cast<std::ptrdiff_t>(sizeof(Stored));
    if (OneRun(kept)) {
      Stored row[2 * brick_edge];
      for (size_t x = 0; x < brick_edge; ++x) row[x] = static_cast<Stored>(code[x]);
      std::memset(row + brick_edge, 0, brick_edge * sizeof(Stored));
      std::memcpy(to, row + std::countr_zero(kept), brick_edge * sizeof(Stored));
      at += static_cast<std::ptrdiff_t>(std::bit_width(kept)) - std::countr_zero(kept);
    } else {
      std::byte* next = to;
      for (unsigned bits = kept; bits; bits &= bits - 1, ++at, next += sizeof(Stored)) {
        const auto v = static_cast<Stored>(code[std::countr_zero(bits)]);
        std::memcpy(next, &v, sizeof v);
      }
    }
  }
};

// All taps of the rows of one layer but x - 1, as differences to the cell of the own site. The row before
// comes last, because its cells have just been written.
struct LayerTaps {
  int layer = -1;
  size_t count = 0;
  std::array<std::ptrdiff_t, max_taps> offset;
  std::array<int32_t, max_taps> weight;

  void Set(const Row<int32_t>& row, const Taps& taps) {
    if (row.layer == layer) return;
    layer = row.layer;
    count = 0;
    const auto add = [&](const Taps::List& list, const int32_t* cells) {
      for (size_t t = 0; t < list.count; ++t, ++count) {
        offset[count] = cells - row.own + list.offset[t];
        weight[count] = list.weight[t];
      }
    };
    if (row.cross) add(taps.cross, row.cross);
    if (row.previous) add(taps.previous, row.previous);
    add(taps.far, row.own);
    add(taps.near, row.own);
  }
};

// Returns the codes of the sites from x on, as many as a vector has lanes; their cells become code minus air
// where a site is kept, else 0.
template<size_t code_bytes, class D, class DU = hn::RebindToUnsigned<D>>
HWY_INLINE hn::Vec<D> CodesFrom(D d, int32_t* own, const LayerTaps& taps, unsigned kept,
                                const CodeLimits& limits, size_t x, hn::Vec<DU> residual) {
  const DU du;
  auto even = hn::Set(d, 1 << (fraction_bits - 1)), odd = hn::Zero(d);
  const auto add = [&](size_t t, auto sum) HWY_ATTR {
    return AddWeighted<code_bytes>(d, sum, hn::LoadU(d, own + taps.offset[t] + x), taps.weight[t]);
  };
  size_t t = 0;
  for (; t + 1 < taps.count; t += 2) even = add(t, even), odd = add(t + 1, odd);
  if (t < taps.count) even = add(t, even);
  const auto p = hn::Min(hn::Max(hn::ShiftRight<fraction_bits>(hn::Add(even, odd)), hn::Set(d, limits.low)),
                         hn::Set(d, limits.high));
  const auto sign = hn::Neg(hn::BitCast(d, hn::And(residual, hn::Set(du, 1))));
  const auto step = hn::Xor(hn::BitCast(d, hn::ShiftRight<1>(residual)), sign);
  const auto air = hn::Set(d, static_cast<int32_t>(limits.air));
  const auto code = hn::And(hn::Add(hn::Add(p, step), air), hn::Set(d, static_cast<int32_t>(limits.mask)));
  alignas(64) static constexpr int32_t bit[brick_edge] = {1,   2,   4,    8,    16,   32,   64,    128,
                                                          256, 512, 1024, 2048, 4096, 8192, 16384, 32768};
  const auto here = hn::TestBit(hn::Set(d, static_cast<int32_t>(kept >> x)), hn::LoadU(d, bit));
  hn::StoreU(hn::IfThenElseZero(here, hn::Sub(code, air)), d, own + x);
  return code;
}

// Decodes a row of one run from its first site on: residuals and codes have the order of the planes and of
// the packed codes.
template<class D, class Stored>
HWY_INLINE void DecodeRun(D d, int32_t* own, const LayerTaps& taps, unsigned kept, size_t first,
                          size_t length, const CodeLimits& limits, const PackedRows<Stored>& rows) {
  const hn::RebindToUnsigned<D> du;
  const hn::Rebind<uint8_t, D> d8;
  const hn::Rebind<Stored, D> packed;
  const auto* from = reinterpret_cast<const uint8_t*>(rows.planes) + rows.at;
  auto* to = reinterpret_cast<Stored*>(rows.packed) + rows.at;
  for (size_t i = 0; i < length; i += hn::Lanes(d)) {
    auto residual = hn::PromoteTo(du, hn::LoadU(d8, from + i));
    if constexpr (sizeof(Stored) == 2) {
      const auto high = hn::LoadU(d8, from + rows.count + i);
      residual = hn::Or(residual, hn::ShiftLeft<8>(hn::PromoteTo(du, high)));
    }
    const auto code = CodesFrom<sizeof(Stored)>(d, own, taps, kept, limits, first + i, residual);
    hn::StoreU(hn::DemoteTo(packed, code), packed, to + i);
  }
}

// Decodes a row whose sites do not depend on each other.
template<class Stored>
HWY_INLINE void DecodeParallel(const Row<int32_t>& row, const Taps& all, LayerTaps& taps, unsigned kept,
                               const CodeLimits& limits, PackedRows<Stored>& rows) {
  const hn::CappedTag<int32_t, brick_edge> d;
  const hn::CappedTag<int32_t, brick_edge / 2> half;
  taps.Set(row, all);
  if (OneRun(kept)) {
    const size_t first = std::countr_zero(kept);
    const auto length = std::bit_width(kept) - first;
    if (length > brick_edge / 2)
      DecodeRun(d, row.own, taps, kept, first, length, limits, rows);
    else
      DecodeRun(half, row.own, taps, kept, first, length, limits, rows);
    rows.at += static_cast<std::ptrdiff_t>(length);
    return;
  }
  const hn::RebindToUnsigned<decltype(d)> du;
  RowCodes q;
  rows.GetResiduals(kept, q.residual);
  for (size_t x = 0; x < brick_edge; x += hn::Lanes(d)) {
    const auto code =
        CodesFrom<sizeof(Stored)>(d, row.own, taps, kept, limits, x, hn::Load(du, q.residual + x));
    hn::Store(hn::BitCast(du, code), du, q.code + x);
  }
  rows.PutCodes(kept, q.code);
}
} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#endif

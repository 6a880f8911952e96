// SPDX-License-Identifier: Apache-2.0
// The weighted neighbours of a row of sites. This file is included once per target.
#if defined(BCCSPLAT_PREDICT_TAPS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef BCCSPLAT_PREDICT_TAPS_INL_H
#undef BCCSPLAT_PREDICT_TAPS_INL_H
#else
#define BCCSPLAT_PREDICT_TAPS_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "formats/bcc4/coding/predict_walk.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace {

// The taps of one class whose weight is not 0, without x - 1 of the own layer, by the layer they are in.
struct Taps {
  struct List {
    std::array<std::ptrdiff_t, own_taps> offset{};
    std::array<int32_t, own_taps> weight{};
    size_t count = 0;
    void add(std::ptrdiff_t o, int32_t w) {
      if (w == 0) return;
      offset[count] = o;
      weight[count++] = w;
    }
  };
  List own, cross, previous;
  List near, far;                                            // `own`: in the row before, and the others
  int32_t west = 0, north = 0, northwest = 0, northeast = 0; // x - 1, and in the row before: x, x - 1, x + 1
  bool whole = true;                                         // every weight is a multiple of 1, west is 1
};
constexpr size_t north_tap = 1, northwest_tap = 3, northeast_tap = 7; // of the own layer

inline std::array<Taps, classes> TapsOf(const ClassWeights& weights) {
  std::array<Taps, classes> all;
  for (int c = 0; c < classes; ++c) {
    Taps& taps = all[c];
    const int16_t* w = weights[c].data();
    taps.west = w[0], taps.north = w[north_tap];
    taps.whole = w[0] == 1 << fraction_bits;
    for (int i = 0; i < class_taps(c); ++i) taps.whole &= w[i] % (1 << fraction_bits) == 0;
    taps.northwest = w[northwest_tap], taps.northeast = w[northeast_tap];
    for (size_t i = 1; i < own_taps; ++i) {
      taps.own.add(own_offset[i], w[i]);
      const bool near = i == north_tap || i == northwest_tap || i == northeast_tap;
      (near ? taps.near : taps.far).add(own_offset[i], w[i]);
    }
    w += own_taps;
    if (c & 1)
      for (int i = 0; i < cross_taps; ++i) taps.cross.add(cross_offset(i), *w++);
    if (c & 2)
      for (const int o : previous_offset) taps.previous.add(o, *w++);
  }
  return all;
}

// Returns whether the kept sites of a row follow each other.
HWY_INLINE bool OneRun(unsigned kept) {
  const unsigned run = kept >> std::countr_zero(kept);
  return (run & (run + 1)) == 0;
}

// Adds cells times a weight. Where codes have one byte, cells and weights fit 16 bits, and multiplying these
// takes a quarter of the time.
template<size_t code_bytes, class D>
HWY_INLINE hn::Vec<D> AddWeighted(D d, hn::Vec<D> sum, hn::Vec<D> cells, int32_t weight) {
#if HWY_TARGET != HWY_SCALAR
  if constexpr (code_bytes == 1) {
    const hn::Repartition<int16_t, D> pairs; // a cell and its sign, which counts for nothing
    auto rest = hn::Zero(d);
    const auto products = hn::ReorderWidenMulAccumulate(
        d, hn::BitCast(pairs, cells), hn::BitCast(pairs, hn::Set(d, weight & 0xffff)), hn::Zero(d), rest);
    return hn::Add(sum, hn::RearrangeToOddPlusEven(products, rest));
  }
#endif
  return hn::Add(sum, hn::Mul(cells, hn::Set(d, weight)));
}

// Computes, for the sixteen sites of a row, half of a unit plus the weighted sums of the given taps of the
// own layer and of all taps of the other layers.
template<size_t code_bytes = 4>
HWY_INLINE void Sums(const Row<int32_t>& row, const Taps& taps, const Taps::List& own,
                     int32_t* HWY_RESTRICT sum) {
  const hn::CappedTag<int32_t, brick_edge> d;
  for (size_t x = 0; x < brick_edge; x += hn::Lanes(d)) {
    auto s = hn::Set(d, 1 << (fraction_bits - 1));
    const auto add = [&](const Taps::List& list, const int32_t* cells) HWY_ATTR {
      for (size_t t = 0; t < list.count; ++t)
        s = AddWeighted<code_bytes>(d, s, hn::LoadU(d, cells + list.offset[t] + x), list.weight[t]);
    };
    add(own, row.own);
    if (row.cross) add(taps.cross, row.cross);
    if (row.previous) add(taps.previous, row.previous);
    hn::StoreU(s, d, sum + x);
  }
}
HWY_INLINE void Sums(const Row<int64_t>& row, const Taps& taps, const Taps::List& own,
                     int64_t* HWY_RESTRICT sum) {
  constexpr size_t block = 8; // sums of so many sites stay in registers
  for (size_t x = 0; x < brick_edge; x += block) {
    int64_t s[block];
    for (int64_t& v : s) v = int64_t{1} << (fraction_bits - 1);
    const auto add = [&](const Taps::List& list, const int64_t* cells) HWY_ATTR {
      for (size_t t = 0; t < list.count; ++t) {
        const int64_t* from = cells + list.offset[t] + x;
        const int64_t w = list.weight[t];
        for (size_t i = 0; i < block; ++i) s[i] += w * from[i];
      }
    };
    add(own, row.own);
    if (row.cross) add(taps.cross, row.cross);
    if (row.previous) add(taps.previous, row.previous);
    std::copy_n(s, block, sum + x);
  }
}

HWY_INLINE void Sums(const Row<float>& row, const Taps& taps, const Taps::List& own,
                     float* HWY_RESTRICT sum) {
  const hn::CappedTag<float, brick_edge> d;
  for (size_t x = 0; x < brick_edge; x += hn::Lanes(d)) {
    auto even = hn::Set(d, 1 << (fraction_bits - 1)), odd = hn::Zero(d); // which need not wait for each other
    const auto add = [&](const Taps::List& list, const float* cells) HWY_ATTR {
      const auto term = [&](size_t t, auto to) HWY_ATTR {
        const auto weight = hn::Set(d, static_cast<float>(list.weight[t]));
        return hn::MulAdd(hn::LoadU(d, cells + list.offset[t] + x), weight, to);
      };
      size_t t = 0;
      for (; t + 2 <= list.count; t += 2) even = term(t, even), odd = term(t + 1, odd);
      if (t < list.count) even = term(t, even);
    };
    add(own, row.own);
    if (row.cross) add(taps.cross, row.cross);
    if (row.previous) add(taps.previous, row.previous);
    hn::StoreU(hn::Add(even, odd), d, sum + x);
  }
}

// Sets the cells of the kept sites of a row, all of which may be kept.
template<class D>
HWY_INLINE const uint32_t* FillRow(D* HWY_RESTRICT own, const uint32_t* HWY_RESTRICT code, unsigned kept,
                                   int64_t air) {
  if (kept == full_row && sizeof(D) == 4) {
    const auto low = static_cast<int32_t>(air);
    for (size_t x = 0; x < brick_edge; ++x) own[x] = static_cast<D>(static_cast<int32_t>(code[x]) - low);
    return code + brick_edge;
  }
  for (unsigned bits = kept; bits; bits &= bits - 1)
    own[std::countr_zero(bits)] = static_cast<D>(*code++ - air);
  return code;
}

HWY_INLINE uint32_t Fold(uint32_t difference, uint32_t mask) {
  const uint32_t d = difference & mask;
  return (d > mask >> 1 ? 2 * (mask - d) + 1 : 2 * d) & mask;
}

template<class D> HWY_INLINE const Taps& TapsFor(const std::array<Taps, classes>& all, const Row<D>& row) {
  return all[(row.cross ? 1 : 0) | (row.previous ? 2 : 0)];
}

// The prediction, relative to air.
template<class D> HWY_INLINE D Limited(D sum, D low, D high) {
  return std::min(std::max<D>(sum >> fraction_bits, low), high);
}

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#endif

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "formats/bcc4_predict_rows.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cstring>

#include "formats/bcc4_predict_rows.h"

// Exact integers: every target computes the same. D is int32_t for codes of up to 16 bits, whose sums fit it
// by the rule for weights, else int64_t.
HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

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
  List near, far;                                            // of `own`: those in the row before, the others
  int32_t west = 0, north = 0, northwest = 0, northeast = 0; // x - 1, and in the row before: x, x - 1, x + 1
  bool whole = true;                                         // every weight is a multiple of 1, west is 1
};
constexpr size_t north_tap = 1, northwest_tap = 3, northeast_tap = 7; // of the own layer

inline std::array<Taps, classes> TapsOf(const ClassWeights& weights) {
  std::array<Taps, classes> all;
  for (int c = 0; c < classes; ++c) {
    Taps& taps = all[static_cast<size_t>(c)];
    const int16_t* w = weights[static_cast<size_t>(c)].data();
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

// Half of a unit and the weighted sums of the given taps of the own layer and all of the others, for the
// sixteen sites of a row.
HWY_INLINE void Sums(const Row<int32_t>& row, const Taps& taps, const Taps::List& own,
                     int32_t* HWY_RESTRICT sum) {
  const hn::CappedTag<int32_t, brick_edge> d;
  for (size_t x = 0; x < brick_edge; x += hn::Lanes(d)) {
    auto s = hn::Set(d, 1 << (fraction_bits - 1));
    const auto add = [&](const Taps::List& list, const int32_t* cells) HWY_ATTR {
      for (size_t t = 0; t < list.count; ++t)
        s = hn::Add(s, hn::Mul(hn::LoadU(d, cells + list.offset[t] + x), hn::Set(d, list.weight[t])));
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

template<class D> HWY_INLINE const Taps& TapsFor(const std::array<Taps, classes>& all, const Row<D>& row) {
  return all[static_cast<size_t>((row.cross ? 1 : 0) | (row.previous ? 2 : 0))];
}

HWY_INLINE uint32_t Fold(uint32_t difference, uint32_t mask) {
  const uint32_t d = difference & mask;
  return (d > mask >> 1 ? 2 * (mask - d) + 1 : 2 * d) & mask;
}
HWY_INLINE uint32_t Unfold(uint32_t f, uint32_t mask) { return (f >> 1 ^ (0 - (f & 1))) & mask; }

// The prediction, relative to air.
template<class D> HWY_INLINE D Limited(D sum, D low, D high) {
  return std::min(std::max<D>(sum >> fraction_bits, low), high);
}

template<class D>
void Predict(const ChunkSites& sites, const ChunkCodes& codes, const ClassWeights& weights, uint32_t* out) {
  const std::array<Taps, classes> all = TapsOf(weights);
  const uint32_t* code = sites.codes.data();
  const uint32_t mask = codes.mask();
  const D air = static_cast<D>(codes.air), low = -air, high = static_cast<D>(mask) - air;
  walk<D>(sites.shape, sites.kept, [&](const Row<D>& row) HWY_ATTR {
    const unsigned kept = sites.kept[static_cast<size_t>(row.layer)][static_cast<size_t>(row.index)];
    for (unsigned bits = kept; bits; bits &= bits - 1)
      row.own[std::countr_zero(bits)] = static_cast<D>(*code++) - air;
    const Taps& taps = TapsFor(all, row);
    D sum[brick_edge];
    Sums(row, taps, taps.own, sum);
    uint32_t folded[brick_edge];
    for (size_t x = 0; x < brick_edge; ++x) {
      const D p = Limited<D>(sum[x] + taps.west * row.own[static_cast<std::ptrdiff_t>(x) - 1], low, high);
      folded[x] = Fold(static_cast<uint32_t>(row.own[x]) - static_cast<uint32_t>(p), mask);
    }
    for (unsigned bits = kept; bits; bits &= bits - 1) *out++ = folded[std::countr_zero(bits)];
  });
}

// Codes of one row at the places of its sites, anything where none is kept, and what they are made from.
struct RowCodes {
  alignas(64) uint32_t residual[brick_edge], code[brick_edge]{};
};

// Whether the kept sites of a row follow each other.
HWY_INLINE bool OneRun(unsigned kept) {
  const unsigned run = kept >> std::countr_zero(kept);
  return (run & (run + 1)) == 0;
}

// Reads the residuals of a row from byte planes and writes its codes packed. Rows of one run are moved as
// sixteen sites; what lies beside the run is read for nothing and overwritten by the rows that follow.
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
  HWY_INLINE void Get(unsigned kept, uint32_t* HWY_RESTRICT residual) const {
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
      const auto byte = [&](std::ptrdiff_t plane) HWY_ATTR {
        return hn::PromoteTo(d, hn::LoadU(d8, from + plane * count + static_cast<std::ptrdiff_t>(x)));
      };
      auto r = byte(0);
      if constexpr (sizeof(Stored) >= 2) r = hn::Or(r, hn::ShiftLeft<8>(byte(1)));
      if constexpr (sizeof(Stored) == 4)
        r = hn::Or(r, hn::Or(hn::ShiftLeft<16>(byte(2)), hn::ShiftLeft<24>(byte(3))));
      hn::StoreU(r, d, residual + x);
    }
  }
  HWY_INLINE void Put(unsigned kept, const uint32_t* HWY_RESTRICT code) {
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

template<class D> struct CodeLimits {
  uint32_t mask, air;
  D low, high; // of predictions, relative to air
};

// All taps of the rows of one layer but x - 1, as differences to the cell of the own site. The row before
// comes last: its cells have just been written.
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

// Codes of the sites from x on, as many as a vector has; their cells become code minus air where kept, else
// 0.
template<class D, class DU = hn::RebindToUnsigned<D>>
HWY_INLINE hn::Vec<D> CodesFrom(D d, int32_t* own, const LayerTaps& taps, unsigned kept,
                                const CodeLimits<int32_t>& limits, size_t x, hn::Vec<DU> residual) {
  const DU du;
  auto even = hn::Set(d, 1 << (fraction_bits - 1)), odd = hn::Zero(d);
  size_t t = 0;
  for (; t + 1 < taps.count; t += 2) {
    even = hn::Add(even, hn::Mul(hn::LoadU(d, own + taps.offset[t] + x), hn::Set(d, taps.weight[t])));
    odd = hn::Add(odd, hn::Mul(hn::LoadU(d, own + taps.offset[t + 1] + x), hn::Set(d, taps.weight[t + 1])));
  }
  if (t < taps.count)
    even = hn::Add(even, hn::Mul(hn::LoadU(d, own + taps.offset[t] + x), hn::Set(d, taps.weight[t])));
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

// A row of one run, from its first site on: residuals and codes stand as they do in the planes and among the
// codes.
template<class D, class Stored>
HWY_INLINE void OneRunFrom(D d, int32_t* own, const LayerTaps& taps, unsigned kept, size_t first,
                           size_t length, const CodeLimits<int32_t>& limits, const PackedRows<Stored>& rows) {
  const hn::RebindToUnsigned<D> du;
  const hn::Rebind<uint8_t, D> d8;
  const hn::Rebind<Stored, D> packed;
  const auto* from = reinterpret_cast<const uint8_t*>(rows.planes) + rows.at;
  auto* to = reinterpret_cast<Stored*>(rows.packed) + rows.at;
  for (size_t i = 0; i < length; i += hn::Lanes(d)) {
    auto residual = hn::PromoteTo(du, hn::LoadU(d8, from + i));
    if constexpr (sizeof(Stored) == 2) {
      const auto high = hn::LoadU(d8, from + rows.count + static_cast<std::ptrdiff_t>(i));
      residual = hn::Or(residual, hn::ShiftLeft<8>(hn::PromoteTo(du, high)));
    }
    const auto code = CodesFrom(d, own, taps, kept, limits, first + i, residual);
    hn::StoreU(hn::DemoteTo(packed, code), packed, to + i);
  }
}

// A row whose sites do not depend on each other.
template<class Stored>
HWY_INLINE void Parallel(const Row<int32_t>& row, const Taps& all, LayerTaps& taps, unsigned kept,
                         const CodeLimits<int32_t>& limits, PackedRows<Stored>& rows) {
  const hn::CappedTag<int32_t, brick_edge> d;
  const hn::CappedTag<int32_t, brick_edge / 2> half;
  taps.Set(row, all);
  if (OneRun(kept)) {
    const auto first = static_cast<size_t>(std::countr_zero(kept));
    const auto length = static_cast<size_t>(std::bit_width(kept)) - first;
    if (length > brick_edge / 2)
      OneRunFrom(d, row.own, taps, kept, first, length, limits, rows);
    else
      OneRunFrom(half, row.own, taps, kept, first, length, limits, rows);
    rows.at += static_cast<std::ptrdiff_t>(length);
    return;
  }
  const hn::RebindToUnsigned<decltype(d)> du;
  RowCodes q;
  rows.Get(kept, q.residual);
  for (size_t x = 0; x < brick_edge; x += hn::Lanes(d)) {
    const auto code = CodesFrom(d, row.own, taps, kept, limits, x, hn::Load(du, q.residual + x));
    hn::Store(hn::BitCast(du, code), du, q.code + x);
  }
  rows.Put(kept, q.code);
}
HWY_INLINE void Parallel(const Row<int64_t>& row, const Taps& taps, LayerTaps&, unsigned kept,
                         const CodeLimits<int64_t>& limits, PackedRows<uint32_t>& rows) {
  RowCodes q;
  rows.Get(kept, q.residual);
  int64_t sum[brick_edge];
  Sums(row, taps, taps.own, sum);
  for (size_t x = 0; x < brick_edge; ++x) {
    const auto p = static_cast<uint32_t>(Limited<int64_t>(sum[x], limits.low, limits.high));
    const uint32_t code = (p + Unfold(q.residual[x], limits.mask) + limits.air) & limits.mask;
    q.code[x] = code;
    row.own[x] = kept >> x & 1 ? static_cast<int64_t>(code) - static_cast<int64_t>(limits.air) : 0;
  }
  rows.Put(kept, q.code);
}

// A run of sites whose predictions are the cell before plus `sum`, units and their half included: sums along
// the row, as long as nothing is clamped and nothing wraps. False if something does.
template<class D>
HWY_INLINE bool Accumulate(const D* HWY_RESTRICT sum, unsigned kept, const CodeLimits<D>& limits, D* own,
                           RowCodes& q) {
  const auto first = static_cast<size_t>(std::countr_zero(kept));
  const auto end = static_cast<size_t>(std::bit_width(kept));
  D step[brick_edge], units[brick_edge], prediction[brick_edge] = {}, cell[brick_edge] = {};
  for (size_t x = 0; x < brick_edge; ++x) {
    step[x] = static_cast<D>(static_cast<int32_t>(q.residual[x] >> 1 ^ (0 - (q.residual[x] & 1))));
    units[x] = sum[x] >> fraction_bits;
  }
  using U = std::make_unsigned_t<D>; // wraps
  U g = static_cast<U>(own[static_cast<std::ptrdiff_t>(first) - 1]);
  for (size_t x = first; x < end; ++x) {
    prediction[x] = static_cast<D>(g + static_cast<U>(units[x]));
    g += static_cast<U>(units[x]) + static_cast<U>(step[x]);
    cell[x] = static_cast<D>(g);
  }
  // Negative if anything is outside; 0, which stands beside the run, is inside.
  D outside = 0;
  for (size_t x = 0; x < brick_edge; ++x)
    outside |= (cell[x] - limits.low) | (limits.high - cell[x]) | (prediction[x] - limits.low) |
               (limits.high - prediction[x]);
  if (outside < 0) return false;
  for (size_t x = 0; x < brick_edge; ++x) {
    own[x] = cell[x];
    q.code[x] = static_cast<uint32_t>(cell[x]) + limits.air;
  }
  return true;
}

template<class D, class Stored>
void Unpredict(const ChunkShape& shape, std::span<const BrickMask> kept, const ChunkCodes& codes,
               const ClassWeights& weights, std::span<const std::byte> planes, std::byte* packed) {
  const std::array<Taps, classes> all = TapsOf(weights);
  const uint32_t mask = codes.mask(), air = codes.air;
  const CodeLimits<D> limits{mask, air, -static_cast<D>(air), static_cast<D>(mask) - static_cast<D>(air)};
  const D low = limits.low, high = limits.high;
  PackedRows<Stored> rows{planes.data(), static_cast<std::ptrdiff_t>(planes.size() / sizeof(Stored)), packed};
  LayerTaps layer_taps;
  using U = std::make_unsigned_t<D>; // wraps
  // Two full rows at once, the second one two sites behind, when it has all it is predicted from: two chains
  // from code to code that do not wait for each other.
  const auto pair = [&](const Row<D>& a, const Row<D>& b, bool repeats) HWY_ATTR {
    const BrickMask& layer = kept[static_cast<size_t>(a.layer)];
    const auto width = static_cast<size_t>(a.width);
    const unsigned full = (1u << width) - 1;
    if (width < 2 || layer[static_cast<size_t>(a.index)] != full ||
        layer[static_cast<size_t>(b.index)] != full)
      return false;
    const Taps& taps = TapsFor(all, a);
    if (taps.west == 0 || taps.whole) return false;
    D sum_a[brick_edge], sum_b[brick_edge];
    Sums(a, taps, taps.own, sum_a);
    Sums(b, taps, taps.far, sum_b);
    const auto west = static_cast<U>(static_cast<D>(taps.west));
    RowCodes row_a, row_b;
    rows.Get(full, row_a.residual);
    rows.at += a.width;
    rows.Get(full, row_b.residual);
    rows.at -= a.width;
    uint32_t step_a[brick_edge], step_b[brick_edge];
    for (size_t x = 0; x < brick_edge; ++x) {
      step_a[x] = Unfold(row_a.residual[x], mask) + air;
      step_b[x] = Unfold(row_b.residual[x], mask) + air;
      sum_a[x] = static_cast<D>(static_cast<U>(sum_a[x]) - west * air);
      sum_b[x] = static_cast<D>(static_cast<U>(sum_b[x]) - west * air);
    }
    D above[brick_edge + 2]; // the first row with the cells beside it
    above[0] = a.own[-1];
    uint32_t q_a = static_cast<uint32_t>(a.own[-1]) + air, q_b = 0;
    const auto next_a = [&](size_t x) HWY_ATTR {
      const D p = Limited<D>(static_cast<D>(static_cast<U>(sum_a[x]) + west * q_a), low, high);
      q_a = (static_cast<uint32_t>(p) + step_a[x]) & mask;
      row_a.code[x] = q_a;
      above[x + 1] = static_cast<D>(q_a) - static_cast<D>(air);
    };
    const auto next_b = [&](size_t x) HWY_ATTR {
      const D near = taps.north * above[x + 1] + taps.northwest * above[x] + taps.northeast * above[x + 2];
      const D p =
          Limited<D>(static_cast<D>(static_cast<U>(sum_b[x]) + static_cast<U>(near) + west * q_b), low, high);
      q_b = (static_cast<uint32_t>(p) + step_b[x]) & mask;
      row_b.code[x] = q_b;
    };
    next_a(0);
    next_a(1);
    q_b = static_cast<uint32_t>(repeats ? above[1] : b.own[-1]) + air;
    for (size_t x = 2; x < width; ++x) {
      next_a(x);
      next_b(x - 2);
    }
    above[width + 1] = above[width];
    next_b(width - 2);
    next_b(width - 1);
    for (size_t x = 0; x < width; ++x) {
      a.own[x] = above[x + 1];
      b.own[x] = static_cast<D>(row_b.code[x]) - static_cast<D>(air);
    }
    rows.Put(full, row_a.code);
    rows.Put(full, row_b.code);
    return true;
  };
  const auto one = [&](const Row<D>& row) HWY_ATTR {
    const unsigned here = kept[static_cast<size_t>(row.layer)][static_cast<size_t>(row.index)];
    const Taps& taps = TapsFor(all, row);
    if (taps.west == 0) {
      Parallel(row, taps, layer_taps, here, limits, rows);
    } else {
      RowCodes q;
      rows.Get(here, q.residual);
      D sum[brick_edge];
      Sums(row, taps, taps.own, sum);
      if (taps.whole && OneRun(here) && Accumulate(sum, here, limits, row.own, q)) {
        rows.Put(here, q.code);
        return;
      }
      // From code to code: the air in x - 1 goes into the sum beforehand, so that the chain is short. The
      // step is the difference to the prediction, and air, which the prediction lacks.
      const auto west = static_cast<U>(static_cast<D>(taps.west));
      uint32_t step[brick_edge];
      for (size_t x = 0; x < brick_edge; ++x) {
        step[x] = Unfold(q.residual[x], mask) + air;
        sum[x] = static_cast<D>(static_cast<U>(sum[x]) - west * air);
      }
      const auto first = static_cast<size_t>(std::countr_zero(here));
      const auto end = static_cast<size_t>(std::bit_width(here));
      uint32_t code = static_cast<uint32_t>(row.own[static_cast<std::ptrdiff_t>(first) - 1]) + air;
      for (size_t x = first; x < end; ++x) {
        const D p = Limited<D>(static_cast<D>(static_cast<U>(sum[x]) + west * code), low, high);
        code = here >> x & 1 ? (static_cast<uint32_t>(p) + step[x]) & mask : air;
        q.code[x] = code;
        row.own[x] = static_cast<D>(code) - static_cast<D>(air);
      }
      rows.Put(here, q.code);
    }
  };
  walk<D>(shape, kept, one, pair);
}

void Predict32(const ChunkSites& s, const ChunkCodes& c, const ClassWeights& w, uint32_t* out) {
  Predict<int32_t>(s, c, w, out);
}
void Predict64(const ChunkSites& s, const ChunkCodes& c, const ClassWeights& w, uint32_t* out) {
  Predict<int64_t>(s, c, w, out);
}
void Unpredict8(const ChunkShape& s, std::span<const BrickMask> k, const ChunkCodes& c, const ClassWeights& w,
                std::span<const std::byte> planes, std::byte* packed) {
  Unpredict<int32_t, uint8_t>(s, k, c, w, planes, packed);
}
void Unpredict16(const ChunkShape& s, std::span<const BrickMask> k, const ChunkCodes& c,
                 const ClassWeights& w, std::span<const std::byte> planes, std::byte* packed) {
  Unpredict<int32_t, uint16_t>(s, k, c, w, planes, packed);
}
void Unpredict32(const ChunkShape& s, std::span<const BrickMask> k, const ChunkCodes& c,
                 const ClassWeights& w, std::span<const std::byte> planes, std::byte* packed) {
  Unpredict<int64_t, uint32_t>(s, k, c, w, planes, packed);
}

} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {

HWY_EXPORT(Predict32);
HWY_EXPORT(Predict64);
HWY_EXPORT(Unpredict8);
HWY_EXPORT(Unpredict16);
HWY_EXPORT(Unpredict32);

void predict_rows(const ChunkSites& sites, const ChunkCodes& codes, const ClassWeights& weights,
                  uint32_t* residuals) {
  if (codes.type == ValueType::f32)
    HWY_DYNAMIC_DISPATCH(Predict64)(sites, codes, weights, residuals);
  else
    HWY_DYNAMIC_DISPATCH(Predict32)(sites, codes, weights, residuals);
}

void unpredict_rows(const ChunkShape& shape, std::span<const BrickMask> kept, const ChunkCodes& codes,
                    const ClassWeights& weights, std::span<const std::byte> planes, std::byte* packed) {
  const uint32_t bytes = codes.bytes();
  if (bytes == 1)
    HWY_DYNAMIC_DISPATCH(Unpredict8)(shape, kept, codes, weights, planes, packed);
  else if (bytes == 2)
    HWY_DYNAMIC_DISPATCH(Unpredict16)(shape, kept, codes, weights, planes, packed);
  else
    HWY_DYNAMIC_DISPATCH(Unpredict32)(shape, kept, codes, weights, planes, packed);
}

} // namespace bccsplat
#endif

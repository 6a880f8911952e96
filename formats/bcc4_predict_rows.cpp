#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "formats/bcc4_predict_rows.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <bit>

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
  List far;                                                  // of `own` those that are not in the row before
  int32_t west = 0, north = 0, northwest = 0, northeast = 0; // x - 1, and in the row before: x, x - 1, x + 1
};
constexpr size_t north_tap = 1, northwest_tap = 3, northeast_tap = 7; // of the own layer

inline std::array<Taps, classes> TapsOf(const ClassWeights& weights) {
  std::array<Taps, classes> all;
  for (int c = 0; c < classes; ++c) {
    Taps& taps = all[static_cast<size_t>(c)];
    const int16_t* w = weights[static_cast<size_t>(c)].data();
    taps.west = w[0], taps.north = w[north_tap];
    taps.northwest = w[northwest_tap], taps.northeast = w[northeast_tap];
    for (size_t i = 1; i < own_taps; ++i) {
      taps.own.add(own_offset[i], w[i]);
      if (i != north_tap && i != northwest_tap && i != northeast_tap) taps.far.add(own_offset[i], w[i]);
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
  std::fill_n(sum, brick_edge, int64_t{1} << (fraction_bits - 1));
  const auto add = [&](const Taps::List& list, const int64_t* cells) HWY_ATTR {
    for (size_t t = 0; t < list.count; ++t) {
      const int64_t* HWY_RESTRICT from = cells + list.offset[t];
      const int64_t w = list.weight[t];
      for (size_t x = 0; x < brick_edge; ++x) sum[x] += w * from[x];
    }
  };
  add(own, row.own);
  if (row.cross) add(taps.cross, row.cross);
  if (row.previous) add(taps.previous, row.previous);
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
  walk<D>(sites.shape, [&](const Row<D>& row) HWY_ATTR {
    const unsigned kept = sites.kept[static_cast<size_t>(row.layer)][static_cast<size_t>(row.index)];
    if (kept == 0) return;
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

template<class D>
void Unpredict(const ChunkSites& sites, const ChunkCodes& codes, const ClassWeights& weights,
               const uint32_t* residual, uint32_t* code) {
  const std::array<Taps, classes> all = TapsOf(weights);
  const uint32_t mask = codes.mask(), air = codes.air;
  const D low = -static_cast<D>(air), high = static_cast<D>(mask) - static_cast<D>(air);
  using U = std::make_unsigned_t<D>; // wraps
  // Two full rows at once, the second one two sites behind, when it has all it is predicted from: two chains
  // from code to code that do not wait for each other.
  const auto pair = [&](const Row<D>& a, const Row<D>& b, bool repeats) HWY_ATTR {
    const BrickMask& rows = sites.kept[static_cast<size_t>(a.layer)];
    const auto width = static_cast<size_t>(a.width);
    const unsigned full = (1u << width) - 1;
    if (width < 2 || rows[static_cast<size_t>(a.index)] != full || rows[static_cast<size_t>(b.index)] != full)
      return false;
    const Taps& taps = TapsFor(all, a);
    if (taps.west == 0) return false;
    D sum_a[brick_edge], sum_b[brick_edge];
    Sums(a, taps, taps.own, sum_a);
    Sums(b, taps, taps.far, sum_b);
    const auto west = static_cast<U>(static_cast<D>(taps.west));
    uint32_t step_a[brick_edge], step_b[brick_edge];
    for (size_t x = 0; x < width; ++x) {
      step_a[x] = Unfold(residual[x], mask) + air;
      step_b[x] = Unfold(residual[width + x], mask) + air;
      sum_a[x] = static_cast<D>(static_cast<U>(sum_a[x]) - west * air);
      sum_b[x] = static_cast<D>(static_cast<U>(sum_b[x]) - west * air);
    }
    uint32_t* const code_b = code + width;
    D above[brick_edge + 2]; // the first row with the cells beside it
    above[0] = a.own[-1];
    uint32_t q_a = static_cast<uint32_t>(a.own[-1]) + air, q_b = 0;
    const auto next_a = [&](size_t x) HWY_ATTR {
      const D p = Limited<D>(static_cast<D>(static_cast<U>(sum_a[x]) + west * q_a), low, high);
      q_a = (static_cast<uint32_t>(p) + step_a[x]) & mask;
      code[x] = q_a;
      above[x + 1] = static_cast<D>(q_a) - static_cast<D>(air);
    };
    const auto next_b = [&](size_t x) HWY_ATTR {
      const D near = taps.north * above[x + 1] + taps.northwest * above[x] + taps.northeast * above[x + 2];
      const D p =
          Limited<D>(static_cast<D>(static_cast<U>(sum_b[x]) + static_cast<U>(near) + west * q_b), low, high);
      q_b = (static_cast<uint32_t>(p) + step_b[x]) & mask;
      code_b[x] = q_b;
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
      b.own[x] = static_cast<D>(code_b[x]) - static_cast<D>(air);
    }
    code += 2 * width, residual += 2 * width;
    return true;
  };
  const auto one = [&](const Row<D>& row) HWY_ATTR {
    const unsigned kept = sites.kept[static_cast<size_t>(row.layer)][static_cast<size_t>(row.index)];
    if (kept == 0) return;
    const Taps& taps = TapsFor(all, row);
    D sum[brick_edge];
    Sums(row, taps, taps.own, sum);
    if (const auto width = static_cast<size_t>(row.width); kept == (1u << width) - 1) {
      // The difference to the prediction, and air, which the prediction lacks.
      uint32_t step[brick_edge];
      for (size_t x = 0; x < width; ++x) step[x] = Unfold(residual[x], mask) + air;
      if (taps.west == 0) {
        for (size_t x = 0; x < width; ++x)
          code[x] = (static_cast<uint32_t>(Limited<D>(sum[x], low, high)) + step[x]) & mask;
      } else {
        // From code to code: the air in x - 1 goes into the sum beforehand, so that the chain is short.
        const auto west = static_cast<U>(static_cast<D>(taps.west));
        for (size_t x = 0; x < width; ++x) sum[x] = static_cast<D>(static_cast<U>(sum[x]) - west * air);
        uint32_t q = static_cast<uint32_t>(row.own[-1]) + air;
        for (size_t x = 0; x < width; ++x) {
          const D p = Limited<D>(static_cast<D>(static_cast<U>(sum[x]) + west * q), low, high);
          q = (static_cast<uint32_t>(p) + step[x]) & mask;
          code[x] = q;
        }
      }
      for (size_t x = 0; x < width; ++x) row.own[x] = static_cast<D>(code[x]) - static_cast<D>(air);
      code += width, residual += width;
      return;
    }
    for (unsigned bits = kept; bits; bits &= bits - 1) {
      const auto x = static_cast<size_t>(std::countr_zero(bits));
      const D p = Limited<D>(sum[x] + taps.west * row.own[static_cast<std::ptrdiff_t>(x) - 1], low, high);
      *code = (static_cast<uint32_t>(p) + Unfold(*residual++, mask) + air) & mask;
      row.own[x] = static_cast<D>(*code++) - static_cast<D>(air);
    }
  };
  walk<D>(sites.shape, one, pair);
}

void Predict32(const ChunkSites& s, const ChunkCodes& c, const ClassWeights& w, uint32_t* out) {
  Predict<int32_t>(s, c, w, out);
}
void Predict64(const ChunkSites& s, const ChunkCodes& c, const ClassWeights& w, uint32_t* out) {
  Predict<int64_t>(s, c, w, out);
}
void Unpredict32(const ChunkSites& s, const ChunkCodes& c, const ClassWeights& w, const uint32_t* residual,
                 uint32_t* code) {
  Unpredict<int32_t>(s, c, w, residual, code);
}
void Unpredict64(const ChunkSites& s, const ChunkCodes& c, const ClassWeights& w, const uint32_t* residual,
                 uint32_t* code) {
  Unpredict<int64_t>(s, c, w, residual, code);
}

} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {

HWY_EXPORT(Predict32);
HWY_EXPORT(Predict64);
HWY_EXPORT(Unpredict32);
HWY_EXPORT(Unpredict64);

void predict_rows(const ChunkSites& sites, const ChunkCodes& codes, const ClassWeights& weights,
                  uint32_t* residuals) {
  if (codes.type == ValueType::f32)
    HWY_DYNAMIC_DISPATCH(Predict64)(sites, codes, weights, residuals);
  else
    HWY_DYNAMIC_DISPATCH(Predict32)(sites, codes, weights, residuals);
}

void unpredict_rows(const ChunkSites& sites, const ChunkCodes& codes, const ClassWeights& weights,
                    const uint32_t* residuals, uint32_t* decoded) {
  if (codes.type == ValueType::f32)
    HWY_DYNAMIC_DISPATCH(Unpredict64)(sites, codes, weights, residuals, decoded);
  else
    HWY_DYNAMIC_DISPATCH(Unpredict32)(sites, codes, weights, residuals, decoded);
}

} // namespace bccsplat
#endif

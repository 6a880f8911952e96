// SPDX-License-Identifier: Apache-2.0
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "formats/bcc4/coding/predict_rows.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <bit>

#include "formats/bcc4/coding/predict_rows.h"
#include "formats/bcc4/coding/predict_taps-inl.h"

// All of it is exact in integers, so that every target computes the same. D is int32_t for codes of up to 16
// bits, whose sums fit it by the rule for weights, else int64_t.
HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {

HWY_INLINE uint32_t Fold(uint32_t difference, uint32_t mask) {
  const uint32_t d = difference & mask;
  return (d > mask >> 1 ? 2 * (mask - d) + 1 : 2 * d) & mask;
}

template<class D>
void Predict(const ChunkSites& sites, const ChunkCodes& codes, const ClassWeights& weights, uint32_t* out) {
  const std::array<Taps, classes> all = TapsOf(weights);
  const uint32_t* code = sites.codes.data();
  const uint32_t mask = codes.mask();
  const D air = static_cast<D>(codes.air), low = -air, high = static_cast<D>(mask) - air;
  CellRing<D> ring;
  walk_rows<D>(sites.shape, sites.kept, ring, [&](const Row<D>& row) HWY_ATTR {
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

void Predict32(const ChunkSites& s, const ChunkCodes& c, const ClassWeights& w, uint32_t* out) {
  Predict<int32_t>(s, c, w, out);
}
void Predict64(const ChunkSites& s, const ChunkCodes& c, const ClassWeights& w, uint32_t* out) {
  Predict<int64_t>(s, c, w, out);
}

} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {

HWY_EXPORT(Predict32);
HWY_EXPORT(Predict64);

void predict_rows(const ChunkSites& sites, const ChunkCodes& codes, const ClassWeights& weights,
                  uint32_t* residuals) {
  if (codes.bytes() == 4)
    HWY_DYNAMIC_DISPATCH(Predict64)(sites, codes, weights, residuals);
  else
    HWY_DYNAMIC_DISPATCH(Predict32)(sites, codes, weights, residuals);
}

} // namespace bccsplat
#endif

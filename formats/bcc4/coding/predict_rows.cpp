// SPDX-License-Identifier: Apache-2.0
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "formats/bcc4/coding/predict_rows.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <bit>

#include "formats/bcc4/coding/predict_rows.h"
#include "formats/bcc4/coding/predict_taps-inl.h"

// All of it is exact in integers, so that every target computes the same. D is float for codes of 8 bits,
// whose sums of products are whole and less than 2^24 by the rule for weights; int32_t for those of 16, whose
// sums fit it by the same rule; else int64_t.
HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace {

// Computes the folded differences of the sixteen sites of a row to what these weights predict.
template<class D>
HWY_INLINE void Residuals(const Row<D>& row, const Taps& taps, int64_t air, uint32_t mask,
                          uint32_t* HWY_RESTRICT folded) {
  D sum[brick_edge];
  Sums(row, taps, taps.own, sum);
  using Whole = std::conditional_t<sizeof(D) == 4, int32_t, int64_t>;
  const auto low = static_cast<Whole>(-air), high = static_cast<Whole>(mask - air);
  const auto west = static_cast<D>(taps.west);
  for (size_t x = 0; x < brick_edge; ++x) {
    const auto s = static_cast<Whole>(sum[x] + west * row.own[static_cast<std::ptrdiff_t>(x) - 1]);
    folded[x] =
        Fold(static_cast<uint32_t>(static_cast<Whole>(row.own[x]) - Limited<Whole>(s, low, high)), mask);
  }
}

template<class D>
void Predict(const ChunkSites& sites, const ChunkCodes& codes, std::span<const Prediction> wanted) {
  constexpr size_t most = 2;
  std::array<std::array<Taps, classes>, most> all;
  std::array<uint32_t*, most> out{};
  const size_t count = wanted.size();
  for (size_t i = 0; i < count; ++i) all[i] = TapsOf(*wanted[i].weights), out[i] = wanted[i].residuals;
  const uint32_t* code = sites.codes.data();
  const uint32_t mask = codes.mask();
  const int64_t air = codes.air;
  CellRing<D> ring;
  walk_rows<D>(sites.shape, sites.kept, ring, [&](const Row<D>& row) HWY_ATTR {
    const unsigned kept = sites.kept[row.layer][row.index];
    code = FillRow(row.own, code, kept, air);
    for (size_t i = 0; i < count; ++i) {
      const Taps& taps = TapsFor(all[i], row);
      if (kept == full_row) {
        Residuals(row, taps, air, mask, out[i]);
        out[i] += brick_edge;
        continue;
      }
      uint32_t folded[brick_edge];
      Residuals(row, taps, air, mask, folded);
      for (unsigned bits = kept; bits; bits &= bits - 1) *out[i]++ = folded[std::countr_zero(bits)];
    }
  });
}

void Predict8(const ChunkSites& s, const ChunkCodes& c, std::span<const Prediction> wanted) {
  Predict<float>(s, c, wanted);
}
void Predict16(const ChunkSites& s, const ChunkCodes& c, std::span<const Prediction> wanted) {
  Predict<int32_t>(s, c, wanted);
}
void Predict32(const ChunkSites& s, const ChunkCodes& c, std::span<const Prediction> wanted) {
  Predict<int64_t>(s, c, wanted);
}

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {

HWY_EXPORT(Predict8);
HWY_EXPORT(Predict16);
HWY_EXPORT(Predict32);

void predict_rows(const ChunkSites& sites, const ChunkCodes& codes, std::span<const Prediction> wanted) {
  if (codes.bytes() == 1) return HWY_DYNAMIC_DISPATCH(Predict8)(sites, codes, wanted);
  if (codes.bytes() == 2) return HWY_DYNAMIC_DISPATCH(Predict16)(sites, codes, wanted);
  HWY_DYNAMIC_DISPATCH(Predict32)(sites, codes, wanted);
}

} // namespace bccsplat
#endif

// SPDX-License-Identifier: Apache-2.0
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "formats/bcc4/wavelet/layer_sums.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <bit>

#include "formats/bcc4/wavelet/layer_sums.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace {

template<class D> HWY_INLINE hn::Vec<D> SumAt(D d, std::span<const WeighedLayer> layers, size_t at) {
  auto sum = hn::Zero(d);
  for (const WeighedLayer& l : layers)
    sum = hn::Add(sum, hn::Mul(hn::Set(d, l.weight), hn::LoadU(d, l.first + at)));
  return sum;
}

void SumLayers(std::span<const WeighedLayer> layers, size_t begin, size_t count, float* to) {
  const hn::ScalableTag<float> d;
  const hn::CappedTag<float, 1> one;
  size_t i = 0;
  for (; i + hn::Lanes(d) <= count; i += hn::Lanes(d)) hn::StoreU(SumAt(d, layers, begin + i), d, to + i);
  for (; i < count; ++i) hn::StoreU(SumAt(one, layers, begin + i), one, to + i);
}

// Sixteen codes.
template<class Code>
HWY_INLINE void RowCodes(std::span<const WeighedLayer> layers, size_t at, const RoundedCodes& codes,
                         Code* to) {
  const hn::CappedTag<float, brick_edge> d;
  const hn::RebindToSigned<decltype(d)> di;
  const hn::Rebind<Code, decltype(d)> narrow;
  constexpr float half = .5F;
  for (size_t x = 0; x < brick_edge; x += hn::Lanes(d)) {
    const auto up = hn::Add(hn::Add(SumAt(d, layers, at + x), hn::Set(d, codes.air)), hn::Set(d, half));
    const auto held = hn::Min(hn::Max(hn::Floor(up), hn::Set(d, codes.low)), hn::Set(d, codes.high));
    hn::StoreU(hn::DemoteTo(narrow, hn::ConvertTo(di, held)), narrow, to + x);
  }
}

template<class Code>
Code* BrickSums(std::span<const WeighedLayer> layers, const BrickRows& rows, const RoundedCodes& codes,
                const BrickMask& kept, Code* to) {
  for (size_t r = 0; r < brick_rows; ++r) {
    const unsigned row = kept[r];
    if (row == 0) continue;
    const size_t at = rows.first + r / brick_edge * rows.plane + r % brick_edge * rows.row;
    if ((row & (row + 1)) == 0) {
      RowCodes(layers, at, codes, to);
      to += std::bit_width(row);
      continue;
    }
    alignas(64) Code all[brick_edge];
    RowCodes(layers, at, codes, all);
    for (unsigned bits = row; bits; bits &= bits - 1) *to++ = all[std::countr_zero(bits)];
  }
  return to;
}

uint8_t* BrickSums8(std::span<const WeighedLayer> layers, const BrickRows& rows, const RoundedCodes& codes,
                    const BrickMask& kept, uint8_t* to) {
  return BrickSums(layers, rows, codes, kept, to);
}
uint16_t* BrickSums16(std::span<const WeighedLayer> layers, const BrickRows& rows, const RoundedCodes& codes,
                      const BrickMask& kept, uint16_t* to) {
  return BrickSums(layers, rows, codes, kept, to);
}

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {

HWY_EXPORT(SumLayers);
HWY_EXPORT(BrickSums8);
HWY_EXPORT(BrickSums16);

void sum_layers(std::span<const WeighedLayer> layers, size_t begin, size_t count, float* to) {
  HWY_DYNAMIC_DISPATCH(SumLayers)(layers, begin, count, to);
}

uint8_t* sum_to_codes(std::span<const WeighedLayer> layers, const BrickRows& rows, const RoundedCodes& codes,
                      const BrickMask& kept, uint8_t* to) {
  return HWY_DYNAMIC_DISPATCH(BrickSums8)(layers, rows, codes, kept, to);
}

uint16_t* sum_to_codes(std::span<const WeighedLayer> layers, const BrickRows& rows, const RoundedCodes& codes,
                       const BrickMask& kept, uint16_t* to) {
  return HWY_DYNAMIC_DISPATCH(BrickSums16)(layers, rows, codes, kept, to);
}

} // namespace bccsplat
#endif

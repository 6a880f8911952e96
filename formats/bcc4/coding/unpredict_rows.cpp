// SPDX-License-Identifier: Apache-2.0
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "formats/bcc4/coding/unpredict_rows.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include "formats/bcc4/coding/predict_rows.h"
#include "formats/bcc4/coding/unpredict_chains-inl.h"
#include "formats/bcc4/coding/unpredict_planes-inl.h"
#include "formats/bcc4/coding/unpredict_wide-inl.h"

// All of it is exact in integers, so that every target computes the same.
HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace {

// Decodes codes of up to 16 bits, whose sums all fit 32 bits by the rule for weights.
template<class Stored>
void Unpredict(const ChunkShape& shape, std::span<const BrickMask> kept, const ChunkCodes& codes,
               const ClassWeights& weights, std::span<const std::byte> planes, std::byte* packed,
               CellRing<int32_t>& ring, const WalkedLayers& layers) {
  ChainedRows<Stored> chained(kept, codes, weights, planes, packed);
  chained.rows.at = layers.codes_before;
#if HWY_TARGET != HWY_SCALAR
  [[maybe_unused]] FullPlanes whole(chained.limits, chained.layer_taps);
#endif
  walk_rows<int32_t>(
      shape, kept, ring,
      [&](const Row<int32_t>& row) HWY_ATTR {
        const Taps& taps = TapsFor(chained.all, row);
        if (taps.west == 0)
          DecodeParallel(row, taps, chained.layer_taps, chained.Kept(row), chained.limits, chained.rows);
        else
          chained.DecodeRow(row, taps);
      },
      [&](const Row<int32_t>& a, const Row<int32_t>& b, bool repeats)
          HWY_ATTR { return chained.DecodePair(a, b, repeats); },
      [&]([[maybe_unused]] const Row<int32_t>& row, [[maybe_unused]] int height,
          [[maybe_unused]] bool repeats) HWY_ATTR {
#if HWY_TARGET != HWY_SCALAR
        if constexpr (sizeof(Stored) == 1) {
          constexpr int least_width = brick_edge / 2; // a narrow plane takes as long as a wide one
          const Taps& taps = TapsFor(chained.all, row);
          if (taps.west == 0 || taps.whole || row.width < least_width || height < least_width) return false;
          chained.layer_taps.Set(row, taps);
          whole.Decode(row, height, taps, repeats, chained.rows);
          return true;
        }
#endif
        return false;
      },
      layers);
}

void Unpredict8(const ChunkShape& s, std::span<const BrickMask> k, const ChunkCodes& c, const ClassWeights& w,
                std::span<const std::byte> planes, std::byte* packed, CellRing<int32_t>& ring,
                const WalkedLayers& layers) {
  Unpredict<uint8_t>(s, k, c, w, planes, packed, ring, layers);
}
void Unpredict16(const ChunkShape& s, std::span<const BrickMask> k, const ChunkCodes& c,
                 const ClassWeights& w, std::span<const std::byte> planes, std::byte* packed,
                 CellRing<int32_t>& ring, const WalkedLayers& layers) {
  Unpredict<uint16_t>(s, k, c, w, planes, packed, ring, layers);
}
void Unpredict32(const ChunkShape& s, std::span<const BrickMask> k, const ChunkCodes& c,
                 const ClassWeights& w, std::span<const std::byte> planes, std::byte* packed,
                 CellRing<int32_t>& ring) {
  WideRows wide(k, c, w, planes, packed);
  walk_rows<int32_t>(s, k, ring, [&](const Row<int32_t>& row) HWY_ATTR { wide.DecodeRow(row); });
}

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {

HWY_EXPORT(Unpredict8);
HWY_EXPORT(Unpredict16);
HWY_EXPORT(Unpredict32);

void unpredict_rows(const ChunkShape& shape, std::span<const BrickMask> kept, const ChunkCodes& codes,
                    const ClassWeights& weights, std::span<const std::byte> planes, std::byte* packed,
                    CellRing<int32_t>& ring, const WalkedLayers& layers) {
  const uint32_t bytes = codes.bytes();
  if (bytes == 1)
    HWY_DYNAMIC_DISPATCH(Unpredict8)(shape, kept, codes, weights, planes, packed, ring, layers);
  else if (bytes == 2)
    HWY_DYNAMIC_DISPATCH(Unpredict16)(shape, kept, codes, weights, planes, packed, ring, layers);
  else
    HWY_DYNAMIC_DISPATCH(Unpredict32)(shape, kept, codes, weights, planes, packed, ring);
}

} // namespace bccsplat
#endif

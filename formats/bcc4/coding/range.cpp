// SPDX-License-Identifier: Apache-2.0
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "formats/bcc4/coding/range.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <algorithm>
#include <cstring>
#include <limits>

#include "formats/bcc4/coding/range.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace {

template<class Stored> std::array<uint32_t, 2> PackedRange(std::span<const std::byte> packed) {
  constexpr size_t most = 64 / sizeof(Stored);
  const hn::CappedTag<Stored, most> d;
  const size_t lanes = hn::Lanes(d), count = packed.size() / sizeof(Stored);
  const auto* codes = reinterpret_cast<const Stored*>(packed.data());
  auto low = hn::Set(d, std::numeric_limits<Stored>::max()), high = hn::Zero(d);
  size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    const auto v = hn::LoadU(d, codes + i);
    low = hn::Min(low, v), high = hn::Max(high, v);
  }
  alignas(64) Stored lowest[most], highest[most];
  hn::Store(low, d, lowest);
  hn::Store(high, d, highest);
  Stored smallest = *std::min_element(lowest, lowest + lanes),
         largest = *std::max_element(highest, highest + lanes);
  for (; i < count; ++i) {
    Stored v;
    std::memcpy(&v, packed.data() + i * sizeof v, sizeof v);
    smallest = std::min(smallest, v), largest = std::max(largest, v);
  }
  return {smallest, largest};
}

std::array<uint32_t, 2> Range8(std::span<const std::byte> packed) { return PackedRange<uint8_t>(packed); }
std::array<uint32_t, 2> Range16(std::span<const std::byte> packed) { return PackedRange<uint16_t>(packed); }
std::array<uint32_t, 2> Range32(std::span<const std::byte> packed) { return PackedRange<uint32_t>(packed); }

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {

HWY_EXPORT(Range8);
HWY_EXPORT(Range16);
HWY_EXPORT(Range32);

std::array<uint32_t, 2> packed_range(std::span<const std::byte> packed, uint32_t bytes) {
  if (bytes == 1) return HWY_DYNAMIC_DISPATCH(Range8)(packed);
  return bytes == 2 ? HWY_DYNAMIC_DISPATCH(Range16)(packed) : HWY_DYNAMIC_DISPATCH(Range32)(packed);
}

} // namespace bccsplat
#endif

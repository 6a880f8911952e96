// SPDX-License-Identifier: Apache-2.0
// Floats to whole numbers of a power of two, and back without loss.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fit/packed_block.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <cmath>

#include "fit/packed_block.h"
#include "points/brick.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace {

// to = from / unit, rounded to nearest, ties to even, for the first `planes` planes and `rows` rows of each.
// Returns whether all of it fits.
bool PackValues(const float* HWY_RESTRICT from, float per_unit, size_t planes, size_t rows,
                int16_t* HWY_RESTRICT to) {
  const hn::CappedTag<float, 16> d;
  const hn::Rebind<int16_t, decltype(d)> narrow;
  const auto scale = hn::Set(d, per_unit), limit = hn::Set(d, 32767.0f);
  auto largest = hn::Zero(d);
  for (size_t z = 0; z < planes; ++z)
    for (size_t i = z * brick_rows; i < z * brick_rows + rows * brick_edge; i += hn::Lanes(d)) {
      const auto units = hn::Mul(hn::Load(d, from + i), scale);
      largest = hn::Max(largest, hn::Abs(units));
      const auto inside = hn::Min(hn::Max(units, hn::Neg(limit)), limit);
      hn::Store(hn::DemoteTo(narrow, hn::NearestInt(inside)), narrow, to + i);
    }
  return hn::GetLane(hn::MaxOfLanes(d, largest)) <= 32767.0f;
}

void UnpackValues(const int16_t* HWY_RESTRICT from, float unit, float* HWY_RESTRICT to) {
  const hn::CappedTag<float, 16> d;
  const hn::RebindToSigned<decltype(d)> whole;
  const hn::Rebind<int16_t, decltype(d)> narrow;
  for (size_t i = 0; i < brick_sites; i += hn::Lanes(d)) {
    const auto units = hn::ConvertTo(d, hn::PromoteTo(whole, hn::Load(narrow, from + i)));
    hn::Store(hn::Mul(units, hn::Set(d, unit)), d, to + i);
  }
}

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {
HWY_EXPORT(PackValues);
HWY_EXPORT(UnpackValues);

float packing_unit(const Quantiser& quantiser) {
  if (is_float(quantiser.type)) return 0;
  const double unit = std::exp2(std::floor(std::log2(quantiser.scale / 64)));
  return unit > 1e-30 && unit < 1e30 ? static_cast<float>(unit) : 0;
}

SiteBlockPtr pack(FloatSitesPtr block, const Int3& size, float unit, SiteBlockPool& pool) {
  if (unit == 0) return block;
  auto packed = pool.packed.take();
  const bool fits =
      HWY_DYNAMIC_DISPATCH(PackValues)(block->value.data(), 1 / unit, size[2], size[1], packed->value.data());
  if (!fits) return block;
  packed->source = block->source, packed->near = block->near;
  packed->largest = block->largest;
  return packed;
}

const float* unpack(const SiteBlock& block, float unit, SiteValues& room) {
  if (!block.packed) return static_cast<const FloatSites&>(block).value.data();
  const auto& values = static_cast<const PackedSites&>(block).value;
  HWY_DYNAMIC_DISPATCH(UnpackValues)(values.data(), unit, room.data());
  return room.data();
}

} // namespace bccsplat
#endif

// SPDX-License-Identifier: Apache-2.0
// Numbers are taken apart into bytes and put together again in lanes of 32 bits, alike on every target.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "points/whole_numbers.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <cmath>

#include "points/whole_numbers.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace {

using Line = hn::CappedTag<float, brick_edge>;
using Bytes = hn::Rebind<uint8_t, Line>;
using Whole = hn::RebindToSigned<Line>;
constexpr size_t plane_sites = brick_edge * brick_edge, half_plane = plane_sites / 2;

void FindRange(const float* HWY_RESTRICT values, size_t planes, size_t rows, size_t columns,
               float* HWY_RESTRICT range) {
  const Line d;
  auto low = hn::Set(d, values[0]), high = low;
  for (size_t z = 0; z < planes; ++z)
    for (size_t y = 0; y < rows; ++y)
      for (size_t x = 0; x < columns; x += hn::Lanes(d)) {
        const auto v = hn::IfThenElse(hn::FirstN(d, columns - x),
                                      hn::Load(d, values + (z * brick_edge + y) * brick_edge + x), low);
        low = hn::Min(low, v), high = hn::Max(high, v);
      }
  range[0] = hn::GetLane(hn::MinOfLanes(d, low));
  range[1] = hn::GetLane(hn::MaxOfLanes(d, high));
}

HWY_INLINE hn::Vec<Whole> Number(const float* value, float per_step, int32_t first) {
  const Line d;
  return hn::Sub(hn::NearestInt(hn::Mul(hn::Load(d, value), hn::Set(d, per_step))), hn::Set(Whole(), first));
}

HWY_INLINE void StoreByte(hn::Vec<Whole> v, uint8_t* to) {
  hn::StoreU(hn::DemoteTo(Bytes(), hn::And(v, hn::Set(Whole(), 255))), Bytes(), to);
}

void WriteNumbers(const float* HWY_RESTRICT values, float per_step, int32_t first, bool twelve,
                  uint8_t* HWY_RESTRICT to) {
  const size_t plane_bytes = plane_sites + (twelve ? half_plane : plane_sites);
  for (size_t z = 0; z < brick_edge; ++z, values += plane_sites, to += plane_bytes)
    for (size_t i = 0; i < half_plane; i += hn::Lanes(Line())) {
      const auto a = Number(values + i, per_step, first);
      const auto b = Number(values + half_plane + i, per_step, first);
      StoreByte(a, to + i);
      StoreByte(b, to + half_plane + i);
      uint8_t* high = to + plane_sites + i;
      const auto above = hn::ShiftRight<8>(a);
      if (twelve) {
        StoreByte(hn::Or(hn::And(above, hn::Set(Whole(), 15)), hn::ShiftLeft<4>(hn::ShiftRight<8>(b))), high);
      } else {
        StoreByte(above, high);
        StoreByte(hn::ShiftRight<8>(b), high + half_plane);
      }
    }
}

HWY_INLINE hn::Vec<Whole> LoadByte(const uint8_t* from) {
  return hn::PromoteTo(Whole(), hn::LoadU(Bytes(), from));
}

// mask, left: where a number's high bits are in their byte, and how far from where they belong. start: the
// first number times the step; nothing is rounded, with a fused sum or without.
template<int mask, int left>
HWY_INLINE void ReadRow(const uint8_t* low, const uint8_t* high, float start, float step, size_t width,
                        float* HWY_RESTRICT to) {
  const Line d;
  const auto bits = hn::Set(Whole(), mask);
  for (size_t x = 0; x < width; x += hn::Lanes(d)) {
    const auto above = hn::ShiftLeft<left>(hn::And(LoadByte(high + x), bits));
    const auto number = hn::ConvertTo(d, hn::Or(LoadByte(low + x), above));
    hn::StoreU(hn::MulAdd(number, hn::Set(d, step), hn::Set(d, start)), d, to + x);
  }
}

void ReadNumbers(const uint8_t* from, bool twelve, float start, float step, const PlanePart& part, float* to,
                 std::ptrdiff_t stride) {
  constexpr int half = brick_edge / 2;
  const size_t plane_bytes = plane_sites + (twelve ? half_plane : plane_sites);
  const uint8_t* low = from + static_cast<size_t>(part.plane) * plane_bytes + part.x;
  const uint8_t* high = low + plane_sites;
  const auto width = static_cast<size_t>(part.width);
  for (int y = part.y; y < part.y + part.height; ++y, to += stride) {
    const uint8_t* row = low + y * brick_edge;
    if (!twelve)
      ReadRow<255, 8>(row, high + y * brick_edge, start, step, width, to);
    else if (y < half)
      ReadRow<15, 8>(row, high + y * brick_edge, start, step, width, to);
    else
      ReadRow<240, 4>(row, high + (y - half) * brick_edge, start, step, width, to);
  }
}

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {
HWY_EXPORT(FindRange);
HWY_EXPORT(WriteNumbers);
HWY_EXPORT(ReadNumbers);

NumberForm number_form(const float* values, const Int3& size, float finest, float coarsest) {
  float range[2];
  HWY_DYNAMIC_DISPATCH(FindRange)
  (values, static_cast<size_t>(size[2]), static_cast<size_t>(size[1]), static_cast<size_t>(size[0]), range);
  constexpr float exact = 1 << 24; // numbers up to this are, as floats
  for (const int bits : {12, 16})
    for (float step = finest; step <= coarsest; step *= 2) {
      const float low = std::nearbyint(range[0] / step), high = std::nearbyint(range[1] / step);
      if (low >= -exact && high <= exact && high - low < static_cast<float>(1 << bits))
        return {step, static_cast<int32_t>(low), bits};
    }
  return {};
}

void write_numbers(const NumberForm& form, const float* values, uint8_t* to) {
  HWY_DYNAMIC_DISPATCH(WriteNumbers)(values, 1 / form.step, form.first, form.bits == 12, to);
  std::fill_n(to + number_bytes(form.bits) - brick_edge, brick_edge, uint8_t{0});
}

void read_numbers(const NumberForm& form, const uint8_t* from, const PlanePart& part, float* to,
                  std::ptrdiff_t stride) {
  HWY_DYNAMIC_DISPATCH(ReadNumbers)
  (from, form.bits == 12, static_cast<float>(form.first) * form.step, form.step, part, to, stride);
}

} // namespace bccsplat
#endif

// SPDX-License-Identifier: Apache-2.0
// Rounds the sites of a brick to stored values and selects the relevant ones.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fit/kept/relevance.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cfloat>
#include <cmath>

#include "base/error.h"
#include "base/half.h"
#include "fit/kept/relevance.h"

#ifndef BCCSPLAT_FIT_ROUNDED_ROW
#define BCCSPLAT_FIT_ROUNDED_ROW
namespace bccsplat {
// A bit for each of sixteen sites: relevant by its value, beyond the type, beyond the ringing.
struct RoundedRow {
  uint16_t relevant, clamped, loud;
};
} // namespace bccsplat
#endif

// Plain loops over sixteen values that the compiler vectorises, once for each instruction set. No contraction
// and no library call: every target rounds alike.
HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace {

using Kind = Relevance::Rounding::Kind;

// Nearest integer, ties to even, for |x| < 2^22 and 2^51: adding 1.5 * 2^23 (2^52) leaves no room for a
// fraction.
HWY_INLINE float Nearest(float x) { return (x + 0x1.8p23f) - 0x1.8p23f; }
HWY_INLINE double Nearest(double x) { return (x + 0x1.8p52) - 0x1.8p52; }

// Rounds to the nearest binary16 value, as a float; beyond the range: 65520 or more.
HWY_INLINE float NearestHalf(float v) {
  const uint32_t bits = std::bit_cast<uint32_t>(v), magnitude = bits & 0x7fffffffu;
  const uint32_t normal = (magnitude + 0xfffu + ((magnitude >> 13) & 1u)) & ~0x1fffu;
  const float tiny = (std::bit_cast<float>(magnitude) + 0.5f) - 0.5f; // below 2^-14: a multiple of 2^-24
  const uint32_t rounded = magnitude < 0x38800000u ? std::bit_cast<uint32_t>(tiny) : normal;
  return std::bit_cast<float>(rounded | (bits & 0x80000000u));
}

// NaN, which only sums of values near the largest float give, becomes air.
HWY_INLINE float Limited(float v, float limit) {
  return v > limit ? limit : v < -limit ? -limit : v == v ? v : 0.0f;
}

// Value -> stored code (as a float) and stored value relative to air; over: the type cannot hold it.
template<Kind kind>
HWY_INLINE void Round(const Relevance::Rounding& r, float v, float& code, float& value, uint32_t& over) {
  if constexpr (kind == Kind::none) {
    code = value = Limited(v, FLT_MAX);
    over = !(std::fabs(v) <= FLT_MAX);
  } else if constexpr (kind == Kind::half_relative || kind == Kind::half) {
    const float half = NearestHalf(Limited(kind == Kind::half ? v + r.air : v, FLT_MAX));
    over = std::fabs(half) > 65504.0f;
    code = Limited(half, 65504.0f);
    value = kind == Kind::half ? code - r.air : code;
  } else if constexpr (kind == Kind::integer) {
    const auto shift = static_cast<float>(r.shift);
    const float c = Nearest(Limited(v, 0x1p21f)) + shift; // exact
    over = c < 0 || c > r.largest;
    code = c < 0 ? 0 : c > r.largest ? r.largest : c;
    value = code - shift;
  } else {
    const double c = Nearest((Limited(v, FLT_MAX) + r.shift) / r.scale);
    const double largest = r.largest;
    over = c < 0 || c > largest;
    const double inside = c < 0 ? 0 : c > largest ? largest : c;
    code = static_cast<float>(inside);
    value = static_cast<float>(inside * r.scale - r.shift);
  }
}

template<Kind kind>
HWY_NOINLINE void RoundRows(const Relevance::Rounding& rounding, float ringing, const float* HWY_RESTRICT in,
                            size_t rows, float* HWY_RESTRICT out, RoundedRow* HWY_RESTRICT bits) {
  const Relevance::Rounding r = rounding;
  const bool by_code = r.threshold == 0;
  for (size_t row = 0; row < rows; ++row) {
    uint32_t kept[16], over[16], loud[16];
    for (size_t i = 0; i < 16; ++i) {
      float code, value;
      Round<kind>(r, in[row * 16 + i], code, value, over[i]);
      const bool keep = by_code ? code != r.air_code : std::fabs(value) > r.threshold;
      kept[i] = keep;
      loud[i] = std::fabs(value) > ringing;
      out[row * 16 + i] = value;
    }
    uint32_t kept_bits = 0, over_bits = 0, loud_bits = 0;
    for (uint32_t i = 0; i < 16; ++i) {
      kept_bits |= kept[i] << i;
      over_bits |= over[i] << i;
      loud_bits |= loud[i] << i;
    }
    bits[row] = {static_cast<uint16_t>(kept_bits), static_cast<uint16_t>(over_bits),
                 static_cast<uint16_t>(loud_bits)};
  }
}

void RoundSites(const Relevance::Rounding& rounding, float ringing, const float* in, size_t rows, float* out,
                RoundedRow* bits) {
  switch (rounding.kind) {
  case Kind::none:
    return RoundRows<Kind::none>(rounding, ringing, in, rows, out, bits);
  case Kind::half_relative:
    return RoundRows<Kind::half_relative>(rounding, ringing, in, rows, out, bits);
  case Kind::half:
    return RoundRows<Kind::half>(rounding, ringing, in, rows, out, bits);
  case Kind::integer:
    return RoundRows<Kind::integer>(rounding, ringing, in, rows, out, bits);
  case Kind::scaled:
    return RoundRows<Kind::scaled>(rounding, ringing, in, rows, out, bits);
  }
}

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {
HWY_EXPORT(RoundSites);

Relevance::Relevance(const Quantiser& q, float threshold) {
  if (!(threshold >= 0)) fail(Code::invalid_argument, "the air threshold must be 0 or positive");
  rounding_.scale = q.scale;
  rounding_.shift = q.air - q.offset;
  rounding_.air = q.air;
  rounding_.threshold = threshold;
  rounding_.largest = static_cast<float>(largest_code(q.type));
  if (q.type == ValueType::f32) return;
  if (q.type == ValueType::f16) {
    rounding_.kind = q.offset == q.air ? Rounding::Kind::half_relative : Rounding::Kind::half;
    if (rounding_.kind == Rounding::Kind::half) rounding_.air_code = half_to_float(float_to_half(q.air));
    return;
  }
  const bool whole = q.scale == 1 && rounding_.shift == std::nearbyint(rounding_.shift) &&
                     std::fabs(rounding_.shift) < 0x1p20;
  rounding_.kind = whole ? Rounding::Kind::integer : Rounding::Kind::scaled;
  const double code = std::nearbyint(rounding_.shift / q.scale);
  rounding_.air_code = static_cast<float>(std::fmin(std::fmax(code, 0), largest_code(q.type)));
}

KeptCounts Relevance::select(const float* values, const Int3& size, const SiteEvidence& evidence,
                             Brick& brick) const {
  KeptCounts counts;
  const auto columns = static_cast<uint16_t>((1u << size[0]) - 1);
  const auto row_of = [&](const BrickMask* mask, size_t row, uint16_t otherwise) {
    return mask ? (*mask)[row] : otherwise;
  };
  brick.kept = {};
  brick.hole.reset();
  const auto clear = [&](int from, int to) {
    std::fill(brick.value.begin() + from, brick.value.begin() + to, 0.0f);
  };
  clear(size[2] * brick_rows, brick_sites); // planes beyond the last
  for (int z = 0; z < size[2]; ++z) {
    const size_t first = z * brick_edge, rows = size[1];
    clear((z * brick_edge + size[1]) * brick_edge, (z + 1) * brick_rows);
    RoundedRow bits[brick_edge];
    HWY_DYNAMIC_DISPATCH(RoundSites)
    (rounding_, evidence.ringing, values + first * brick_edge, rows, brick.value.data() + first * brick_edge,
     bits);
    for (size_t y = 0; y < rows; ++y) {
      const auto hole = static_cast<uint16_t>(row_of(evidence.holes, first + y, 0) & columns);
      const auto substance = static_cast<uint16_t>(row_of(evidence.source, first + y, 0xffff) |
                                                   (bits[y].loud & row_of(evidence.near, first + y, 0xffff)));
      const auto kept = static_cast<uint16_t>((bits[y].relevant & substance & columns) | hole);
      brick.kept[first + y] = kept;
      float* row = brick.value.data() + (first + y) * brick_edge;
      for (size_t x = 0; kept != 0xffff && x < brick_edge; ++x)
        if (!(kept >> x & 1)) row[x] = 0;
      counts.kept += kept == 0xffff ? 16 : static_cast<uint64_t>(std::popcount(kept));
      if (const auto clamped = static_cast<uint16_t>(bits[y].clamped & columns))
        counts.clamped += std::popcount(clamped);
      if (!hole) continue;
      if (!brick.hole) brick.hole = std::make_unique<BrickMask>();
      (*brick.hole)[first + y] = hole;
      counts.holes += std::popcount(hole);
    }
  }
  return counts;
}

} // namespace bccsplat
#endif

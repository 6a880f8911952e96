// SPDX-License-Identifier: Apache-2.0
// Turns packed codes into the values of a brick, a vector at a time where the kept sites of a row are one
// run.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "formats/bcc4/coding/spread.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cstring>

#include "formats/bcc4/coding/spread.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace {

// Returns the values of as many codes of integers as a vector of doubles has lanes, by the operations of
// SampleCoder::decode, each rounded.
template<class Stored> struct Values {
  double scale, bias; // value = code * scale + bias

  template<class D> HWY_INLINE hn::Vec<D> operator()(D d, const Stored* from) const {
    const hn::Rebind<double, D> wide;
    const auto code = hn::PromoteTo(hn::Rebind<int32_t, D>(), hn::LoadU(hn::Rebind<Stored, D>(), from));
    const auto scaled = hn::Mul(hn::PromoteTo(wide, code), hn::Set(wide, scale));
    return hn::DemoteTo(d, hn::Add(scaled, hn::Set(wide, bias)));
  }
};

// The same of floats, as they are stored: undoes the order of their codes.
struct StoredFloats {
  template<class D> HWY_INLINE hn::Vec<D> operator()(D d, const uint32_t* from) const {
    const hn::RebindToUnsigned<D> du;
    const auto code = hn::LoadU(du, from), sign = hn::Set(du, uint32_t{1} << 31);
    const auto negative = hn::Eq(hn::And(code, sign), hn::Zero(du));
    return hn::BitCast(d, hn::IfThenElse(negative, hn::Not(code), hn::Xor(code, sign)));
  }
};

// Floats that are stored relative to another value.
struct MovedFloats {
  double bias; // value = stored + bias

  template<class D> HWY_INLINE hn::Vec<D> operator()(D d, const uint32_t* from) const {
    const hn::Rebind<double, D> wide;
    return hn::DemoteTo(d, hn::Add(hn::PromoteTo(wide, StoredFloats()(d, from)), hn::Set(wide, bias)));
  }
};

// The same in single precision, where that is exact.
template<class Stored> struct SingleValues {
  float scale, bias;

  template<class D> HWY_INLINE hn::Vec<D> operator()(D d, const Stored* from) const {
    const auto code = hn::PromoteTo(hn::RebindToSigned<D>(), hn::LoadU(hn::Rebind<Stored, D>(), from));
    return hn::Add(hn::Mul(hn::ConvertTo(d, code), hn::Set(d, scale)), hn::Set(d, bias));
  }
};

alignas(64) constexpr int32_t site_bit[2 * brick_edge] = {
    1,   2,   4,    8,    16,   32,   64,    128,
    256, 512, 1024, 2048, 4096, 8192, 16384, 32768}; // those behind a row have none

// values(d, from): those of as many codes as `d` has lanes.
template<class Stored, class MakeValues>
void Spread(const MakeValues& values, const SampleCoder& coder, const BrickMask& kept,
            std::span<const std::byte> codes, size_t first, float* brick) {
  constexpr size_t bytes = sizeof(Stored);
  const hn::Rebind<float, hn::CappedTag<double, brick_edge>> d;
  const hn::RebindToSigned<decltype(d)> di;
  const size_t count = codes.size() / bytes;
  size_t next = first;
  for (const unsigned row : kept) {
    const size_t before = std::countr_zero(row) & 15;
    const unsigned run = row >> before;
    if (row == 0) {
      std::fill_n(brick, brick_edge, 0.0f);
    } else if ((run & (run + 1)) == 0 && next >= before && next - before + brick_edge <= count) {
      // The row is one run: sixteen values are made and those beside it are cleared.
      const auto* from = reinterpret_cast<const Stored*>(codes.data()) + next - before;
      for (size_t x = 0; x < brick_edge; x += hn::Lanes(d)) {
        const auto here = hn::TestBit(hn::Set(di, static_cast<int32_t>(row)), hn::Load(di, site_bit + x));
        hn::StoreU(hn::IfThenElseZero(hn::RebindMask(d, here), values(d, from + x)), d, brick + x);
      }
      next += std::bit_width(run);
    } else {
      std::fill_n(brick, brick_edge, 0.0f);
      for (unsigned bits = row; bits; bits &= bits - 1) {
        Stored code;
        std::memcpy(&code, codes.data() + next++ * bytes, bytes);
        brick[std::countr_zero(bits)] = coder.decode(code);
      }
    }
    brick += brick_edge;
  }
}

// Makes all that is wanted of rows that are one run, and clears what is not kept.
template<class Stored, class D, class MakeValues>
void SpreadPart(D d, const MakeValues& values, const SampleCoder& coder, const BrickCodes& brick,
                const PlanePart& part, float* to, std::ptrdiff_t stride) {
  const hn::RebindToSigned<D> di;
  const size_t width = part.width, first = part.x;
  const unsigned wanted = (1u << width) - 1;
  const auto* codes = reinterpret_cast<const Stored*>(brick.codes);
  size_t row = part.plane * brick_edge + part.y;
  for (const size_t end = row + part.height; row < end; ++row, to += stride) {
    const unsigned kept = brick.kept ? (*brick.kept)[row] : 0xffff;
    const size_t before = std::countr_zero(kept) & 15;
    const unsigned run = kept >> before, here = kept >> first & wanted;
    const Stored* next = codes + (brick.first ? (*brick.first)[row] : row * brick_edge);
    const Stored* from = next + first - before;
    if (here == 0) {
      std::fill_n(to, width, 0.0f);
    } else if ((run & (run + 1)) == 0 && here == wanted) {
      for (size_t x = 0; x < width; x += hn::Lanes(d)) hn::StoreU(values(d, from + x), d, to + x);
    } else if ((run & (run + 1)) == 0) {
      for (size_t x = 0; x < width; x += hn::Lanes(d)) {
        const auto is_kept = hn::TestBit(hn::Set(di, static_cast<int32_t>(here)), hn::Load(di, site_bit + x));
        hn::StoreU(hn::IfThenElseZero(hn::RebindMask(d, is_kept), values(d, from + x)), d, to + x);
      }
    } else {
      std::fill_n(to, width, 0.0f);
      next += std::popcount(kept & ((1u << first) - 1));
      for (unsigned bits = here; bits; bits &= bits - 1) to[std::countr_zero(bits)] = coder.decode(*next++);
    }
  }
}

template<class Stored>
void SpreadPart(const SampleCoder& coder, const BrickCodes& brick, const PlanePart& part, float* to,
                std::ptrdiff_t stride) {
  if (coder.is_single()) {
    const SingleValues<Stored> values{static_cast<float>(coder.scale()), static_cast<float>(coder.bias())};
    SpreadPart<Stored>(hn::CappedTag<float, brick_edge>(), values, coder, brick, part, to, stride);
  } else {
    SpreadPart<Stored>(hn::Rebind<float, hn::CappedTag<double, brick_edge>>(),
                       Values<Stored>{coder.scale(), coder.bias()}, coder, brick, part, to, stride);
  }
}

void SpreadPart8(const SampleCoder& coder, const BrickCodes& brick, const PlanePart& part, float* to,
                 std::ptrdiff_t stride) {
  SpreadPart<uint8_t>(coder, brick, part, to, stride);
}
void SpreadPart16(const SampleCoder& coder, const BrickCodes& brick, const PlanePart& part, float* to,
                  std::ptrdiff_t stride) {
  SpreadPart<uint16_t>(coder, brick, part, to, stride);
}

void Spread8(const SampleCoder& c, const BrickMask& k, std::span<const std::byte> codes, size_t first,
             float* brick) {
  Spread<uint8_t>(Values<uint8_t>{c.scale(), c.bias()}, c, k, codes, first, brick);
}
void Spread16(const SampleCoder& c, const BrickMask& k, std::span<const std::byte> codes, size_t first,
              float* brick) {
  Spread<uint16_t>(Values<uint16_t>{c.scale(), c.bias()}, c, k, codes, first, brick);
}
void Spread32(const SampleCoder& c, const BrickMask& k, std::span<const std::byte> codes, size_t first,
              float* brick) {
  if (c.bias() == 0)
    Spread<uint32_t>(StoredFloats(), c, k, codes, first, brick);
  else
    Spread<uint32_t>(MovedFloats{c.bias()}, c, k, codes, first, brick);
}

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {

HWY_EXPORT(Spread8);
HWY_EXPORT(Spread16);
HWY_EXPORT(Spread32);
HWY_EXPORT(SpreadPart8);
HWY_EXPORT(SpreadPart16);

namespace {

// Spreads halves, which vectors do not turn into values.
void spread_halves(const SampleCoder& coder, const BrickMask& kept, std::span<const std::byte> codes,
                   size_t first, float* brick) {
  for (const unsigned row : kept) {
    std::fill_n(brick, brick_edge, 0.0f);
    for (unsigned bits = row; bits; bits &= bits - 1) {
      uint16_t code;
      std::memcpy(&code, codes.data() + first++ * sizeof code, sizeof code);
      brick[std::countr_zero(bits)] = coder.decode(code);
    }
    brick += brick_edge;
  }
}

} // namespace

void spread_codes(const SampleCoder& coder, const BrickMask& kept, std::span<const std::byte> codes,
                  size_t first, std::span<float, brick_sites> brick) {
  switch (coder.codes().type) {
  case ValueType::u8:
    return HWY_DYNAMIC_DISPATCH(Spread8)(coder, kept, codes, first, brick.data());
  case ValueType::u16:
    return HWY_DYNAMIC_DISPATCH(Spread16)(coder, kept, codes, first, brick.data());
  case ValueType::f16:
    return spread_halves(coder, kept, codes, first, brick.data());
  case ValueType::f32:
    return HWY_DYNAMIC_DISPATCH(Spread32)(coder, kept, codes, first, brick.data());
  }
}

void spread_part(const SampleCoder& coder, const BrickCodes& brick, const PlanePart& part, float* to,
                 std::ptrdiff_t stride) {
  if (coder.codes().bytes() == 1)
    HWY_DYNAMIC_DISPATCH(SpreadPart8)(coder, brick, part, to, stride);
  else
    HWY_DYNAMIC_DISPATCH(SpreadPart16)(coder, brick, part, to, stride);
}

} // namespace bccsplat
#endif

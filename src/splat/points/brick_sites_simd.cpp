// SPDX-License-Identifier: Apache-2.0
// The loops of brick_sites.h through Highway, for BCC: one body is compiled for every target, and the best is
// chosen at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/points/brick_sites_simd.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cstring>

#include "splat/points/brick_sites.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR
void Summarise(const BrickSites& sites, SplatBrick& brick, BrickCells& cells) {
  summarise_reference(sites, true, brick, cells);
}
void CodeCells(const BrickSites& sites, const SplatPoints& points, uint8_t* codes) {
  code_cells_reference(sites, true, points, codes);
}
void ListPoints(const BrickSites& sites, const SiteOrder& order, uint32_t count, uint16_t* position,
                float* coefficient) {
  list_points_reference(sites, order, count, position, coefficient);
}
#else

namespace hn = hwy::HWY_NAMESPACE;

constexpr size_t coset_sites = BrickSites::count / 2, plane_sites = 64, row_sites = 8;

// Which sites hold a point: a word per plane z of a coset, a byte per row y.
void PointBits(const BrickSites& sites, uint64_t (&word)[16]) {
  const hn::CappedTag<float, 16> d;
  for (size_t n = 0; n < 16; ++n) {
    word[n] = 0;
    for (size_t i = 0; i < plane_sites; i += hn::Lanes(d)) {
      uint8_t bits[8] = {}; // what StoreMaskBits may write
      hn::StoreMaskBits(d, hn::Ne(hn::Load(d, sites.coefficient.data() + n * plane_sites + i), hn::Zero(d)),
                        bits);
      uint64_t some;
      std::memcpy(&some, bits, sizeof some);
      word[n] |= some << i;
    }
  }
}

void Extent(const uint64_t (&word)[16], SplatBrick& brick) {
  brick.count = 0, brick.low.fill(255), brick.high.fill(0);
  for (size_t coset = 0; coset < 2; ++coset) {
    std::array<unsigned, 3> used{}; // sites along each axis, as bits
    for (size_t z = 0; z < row_sites; ++z) {
      const uint64_t bits = word[coset * row_sites + z];
      if (bits == 0) continue;
      brick.count += std::popcount(bits);
      used[2] |= 1u << z;
      for (size_t y = 0; y < row_sites; ++y) {
        const auto row = static_cast<unsigned>(bits >> (row_sites * y) & 255);
        used[0] |= row, used[1] |= row != 0 ? 1u << y : 0;
      }
    }
    for (size_t a = 0; a < 3 && used[a] != 0; ++a) {
      brick.low[a] = std::min(
          brick.low[a], static_cast<uint8_t>(2 * static_cast<size_t>(std::countr_zero(used[a])) + coset));
      brick.high[a] =
          std::max(brick.high[a],
                   static_cast<uint8_t>(2 * (static_cast<size_t>(std::bit_width(used[a])) - 1) + coset));
    }
  }
}

void Summarise(const BrickSites& sites, SplatBrick& brick, BrickCells& cells) {
  uint64_t word[16];
  PointBits(sites, word);
  Extent(word, brick);
  // A cell of 4^3 planes holds two sites per axis of each coset.
  const hn::CappedTag<float, 16> d;
  float lowest = 0, highest = 0;
  for (size_t z = 0; z < 4; ++z)
    for (size_t y = 0; y < 4; ++y) {
      alignas(64) float low[2 * row_sites], high[2 * row_sites]; // two rows, over planes and cosets
      for (size_t i = 0; i < 2 * row_sites; i += hn::Lanes(d)) {
        const float* const from = sites.coefficient.data() + 2 * z * plane_sites + 2 * y * row_sites + i;
        const auto a = hn::Load(d, from), b = hn::Load(d, from + plane_sites),
                   e = hn::Load(d, from + coset_sites), f = hn::Load(d, from + coset_sites + plane_sites);
        hn::Store(hn::Min(hn::Min(a, b), hn::Min(e, f)), d, low + i);
        hn::Store(hn::Max(hn::Max(a, b), hn::Max(e, f)), d, high + i);
      }
      for (size_t x = 0; x < 4; ++x) {
        const size_t to = x | y << 2 | z << 4, i = 2 * x, j = 2 * x + row_sites;
        cells.low[to] = std::min(std::min(low[i], low[i + 1]), std::min(low[j], low[j + 1]));
        cells.high[to] = std::max(std::max(high[i], high[i + 1]), std::max(high[j], high[j + 1]));
        lowest = std::min(lowest, cells.low[to]), highest = std::max(highest, cells.high[to]);
      }
    }
  brick.coefficient[0] = lowest, brick.coefficient[1] = highest;
}

// A fine cell holds one site of each coset.
void CodeCells(const BrickSites& sites, const SplatPoints& points, uint8_t* codes) {
  const hn::CappedTag<float, 16> d;
  const hn::RebindToSigned<decltype(d)> di;
  const hn::Rebind<uint8_t, decltype(d)> d8;
  const auto unit = hn::Set(d, points.code_unit);
  const auto zero = hn::Set(di, static_cast<int32_t>(SplatPoints::code_zero)),
             most = hn::Set(di, SplatPoints::most_code);
  for (size_t i = 0; i < coset_sites; i += hn::Lanes(d)) {
    const auto a = hn::Abs(hn::Load(d, sites.coefficient.data() + i)),
               b = hn::Abs(hn::Load(d, sites.coefficient.data() + coset_sites + i));
    const auto steps = hn::ShiftRight<SplatPoints::code_shift>(hn::BitCast(di, hn::Mul(hn::Max(a, b), unit)));
    // Negative ones become 0.
    hn::StoreU(hn::DemoteTo(d8, hn::Min(hn::Sub(steps, zero), most)), d8, codes + i);
  }
}

void ListPoints(const BrickSites& sites, const SiteOrder& order, uint32_t count, uint16_t* position,
                float* coefficient) {
  const hn::CappedTag<float, 16> d;
  const hn::RebindToSigned<decltype(d)> di;
  const hn::Rebind<uint16_t, decltype(d)> d16;
  const auto site = [&](size_t n) {
    return hn::GatherIndex(d, sites.coefficient.data(), hn::LoadU(di, order.site.data() + n));
  };
  const size_t lanes = hn::Lanes(d);
  if (count == BrickSites::count) {
    std::memcpy(position, order.position.data(), BrickSites::count * sizeof(uint16_t));
    for (size_t n = 0; n < BrickSites::count; n += lanes) hn::StoreU(site(n), d, coefficient + n);
    return;
  }
  // Whole vectors are written, so they go into room of their own first.
  alignas(64) std::array<uint16_t, BrickSites::count + 16> positions;
  alignas(64) std::array<float, BrickSites::count + 16> coefficients;
  size_t taken = 0;
  for (size_t n = 0; n < BrickSites::count; n += lanes) {
    const auto c = site(n);
    const auto is_point = hn::Ne(c, hn::Zero(d));
    const auto at = hn::PromoteTo(di, hn::LoadU(d16, order.position.data() + n));
    hn::StoreU(hn::DemoteTo(d16, hn::Compress(at, hn::RebindMask(di, is_point))), d16,
               positions.data() + taken);
    hn::StoreU(hn::Compress(c, is_point), d, coefficients.data() + taken);
    taken += hn::CountTrue(d, is_point);
  }
  std::memcpy(position, positions.data(), count * sizeof(uint16_t));
  std::memcpy(coefficient, coefficients.data(), count * sizeof(float));
}

#endif

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {
HWY_EXPORT(Summarise);
HWY_EXPORT(CodeCells);
HWY_EXPORT(ListPoints);

void summarise(const BrickSites& sites, bool bcc, SplatBrick& brick, BrickCells& cells) {
  if (!bcc) return summarise_reference(sites, bcc, brick, cells);
  HWY_DYNAMIC_DISPATCH(Summarise)(sites, brick, cells);
}

void code_cells(const BrickSites& sites, bool bcc, const SplatPoints& points, uint8_t* codes) {
  if (!bcc) return code_cells_reference(sites, bcc, points, codes);
  HWY_DYNAMIC_DISPATCH(CodeCells)(sites, points, codes);
}

void list_points(const BrickSites& sites, const SiteOrder& order, uint32_t count, uint16_t* position,
                 float* coefficient) {
  if (!order.bcc) return list_points_reference(sites, order, count, position, coefficient);
  HWY_DYNAMIC_DISPATCH(ListPoints)(sites, order, count, position, coefficient);
}

} // namespace bccsplat
#endif

// SPDX-License-Identifier: Apache-2.0
// The loops of ray_lanes.h through Highway: one body is compiled for every target, and the best is chosen at
// run time. Words of blocks have 64 bits, so that lanes of rays are of doubles.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "rays/ray_lanes_simd.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <utility>

#include "rays/ray_lanes.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using Doubles = hn::CappedTag<double, piece_edge>;
using Words = hn::RebindToUnsigned<Doubles>;
using Indices = hn::RebindToSigned<Doubles>;
using D = hn::Vec<Doubles>;
using W = hn::Vec<Words>;
constexpr Doubles d;
constexpr Words dw;
constexpr Indices di;
constexpr size_t rays = hn::MaxLanes(d);
alignas(64) constexpr std::array<double, piece_edge> lane_numbers{0, 1, 2, 3, 4, 5, 6, 7};

// Bits of lanes, the first lowest.
template<class Tag, class Mask> HWY_INLINE uint64_t BitsOf(Tag tag, Mask mask) {
  std::array<uint8_t, 8> bytes{};
  (void)hn::StoreMaskBits(tag, mask, bytes.data());
  uint64_t bits;
  std::memcpy(&bits, bytes.data(), sizeof bits);
  return bits & ((uint64_t{1} << hn::MaxLanes(tag)) - 1);
}

uint64_t FindRays(const PieceArgs& args, PieceRays& out) {
  constexpr double infinity = std::numeric_limits<double>::infinity(), margin = 1e-6; // blocks
  const D zero = hn::Zero(d), none = hn::Set(d, -infinity);
  const double per_block = 1 / (args.plane * block_edge);
  const size_t u = args.axes[0], v = args.axes[1], w = args.axes[2];
  uint64_t meet = 0;
  for (size_t n = 0; n < piece_rays; n += rays) {
    const D i = hn::Load(d, lane_numbers.data() + n % piece_edge);
    const auto j = static_cast<double>(n / piece_edge);
    D at[3], ray[3];
    D enter = hn::Set(d, args.front), leave = hn::Set(d, infinity);
    for (size_t a = 0; a < 3; ++a) {
      at[a] = hn::MulAdd(i, hn::Set(d, args.at_i[a]), hn::Set(d, args.at[a] + j * args.at_j[a]));
      ray[a] = hn::MulAdd(i, hn::Set(d, args.ray_i[a]), hn::Set(d, args.ray[a] + j * args.ray_j[a]));
      const D before = hn::Sub(hn::Set(d, args.begin[a]), at[a]),
              behind = hn::Sub(hn::Set(d, args.end[a]), at[a]);
      const auto along = hn::Ne(ray[a], zero), outside = hn::Or(hn::Gt(before, zero), hn::Lt(behind, zero));
      const D per_unit = hn::Div(hn::Set(d, 1.0), ray[a]);
      const D k0 = hn::Mul(before, per_unit), k1 = hn::Mul(behind, per_unit);
      enter = hn::IfThenElse(along, hn::Max(enter, hn::Min(k0, k1)), enter);
      leave = hn::IfThenElse(along, hn::Min(leave, hn::Max(k0, k1)), hn::IfThenElse(outside, none, leave));
    }
    hn::Store(enter, d, out.enter.data() + n), hn::Store(leave, d, out.leave.data() + n);
    meet |= BitsOf(d, hn::Lt(enter, leave)) << n;
    const D per_unit = hn::Div(hn::Set(d, 1.0), ray[w]);
    hn::Store(hn::Neg(hn::Mul(at[w], per_unit)), d, out.first.data() + n);
    hn::Store(hn::Mul(hn::Set(d, args.plane), per_unit), d, out.per_plane.data() + n);
    const auto across = [&](size_t a, PieceRays::Across& to) HWY_ATTR {
      const D slope = hn::Mul(ray[a], per_unit);
      const D low = hn::Mul(hn::NegMulAdd(slope, at[w], at[a]), hn::Set(d, per_block));
      hn::Store(slope, d, to.slope.data() + n);
      hn::Store(hn::Sub(hn::Add(low, hn::Min(slope, zero)), hn::Set(d, margin)), d, to.low.data() + n);
    };
    across(u, out.u), across(v, out.v);
  }
  return meet;
}

// Whole numbers of 0 <= x < 2^51.
HWY_INLINE hn::Vec<Indices> IndexOf(D x) {
  constexpr double lift = 4503599627370496; // 2^52
  const W bits = hn::BitCast(dw, hn::Add(x, hn::Set(d, lift)));
  return hn::BitCast(di, hn::And(bits, hn::Set(dw, (uint64_t{1} << 52) - 1)));
}

// Along one axis: the words' offset of the block that rays are in at their smallest coordinate, and of it and
// the next ones the cells that they may pass; none of a block that is not there.
template<int across> struct Passed {
  D offset;
  W cells[across];
};
template<int across>
HWY_INLINE Passed<across> PassAxis(const SlabArgs& args, const SlabArgs::Axis& axis,
                                   const PieceRays::Across& rays_across, size_t n) {
  const D at = hn::MulAdd(hn::Load(d, rays_across.slope.data() + n), hn::Set(d, 1.0 * args.place),
                          hn::Load(d, rays_across.low.data() + n));
  // Beyond the ends nothing is passed, wherever that is.
  const D x = hn::Min(hn::Max(at, hn::Set(d, 1.0 * (axis.begin - across))), hn::Set(d, axis.end + 1.0));
  const D block = hn::Floor(x);
  constexpr auto places = static_cast<double>(PassMasks::places);
  const D within = hn::Mul(hn::Sub(x, block), hn::Set(d, places));
  const auto place = IndexOf(hn::Min(hn::Floor(within), hn::Set(d, places - 1)));
  Passed<across> p;
  p.offset = hn::Mul(block, hn::Set(d, static_cast<double>(axis.stride)));
  for (int b = 0; b < across; ++b) {
    p.cells[b] = hn::Zero(dw);
    if (b >= axis.masks->across) continue;
    const auto there = hn::RebindMask(dw, hn::And(hn::Ge(block, hn::Set(d, 1.0 * (axis.begin - b))),
                                                  hn::Lt(block, hn::Set(d, 1.0 * (axis.end - b)))));
    const uint64_t* const masks = axis.masks->words.data() + (axis.masks->across - 1 - b) * PassMasks::places;
    p.cells[b] = hn::IfThenElseZero(there, hn::GatherIndex(dw, masks, place));
  }
  return p;
}

template<int across>
uint64_t FindLayersOf(const SlabArgs& args, const PieceRays& piece, std::span<uint64_t, piece_rays> layers) {
  const W none = hn::Zero(dw);
  // Rays that pass no cell of a block read another one that is looked at.
  const D first =
      hn::Set(d, static_cast<double>(args.u.begin * args.u.stride + args.v.begin * args.v.stride));
  uint64_t any = 0;
  for (size_t n = 0; n < piece_rays; n += rays) {
    const Passed<across> u = PassAxis<across>(args, args.u, piece.u, n),
                         v = PassAxis<across>(args, args.v, piece.v, n);
    W found = none;
    const auto add = [&](D offset, W cells) HWY_ATTR {
      const auto some = hn::Ne(cells, none);
      if (hn::AllFalse(dw, some)) return;
      const D at = hn::IfThenElse(hn::RebindMask(d, some), offset, first);
      found = hn::Or(found, hn::And(cells, hn::GatherIndex(dw, args.bits, IndexOf(at))));
    };
    const D here = hn::Add(u.offset, v.offset);
    for (int b = 0; b < across; ++b)
      for (int c = 0; c < across; ++c) {
        const auto words = static_cast<double>(b * args.v.stride + c * args.u.stride);
        add(hn::Add(here, hn::Set(d, words)), hn::And(u.cells[c], v.cells[b]));
      }
    const auto some = hn::Ne(found, none);
    if (hn::AllFalse(dw, some)) continue;
    any |= BitsOf(dw, some) << n;
    W passed = none;
    for (size_t l = 0; l < block_edge; ++l) {
      const auto in_layer = hn::Ne(hn::And(found, hn::Set(dw, args.layer[l])), none);
      passed = hn::Or(passed, hn::IfThenElseZero(in_layer, hn::Set(dw, uint64_t{1} << l)));
    }
    hn::StoreU(passed, dw, layers.data() + n);
  }
  return any;
}

uint64_t FindLayers(const SlabArgs& args, const PieceRays& piece, std::span<uint64_t, piece_rays> layers) {
  return std::max(args.u.masks->across, args.v.masks->across) > 2
             ? FindLayersOf<PassMasks::most_across>(args, piece, layers)
             : FindLayersOf<2>(args, piece, layers);
}

void FindPairs(const PairArgs& args) {
  const hn::CappedTag<float, PairArgs::room> df;
  using F = hn::Vec<decltype(df)>;
  constexpr size_t lanes = hn::MaxLanes(df);
  for (size_t n = 0; n < args.count; n += lanes) {
    F gx, gy, gz, x, y, z, rest;
    hn::LoadInterleaved4(df, args.gradient[n].data(), gx, gy, gz, rest);
    hn::LoadInterleaved4(df, args.ray[n].data(), x, y, z, rest);
    hn::StoreU(hn::MulAdd(gx, x, hn::MulAdd(gy, y, hn::Mul(gz, z))), df, args.slope + n);
  }
  const F target = hn::Set(df, args.target), zero = hn::Zero(df);
  uint64_t word = 0;
  for (size_t n = 0; n < args.count; n += lanes) {
    const F v0 = hn::LoadU(df, args.value + n), v1 = hn::LoadU(df, args.value + n + 1);
    const F d0 = hn::Sub(v0, target), d1 = hn::Sub(v1, target);
    const auto below = hn::Lt(v0, target);
    const auto crosses = hn::Xor(below, hn::Lt(v1, target));
    const F side = hn::IfThenElse(below, hn::Set(df, 1.0f), hn::Set(df, -1.0f));
    const F s0 = hn::Mul(side, hn::LoadU(df, args.slope + n)),
            s1 = hn::Mul(side, hn::LoadU(df, args.slope + n + 1));
    const F meet = hn::Add(hn::Mul(hn::Mul(side, d0), hn::Sub(s0, s1)),
                           hn::Mul(s0, hn::Sub(hn::Mul(side, hn::Sub(d1, d0)), s1)));
    const auto grazes = hn::And(hn::And(hn::Gt(s0, zero), hn::Lt(s1, zero)), hn::Gt(meet, zero));
    word |= BitsOf(df, hn::Or(crosses, grazes)) << n % 64;
    if ((n + lanes) % 64 == 0 || n + lanes >= args.count) args.found[n / 64] = std::exchange(word, 0);
  }
}

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {
HWY_EXPORT(FindRays);
HWY_EXPORT(FindLayers);
HWY_EXPORT(FindPairs);

uint64_t find_rays(const PieceArgs& args, PieceRays& rays) {
  return HWY_DYNAMIC_DISPATCH(FindRays)(args, rays);
}
uint64_t find_layers(const SlabArgs& args, const PieceRays& rays, std::span<uint64_t, piece_rays> layers) {
  return HWY_DYNAMIC_DISPATCH(FindLayers)(args, rays, layers);
}
void find_pairs(const PairArgs& args) { HWY_DYNAMIC_DISPATCH(FindPairs)(args); }

} // namespace bccsplat
#endif

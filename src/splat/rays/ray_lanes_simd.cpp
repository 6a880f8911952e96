// SPDX-License-Identifier: Apache-2.0
// The loops of ray_lanes.h through Highway: one body is compiled for every target, and the best is chosen at
// run time. Words of blocks have 64 bits, so that lanes of rays are of doubles.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/rays/ray_lanes_simd.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <utility>

#include "splat/rays/ray_lanes.h"

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

uint64_t FindIntervals(const IntervalArgs& args, PieceIntervals& out) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  uint64_t meet = 0;
  for (size_t n = 0; n < piece_rays; n += rays) {
    const D i = hn::Load(d, lane_numbers.data() + n % piece_edge);
    const auto j = static_cast<double>(n / piece_edge);
    D enter = hn::Set(d, -infinity), leave = hn::Set(d, infinity);
    for (size_t a = 0; a < 3; ++a) {
      const D at = hn::MulAdd(i, hn::Set(d, args.ex[a]), hn::Set(d, args.at[a] + j * args.ey[a]));
      const D before = hn::Sub(hn::Set(d, args.begin[a]), at), behind = hn::Sub(hn::Set(d, args.end[a]), at);
      if (args.ez[a] == 0) {
        const auto outside = hn::Or(hn::Gt(before, hn::Zero(d)), hn::Lt(behind, hn::Zero(d)));
        leave = hn::IfThenElse(outside, hn::Set(d, -infinity), leave);
        continue;
      }
      const D per_unit = hn::Set(d, 1 / args.ez[a]);
      const D k0 = hn::Mul(before, per_unit), k1 = hn::Mul(behind, per_unit);
      enter = hn::Max(enter, hn::Min(k0, k1)), leave = hn::Min(leave, hn::Max(k0, k1));
    }
    hn::Store(enter, d, out.enter.data() + n), hn::Store(leave, d, out.leave.data() + n);
    meet |= BitsOf(d, hn::Lt(enter, leave)) << n;
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
// the next one the cells that they may pass; none of a block that is not there.
struct Passed {
  D offset;
  W here, next;
};
HWY_INLINE Passed PassAxis(const SlabArgs::Axis& axis, D i, double j) {
  const D at = hn::MulAdd(i, hn::Set(d, axis.per_i), hn::Set(d, axis.first + j * axis.per_j));
  // Beyond the ends nothing is passed, wherever that is.
  const D x = hn::Min(hn::Max(at, hn::Set(d, -2.0)), hn::Set(d, axis.blocks + 1.0));
  const D block = hn::Floor(x);
  constexpr double places = block_edge * SlabArgs::parts;
  const D within = hn::Mul(hn::Sub(x, block), hn::Set(d, places));
  const auto place = IndexOf(hn::Min(hn::Floor(within), hn::Set(d, places - 1)));
  const uint64_t* const masks = axis.masks->data();
  const auto there = [&](D first, D last) HWY_ATTR {
    return hn::RebindMask(dw, hn::And(hn::Ge(block, first), hn::Le(block, last)));
  };
  const D last = hn::Set(d, axis.blocks - 1.0), one = hn::Set(d, 1.0);
  Passed p;
  p.offset = hn::Mul(block, hn::Set(d, static_cast<double>(axis.stride)));
  p.here = hn::IfThenElseZero(there(hn::Zero(d), last),
                              hn::GatherIndex(dw, masks + static_cast<size_t>(places), place));
  p.next = hn::IfThenElseZero(there(hn::Neg(one), hn::Sub(last, one)), hn::GatherIndex(dw, masks, place));
  return p;
}

uint64_t FindLayers(const SlabArgs& args, std::span<uint64_t, piece_rays> layers) {
  const W none = hn::Zero(dw);
  const D stride_u = hn::Set(d, static_cast<double>(args.u.stride)),
          stride_v = hn::Set(d, static_cast<double>(args.v.stride));
  uint64_t any = 0;
  for (size_t n = 0; n < piece_rays; n += rays) {
    const D i = hn::Load(d, lane_numbers.data() + n % piece_edge);
    const auto j = static_cast<double>(n / piece_edge);
    const Passed u = PassAxis(args.u, i, j), v = PassAxis(args.v, i, j);
    W found = none;
    const auto add = [&](D offset, W cells) HWY_ATTR {
      const auto some = hn::Ne(cells, none);
      if (hn::AllFalse(dw, some)) return;
      const D at = hn::IfThenElseZero(hn::RebindMask(d, some), offset);
      found = hn::Or(found, hn::And(cells, hn::GatherIndex(dw, args.bits, IndexOf(at))));
    };
    const D here = hn::Add(u.offset, v.offset);
    add(here, hn::And(u.here, v.here));
    add(hn::Add(here, stride_u), hn::And(u.next, v.here));
    add(hn::Add(here, stride_v), hn::And(u.here, v.next));
    add(hn::Add(here, hn::Add(stride_u, stride_v)), hn::And(u.next, v.next));
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

void FindPairs(const PairArgs& args) {
  const hn::CappedTag<float, PairArgs::room> df;
  using F = hn::Vec<decltype(df)>;
  constexpr size_t lanes = hn::MaxLanes(df);
  const F x = hn::Set(df, args.ray[0]), y = hn::Set(df, args.ray[1]), z = hn::Set(df, args.ray[2]);
  for (size_t n = 0; n < args.count; n += lanes) {
    F gx, gy, gz, rest;
    hn::LoadInterleaved4(df, args.gradient[n].data(), gx, gy, gz, rest);
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
HWY_EXPORT(FindIntervals);
HWY_EXPORT(FindLayers);
HWY_EXPORT(FindPairs);

uint64_t find_intervals(const IntervalArgs& args, PieceIntervals& intervals) {
  return HWY_DYNAMIC_DISPATCH(FindIntervals)(args, intervals);
}
uint64_t find_layers(const SlabArgs& args, std::span<uint64_t, piece_rays> layers) {
  return HWY_DYNAMIC_DISPATCH(FindLayers)(args, layers);
}
void find_pairs(const PairArgs& args) { HWY_DYNAMIC_DISPATCH(FindPairs)(args); }

} // namespace bccsplat
#endif

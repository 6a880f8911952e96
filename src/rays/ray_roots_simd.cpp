// SPDX-License-Identifier: Apache-2.0
// Cubics and quadratics of ray_roots.h through Highway: one body is compiled for every target, and the best
// is chosen at run time. Lengths are in sheets from the first sample of a pair, so that floats are enough.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "rays/ray_roots_simd.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <cstring>

#include "rays/ray_roots.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using Lanes = hn::CappedTag<float, 16>;
using F = hn::Vec<Lanes>;
using M = hn::Mask<Lanes>;
constexpr Lanes d;
constexpr size_t lanes = hn::MaxLanes(d);

HWY_INLINE F Of(float v) { return hn::Set(d, v); }

// Vectors of one end of brackets.
struct End {
  F x, value, slope;
};
HWY_INLINE End LoadEnd(const RootLanes::End& from, size_t n) {
  return {hn::Load(d, from.x.data() + n), hn::Load(d, from.value.data() + n),
          hn::Load(d, from.slope.data() + n)};
}
HWY_INLINE void StoreEnd(const End& end, RootLanes::End& to, size_t n) {
  hn::Store(end.x, d, to.x.data() + n), hn::Store(end.value, d, to.value.data() + n);
  hn::Store(end.slope, d, to.slope.data() + n);
}
HWY_INLINE End Choose(M first, const End& a, const End& b) {
  return {hn::IfThenElse(first, a.x, b.x), hn::IfThenElse(first, a.value, b.value),
          hn::IfThenElse(first, a.slope, b.slope)};
}

// Where the cubic through the ends' values and slopes is 0, and whether that was found: Newton's method from
// where the straight line is 0, within the ends.
struct Root {
  F x;
  M found;
};
HWY_INLINE Root SolveCubic(const End& low, const End& high) {
  const F width = hn::Sub(high.x, low.x), zero = hn::Zero(d), one = Of(1);
  const F s0 = hn::Mul(low.slope, width), s1 = hn::Mul(high.slope, width),
          rise = hn::Sub(high.value, low.value);
  const F square = hn::Sub(hn::NegMulAdd(Of(2), s0, hn::Mul(Of(3), rise)), s1),
          cube = hn::NegMulAdd(Of(2), rise, hn::Add(s0, s1));
  const F twice = hn::Add(square, square), thrice = hn::Mul(Of(3), cube);
  F t = hn::Neg(hn::Div(low.value, rise)), step = one;
  for (int n = 0; n < 3; ++n) {
    const F value = hn::MulAdd(t, hn::MulAdd(t, hn::MulAdd(t, cube, square), s0), low.value),
            slope = hn::MulAdd(t, hn::MulAdd(t, thrice, twice), s0);
    step = hn::Div(value, slope);
    const F next = hn::Sub(t, step);
    t = hn::IfThenElse(hn::And(hn::Gt(next, zero), hn::Lt(next, one)), next, t);
  }
  constexpr float settled = 1.0f / 256; // of the width
  const M found = hn::Lt(hn::Abs(step), Of(settled));
  return {hn::MulAdd(hn::IfThenElse(found, t, Of(0.5f)), width, low.x), found};
}

// Nearer to an end than this part of a bracket the field is not asked for: differences would be noise.
HWY_INLINE F KeepAway(F x, const End& low, const End& high) {
  const F least = hn::Mul(hn::Sub(high.x, low.x), Of(1.0f / 32));
  return hn::Min(hn::Max(x, hn::Add(low.x, least)), hn::Sub(high.x, least));
}

void GuessRoots(const RootArgs& args, RootLanes& to) {
  for (size_t n = 0; n < args.count; n += lanes) {
    const End low = LoadEnd(to.low, n), high = LoadEnd(to.high, n);
    hn::Store(KeepAway(SolveCubic(low, high).x, low, high), d, to.next.data() + n);
  }
}

void BracketRoots(const RootArgs& args, const float* values, const std::array<float, 4>* gradients,
                  RootLanes& to) {
  const F zero = hn::Zero(d), tolerance = Of(args.tolerance);
  uint64_t word = 0;
  for (size_t n = 0; n < args.count; n += lanes) {
    const End low = LoadEnd(to.low, n), high = LoadEnd(to.high, n);
    F gx, gy, gz, ray_x, ray_y, ray_z, rest;
    hn::LoadInterleaved4(d, gradients[n].data(), gx, gy, gz, rest);
    hn::LoadInterleaved4(d, args.ray[n].data(), ray_x, ray_y, ray_z, rest);
    const End middle{hn::Load(d, to.next.data() + n), hn::Sub(hn::LoadU(d, values + n), Of(args.target)),
                     hn::MulAdd(gx, ray_x, hn::MulAdd(gy, ray_y, hn::Mul(gz, ray_z)))};
    const M below = hn::Lt(low.value, zero), behind = hn::Not(hn::Xor(hn::Lt(middle.value, zero), below));
    const End begin = Choose(behind, middle, low), end = Choose(behind, high, middle);
    const Root root = SolveCubic(begin, end);
    const F apart = hn::Abs(hn::Sub(root.x, middle.x));
    const M near = hn::And(root.found, hn::Le(apart, tolerance));
    StoreEnd(begin, to.low, n), StoreEnd(end, to.high, n);
    hn::Store(hn::IfThenElse(near, root.x, KeepAway(root.x, begin, end)), d, to.next.data() + n);
    std::array<uint8_t, 8> bytes{};
    (void)hn::StoreMaskBits(d, near, bytes.data());
    uint64_t bits;
    std::memcpy(&bits, bytes.data(), sizeof bits);
    word |= (bits & ((uint64_t{1} << lanes) - 1)) << n % 64;
    if ((n + lanes) % 64 == 0 || n + lanes >= args.count) to.near[n / 64] = word, word = 0;
  }
}

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {
HWY_EXPORT(GuessRoots);
HWY_EXPORT(BracketRoots);

void guess_roots(const RootArgs& args, RootLanes& lanes) { HWY_DYNAMIC_DISPATCH(GuessRoots)(args, lanes); }
void bracket_roots(const RootArgs& args, std::span<const float> values,
                   std::span<const std::array<float, 4>> gradients, RootLanes& lanes) {
  HWY_DYNAMIC_DISPATCH(BracketRoots)(args, values.data(), gradients.data(), lanes);
}

} // namespace bccsplat
#endif

// SPDX-License-Identifier: Apache-2.0
// The loop of cell_refine.h through Highway: one body is compiled for every target, and the best is chosen at
// run time. A lane is a corner of the parts. Most cells are passed by the surface, which a few corners tell.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "rays/cell_refine_simd.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>

#include "rays/cell_refine.h"

#ifndef BCCSPLAT_CELL_REFINE_SHARED
#define BCCSPLAT_CELL_REFINE_SHARED
namespace bccsplat {

// Lanes of the corners at which a part begins.
alignas(64) inline constexpr auto part_begins = [] {
  std::array<uint32_t, RefinedStencil::room> lanes{};
  for (size_t n = 0; n < refined_corners; ++n) {
    const size_t x = n % refined_edge, y = n / refined_edge % refined_edge,
                 z = n / refined_edge / refined_edge;
    lanes[n] = std::max({x, y, z}) < refined_edge - 1 ? 1 : 0;
  }
  return lanes;
}();

} // namespace bccsplat
#endif

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<float, 16>;
using V = hn::Vec<D>;
constexpr D d;
constexpr size_t lanes = hn::MaxLanes(d);
// What is read beyond the corners of the last parts.
constexpr size_t beyond = refined_edge * refined_edge + refined_edge + 1;

// Returns for which cells, at most four, the field lies on both sides of the target at some of their corners.
uint64_t FindPassed(const RefineArgs& args, std::span<const CellSites> cells) {
  constexpr size_t most = 4; // so that no sum waits for another
  const V target = hn::Set(d, args.target);
  std::array<bool, most> above{}, below{};
  const auto cell = [&](size_t n) -> const CellSites& { return cells[std::min(n, cells.size() - 1)]; };
  const std::array<const CellSites*, most> of{&cell(0), &cell(1), &cell(2), &cell(3)};
  for (size_t n = 0; n < RefinedStencil::few; n += lanes) {
    V s0 = hn::Zero(d), s1 = s0, s2 = s0, s3 = s0;
    for (size_t i = 0; i < cell_sites; ++i) {
      const V weight = hn::Load(d, args.stencil->few_weights[i].data() + n);
      s0 = hn::MulAdd(hn::Set(d, (*of[0])[i]), weight, s0),
      s1 = hn::MulAdd(hn::Set(d, (*of[1])[i]), weight, s1);
      s2 = hn::MulAdd(hn::Set(d, (*of[2])[i]), weight, s2),
      s3 = hn::MulAdd(hn::Set(d, (*of[3])[i]), weight, s3);
    }
    const auto look = [&](size_t m, V sum) {
      above[m] |= !hn::AllFalse(d, hn::Ge(sum, target)), below[m] |= !hn::AllFalse(d, hn::Le(sum, target));
    };
    look(0, s0), look(1, s1), look(2, s2), look(3, s3);
  }
  uint64_t passed = 0;
  for (size_t m = 0; m < most; ++m) passed |= uint64_t{above[m] && below[m]} << m;
  return passed;
}

void SumCorners(const RefinedStencil& stencil, const CellSites& sites, float* corners) {
  constexpr size_t sums = 8; // at a time, so that none waits for another
  for (size_t n = 0; n < RefinedStencil::room; n += sums * lanes) {
    V sum[sums];
    for (auto& s : sum) s = hn::Zero(d);
    for (size_t i = 0; i < cell_sites; ++i) {
      const V c = hn::Set(d, sites[i]);
      const float* const weight = stencil.weights[i].data() + n;
      for (size_t m = 0; m < sums; ++m) sum[m] = hn::MulAdd(c, hn::Load(d, weight + m * lanes), sum[m]);
    }
    for (size_t m = 0; m < sums; ++m) hn::Store(sum[m], d, corners + n + m * lanes);
  }
}

// Returns whether any part's range, widened by what may lie between its corners, holds the target.
bool MayHold(const RefineArgs& args, const CellSites& sites) {
  alignas(64) float corners[RefinedStencil::room + beyond + lanes] = {};
  SumCorners(*args.stencil, sites, corners);
  const auto [least, most] = std::minmax_element(sites.begin(), sites.end());
  const float more = args.of_range * (*most - *least) + args.of_middle * std::fabs(*most + *least);
  const V above = hn::Set(d, args.target + more), below = hn::Set(d, args.target - more);
  const hn::RebindToUnsigned<D> du;
  constexpr size_t y = refined_edge, z = refined_edge * refined_edge;
  for (size_t n = 0; n < z * (refined_edge - 1); n += lanes) {
    V low = hn::Load(d, corners + n), high = low;
    for (const size_t step : {size_t{1}, y, y + 1, z, z + 1, z + y, z + y + 1}) {
      const V corner = hn::LoadU(d, corners + n + step);
      low = hn::Min(low, corner), high = hn::Max(high, corner);
    }
    const auto begins = hn::RebindMask(d, hn::Ne(hn::Load(du, part_begins.data() + n), hn::Zero(du)));
    if (!hn::AllFalse(d, hn::And(begins, hn::And(hn::Le(low, above), hn::Ge(high, below))))) return true;
  }
  return false;
}

} // namespace

uint64_t CellsThatMayHold(const RefineArgs& args, std::span<const CellSites> cells) {
  uint64_t may = 0;
  for (size_t n = 0; n < cells.size(); n += 4)
    may |= FindPassed(args, cells.subspan(n, std::min(cells.size() - n, size_t{4}))) << n;
  for (size_t n = 0; n < cells.size(); ++n)
    if ((may >> n & 1) == 0 && MayHold(args, cells[n])) may |= uint64_t{1} << n;
  if (cells.size() < 64) may &= (uint64_t{1} << cells.size()) - 1;
  return may;
}

} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {
HWY_EXPORT(CellsThatMayHold);

uint64_t cells_that_may_hold(const RefineArgs& args, std::span<const CellSites> cells) {
  return HWY_DYNAMIC_DISPATCH(CellsThatMayHold)(args, cells);
}

RefinedStencil::RefinedStencil(const RadialKernel& kernel) {
  for (size_t s = 0; s < cell_sites; ++s) {
    const auto coset = static_cast<double>(s / 27);
    for (size_t n = 0; n < refined_corners; ++n) {
      size_t site = s, corner = n;
      double square = 0; // planes
      for (size_t a = 0; a < 3; ++a, site /= 3, corner /= refined_edge) {
        const double at = coset + 2 * (static_cast<double>(site % 3) - 1);
        const double away = at - static_cast<double>(corner % refined_edge) / refined_parts;
        square += away * away;
      }
      const double r2 = 0.5 * square;
      weights[s][n] = r2 < kernel.radius * kernel.radius ? static_cast<float>(kernel.value(r2)) : 0.0f;
    }
    // The cell's corners, the centres of its faces, and its own, twice.
    constexpr std::array<std::array<size_t, 3>, few> places{{{0, 0, 0},
                                                             {4, 0, 0},
                                                             {0, 4, 0},
                                                             {4, 4, 0},
                                                             {0, 0, 4},
                                                             {4, 0, 4},
                                                             {0, 4, 4},
                                                             {4, 4, 4},
                                                             {0, 2, 2},
                                                             {4, 2, 2},
                                                             {2, 0, 2},
                                                             {2, 4, 2},
                                                             {2, 2, 0},
                                                             {2, 2, 4},
                                                             {2, 2, 2},
                                                             {2, 2, 2}}};
    for (size_t n = 0; n < few; ++n)
      few_weights[s][n] =
          weights[s][(places[n][2] * refined_edge + places[n][1]) * refined_edge + places[n][0]];
  }
}

} // namespace bccsplat
#endif

// SPDX-License-Identifier: Apache-2.0
// Brings the sites of the patches of several points into the lanes of vectors, a lane a point. Included once
// per target.
#if defined(BCCSPLAT_SLICE_PATCH_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef BCCSPLAT_SLICE_PATCH_LANES_INL_H
#undef BCCSPLAT_SLICE_PATCH_LANES_INL_H
#else
#define BCCSPLAT_SLICE_PATCH_LANES_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>

#include "field/footprint/patch_sites.h"
#include "field/footprint/patch_sum-inl.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace {

// Weights of the layers in reach of the points of a vector, and their slopes in time.
struct LayerWeights {
  Floats w[max_stack], dw[max_stack];
};

// from: (t - time of the first layer) / pitch, of each lane.
template<bool slopes>
HWY_INLINE void WeighLayers(const FootprintPlan& plan, const float* from, LayerWeights& layers) {
  const Lanes d;
  if (plan.timeless || plan.kernel->time.shape == TemporalKernel::Shape::bspline) {
    WeighSpline<slopes>(plan.depth, plan.bend, hn::Load(d, from), layers.w, layers.dw);
    return;
  }
  alignas(64) std::array<std::array<float, lanes>, max_stack> w{}, dw{};
  for (size_t i = 0; i < lanes; ++i) {
    std::array<float, max_stack> value, slope;
    if (i > 0 && from[i] == from[i - 1]) {
      for (size_t k = 0; k < max_stack; ++k) w[k][i] = w[k][i - 1], dw[k][i] = dw[k][i - 1];
      continue;
    }
    weigh_by_kernel(plan, from[i], value, slope);
    for (size_t k = 0; k < static_cast<size_t>(plan.depth); ++k) w[k][i] = value[k], dw[k][i] = slope[k];
  }
  for (size_t k = 0; k < max_stack; ++k)
    layers.w[k] = hn::Load(d, w[k].data()), layers.dw[k] = hn::Load(d, dw[k].data());
}

// Lanes begin .. end - 1.
struct LaneRun {
  size_t begin, end;
};

// Points of one patch: its sites go to all their lanes. timed: with rates; weighted: layers weigh other
// than 1.
template<int edge, int count, bool timed, bool weighted>
HWY_INLINE void FillRun(const PatchSites& patch, const LayerWeights& weights, const LaneRun& run,
                        LaneSites& sites) {
  const Lanes d;
  const bool whole = run.end - run.begin == lanes;
  const auto mine = hn::AndNot(hn::FirstN(d, run.begin), hn::FirstN(d, run.end));
  Floats w[std::max(count, 1)], dw[std::max(count, 1)];
  if constexpr (weighted)
    for (size_t k = 0; k < count; ++k) w[k] = weights.w[patch.place[k]], dw[k] = weights.dw[patch.place[k]];
  const auto store = [&](Floats v, float* to)
                         HWY_ATTR { whole ? hn::Store(v, d, to) : hn::BlendedStore(v, mine, d, to); };
  size_t to = 0;
  for (size_t z = 0; z < edge; ++z)
    for (size_t y = 0; y < edge; ++y)
      for (size_t x = 0; x < edge; ++x, to += lanes) {
        const size_t at = z * patch.plane + y * patch.row + x;
        auto value = Set(0), rate = value;
        for (size_t k = 0; k < count; ++k) {
          const auto site = Set(patch.corner[k][at]);
          if constexpr (!weighted)
            value = site;
          else
            value = k == 0 ? hn::Mul(w[k], site) : hn::MulAdd(w[k], site, value);
          if constexpr (timed) rate = k == 0 ? hn::Mul(dw[k], site) : hn::MulAdd(dw[k], site, rate);
        }
        store(value, sites.value.data() + to);
        if constexpr (timed) store(rate, sites.rate.data() + to);
      }
}

template<int edge, bool timed>
void FillRunOf(const FootprintPlan& plan, const PatchSites& patch, const LayerWeights& weights,
               const LaneRun& run, LaneSites& sites) {
  switch (patch.layers) {
  case 0:
    return FillRun<edge, 0, timed, true>(patch, weights, run, sites);
  case 1:
    if (plan.timeless) return FillRun<edge, 1, false, false>(patch, weights, run, sites);
    return FillRun<edge, 1, timed, true>(patch, weights, run, sites);
  case 2:
    return FillRun<edge, 2, timed, true>(patch, weights, run, sites);
  case 3:
    return FillRun<edge, 3, timed, true>(patch, weights, run, sites);
  default:
    return FillRun<edge, 4, timed, true>(patch, weights, run, sites);
  }
}

// Does the same for a whole vector of points, row by row.
template<int edge, bool timed> struct RunRows {
  const PatchSites& patch;
  const LayerWeights& weights;
  bool weighted;
  HWY_INLINE void operator()(size_t z, size_t y, Floats (&value)[edge], Floats (&rate)[edge]) const {
    const size_t at = z * patch.plane + y * patch.row;
    const float* row = patch.corner[0] + at;
    const auto w = weighted ? weights.w[patch.place[0]] : Set(1);
    for (size_t x = 0; x < edge; ++x) value[x] = hn::Mul(w, Set(row[x]));
    if constexpr (timed)
      for (size_t x = 0; x < edge; ++x) rate[x] = hn::Mul(weights.dw[patch.place[0]], Set(row[x]));
    for (size_t k = 1; k < static_cast<size_t>(patch.layers); ++k) {
      row = patch.corner[k] + at;
      const auto more = weights.w[patch.place[k]];
      for (size_t x = 0; x < edge; ++x) value[x] = hn::MulAdd(more, Set(row[x]), value[x]);
      if constexpr (timed) {
        const auto change = weights.dw[patch.place[k]];
        for (size_t x = 0; x < edge; ++x) rate[x] = hn::MulAdd(change, Set(row[x]), rate[x]);
      }
    }
  }
};

// Four neighbours along x: one vector, or several where vectors are shorter.
using RowTag = hn::CappedTag<float, patch_edge>;
inline constexpr size_t row_step = hn::MaxLanes(RowTag());

// Patches of single points, in rows of 4 sites; rates behind the values.
struct LanePatches {
  static constexpr size_t rates = patch_sites * lanes;
  alignas(64) std::array<float, 2 * rates> sites;
};

// The patch of one lane, its layers weighted: the same sums as FillRun's.
template<int edge, int count, bool timed, bool weighted>
HWY_INLINE void FillPatch(const PatchSites& patch, const float* w, const float* dw, float* value,
                          float* rate) {
  const RowTag d;
  const auto weight = [&](const float* of, size_t k)
                          HWY_ATTR { return hn::Set(d, of[patch.place[k] * lanes]); };
  hn::Vec<RowTag> of[std::max(count, 1)], slope[std::max(count, 1)];
  std::array<const float*, max_stack> corner;
  for (size_t k = 0; k < count; ++k) corner[k] = patch.corner[k];
  const size_t plane = patch.plane, row_of = patch.row;
  if constexpr (weighted)
    for (size_t k = 0; k < count; ++k) {
      of[k] = weight(w, k);
      if constexpr (timed) slope[k] = weight(dw, k);
    }
  for (size_t z = 0; z < edge; ++z)
    for (size_t y = 0; y < edge; ++y)
      for (size_t x = 0; x < patch_edge; x += row_step) {
        const size_t at = z * plane + y * row_of + x, to = (z * patch_edge + y) * patch_edge + x;
        auto sum = hn::Zero(d), change = sum;
        for (size_t k = 0; k < count; ++k) {
          const auto row = hn::LoadU(d, corner[k] + at);
          if constexpr (!weighted)
            sum = row;
          else
            sum = k == 0 ? hn::Mul(of[k], row) : hn::MulAdd(of[k], row, sum);
          if constexpr (timed) change = k == 0 ? hn::Mul(slope[k], row) : hn::MulAdd(slope[k], row, change);
        }
        hn::Store(sum, d, value + to);
        if constexpr (timed) hn::Store(change, d, rate + to);
      }
}

// w, dw: of layer k in reach at k * lanes.
template<int edge, bool timed>
void FillPatchOf(const FootprintPlan& plan, const PatchSites& patch, const float* w, const float* dw,
                 float* value, float* rate) {
  switch (patch.layers) {
  case 0:
    return FillPatch<edge, 0, timed, true>(patch, w, dw, value, rate);
  case 1:
    if (plan.timeless) return FillPatch<edge, 1, false, false>(patch, w, dw, value, rate);
    return FillPatch<edge, 1, timed, true>(patch, w, dw, value, rate);
  case 2:
    return FillPatch<edge, 2, timed, true>(patch, w, dw, value, rate);
  case 3:
    return FillPatch<edge, 3, timed, true>(patch, w, dw, value, rate);
  default:
    return FillPatch<edge, 4, timed, true>(patch, w, dw, value, rate);
  }
}

// Site x of row[lane] + at, for x below edge.
#if HWY_TARGET == HWY_SCALAR
template<int edge> HWY_INLINE void TurnRow(const float* const* row, size_t at, Floats (&site)[edge]) {
  for (size_t x = 0; x < edge; ++x) site[x] = Set(row[0][at + x]);
}
#else
// Rows of 4 sites of the lanes first, first + 4 .. next to each other.
template<size_t blocks> HWY_INLINE auto Blocks(const float* const* row, size_t at, size_t first) {
  const hn::CappedTag<float, 4 * blocks> d;
  if constexpr (blocks == 1)
    return hn::LoadU(d, row[first] + at);
  else
    return hn::Combine(d, Blocks<blocks / 2>(row, at, first + 2 * blocks),
                       Blocks<blocks / 2>(row, at, first));
}

template<int edge> HWY_INLINE void TurnRow(const float* const* row, size_t at, Floats (&site)[edge]) {
  const Lanes d;
  const hn::RepartitionToWide<Lanes> pair;
  // The 4 x 4 sites of each block of 4 lanes change places.
  const auto v0 = Blocks<lanes / 4>(row, at, 0), v1 = Blocks<lanes / 4>(row, at, 1),
             v2 = Blocks<lanes / 4>(row, at, 2), v3 = Blocks<lanes / 4>(row, at, 3);
  const auto low01 = hn::BitCast(pair, hn::InterleaveLower(d, v0, v1)),
             low23 = hn::BitCast(pair, hn::InterleaveLower(d, v2, v3)),
             high01 = hn::BitCast(pair, hn::InterleaveUpper(d, v0, v1)),
             high23 = hn::BitCast(pair, hn::InterleaveUpper(d, v2, v3));
  site[0] = hn::BitCast(d, hn::InterleaveLower(pair, low01, low23));
  site[1] = hn::BitCast(d, hn::InterleaveUpper(pair, low01, low23));
  site[2] = hn::BitCast(d, hn::InterleaveLower(pair, high01, high23));
  if constexpr (edge == 4) site[3] = hn::BitCast(d, hn::InterleaveUpper(pair, high01, high23));
}
#endif

// The patches that begin at corner[lane], rates `rate` floats behind.
template<int edge, bool timed> struct TurnedRows {
  std::array<const float*, lanes> corner;
  size_t row, plane, rate;
  HWY_INLINE void operator()(size_t z, size_t y, Floats (&value)[edge], Floats (&change)[edge]) const {
    const size_t at = z * plane + y * row;
    TurnRow<edge>(corner.data(), at, value);
    if constexpr (timed) TurnRow<edge>(corner.data(), at + rate, change);
  }
};

template<int edge, bool timed>
HWY_INLINE void StoreRows(const TurnedRows<edge, timed>& rows, LaneSites& sites) {
  for (size_t z = 0; z < edge; ++z)
    for (size_t y = 0; y < edge; ++y) {
      Floats value[edge], rate[edge];
      rows(z, y, value, rate);
      for (size_t x = 0; x < edge; ++x) {
        const size_t at = ((z * edge + y) * edge + x) * lanes;
        hn::Store(value[x], Lanes(), sites.value.data() + at);
        if constexpr (timed) hn::Store(rate[x], Lanes(), sites.rate.data() + at);
      }
    }
}

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#endif

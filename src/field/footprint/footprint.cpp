// SPDX-License-Identifier: Apache-2.0
// Sums footprints of points, a lane each: sites come from copies around a batch, from bricks shared by a run
// of points, or patch by patch (tests/bench/notes/kernels.md, "Speed").
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "field/footprint/footprint.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "field/footprint/dense_sites.h"
#include "field/footprint/footprint.h"
#include "field/footprint/patch_lanes-inl.h"
#include "field/footprint/patch_sum-inl.h"

#ifndef BCCSPLAT_FOOTPRINT_SHARED
#define BCCSPLAT_FOOTPRINT_SHARED
namespace bccsplat {

// Points whose sites are copied together, and parts of a batch that spreads too far for that: larger batches
// share more copied sites, and spread further.
inline constexpr size_t footprint_batch = 512;
inline constexpr size_t footprint_part = 128;

} // namespace bccsplat
#endif

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace {

// Per batch: where each point's patch begins, and how far from its first site the point lies; per axis x, y,
// z, t, in pitches. The last point is repeated until vectors are full.
struct Spans {
  // A vector from the second point on may be read.
  alignas(64) std::array<std::array<int32_t, footprint_batch + lanes>, 4> first;
  alignas(64) std::array<std::array<float, footprint_batch>, 4> from;

  [[nodiscard]] std::array<int32_t, 4> patch(size_t n) const {
    return {first[0][n], first[1][n], first[2][n], first[3][n]};
  }
};

void FindSpans(const FootprintPlan& plan, const FootprintPlan::Coset& coset, std::span<const Vec4> points,
               Spans& spans) {
  const hn::CappedTag<double, 8> d;
  const hn::Rebind<int32_t, decltype(d)> di;
  const hn::Rebind<float, decltype(d)> df;
  constexpr size_t step = hn::MaxLanes(d);
  const size_t end = (points.size() + lanes - 1) / lanes * lanes;
  const auto one = hn::Set(d, 1.0);
  for (size_t n = 0; n < end; n += step) {
    std::array<Vec4, step> rest;
    const double* from = rest[0].data();
    if (n + step <= points.size()) {
      from = points[n].data();
    } else {
      const size_t there = n < points.size() ? points.size() - n : 0;
      std::copy_n(points.begin() + n, there, rest.begin());
      std::fill(rest.begin() + there, rest.end(), points.back());
    }
    hn::Vec<decltype(d)> p[4];
    hn::LoadInterleaved4(d, from, p[0], p[1], p[2], p[3]);
    for (size_t a = 0; a < 4; ++a) {
      if (a == 3 && plan.timeless) {
        hn::Store(hn::Zero(di), di, spans.first[a].data() + n);
        hn::Store(hn::Zero(df), df, spans.from[a].data() + n);
        continue;
      }
      const auto x = hn::MulAdd(p[a], hn::Set(d, plan.per_pitch[a]), hn::Set(d, coset.origin[a]));
      const auto first = hn::Add(hn::Floor(hn::Sub(x, hn::Set(d, plan.radius[a]))), one);
      hn::Store(hn::DemoteTo(di, first), di, spans.first[a].data() + n);
      hn::Store(hn::DemoteTo(df, hn::Sub(x, first)), df, spans.from[a].data() + n);
    }
  }
}

// Points begin .. end - 1 of a batch; whole vectors but for the end of the batch.
struct Range {
  size_t begin, end;
  [[nodiscard]] size_t size() const { return end - begin; }
};

template<class T> struct Extent { T low, high; };
template<class T> Extent<T> ExtentOf(const T* v, const Range& range) {
  const hn::CappedTag<T, 16> d;
  auto low = hn::Load(d, v + range.begin), high = low;
  for (size_t n = range.begin; n < range.end; n += lanes)
    low = hn::Min(low, hn::Load(d, v + n)), high = hn::Max(high, hn::Load(d, v + n));
  return {hn::GetLane(hn::MinOfLanes(d, low)), hn::GetLane(hn::MaxOfLanes(d, high))};
}

// Returns whether all points are at one instant; then `box` holds their patches.
bool FindBox(const FootprintPlan& plan, const Spans& spans, const Range& range, SiteBox& box) {
  const auto layer = ExtentOf(spans.first[3].data(), range);
  const auto time = ExtentOf(spans.from[3].data(), range);
  if (layer.low != layer.high || time.low != time.high) return false;
  for (size_t a = 0; a < 3; ++a) {
    const auto first = ExtentOf(spans.first[a].data(), range);
    box.origin[a] = first.low;
    box.size[a] = first.high - first.low + (a == 0 ? patch_edge : plan.edge);
  }
  return true;
}

// to = w * from, or to += w * from.
void AddScaled(float w, const float* from, float* to, size_t count, bool add) {
  const hn::ScalableTag<float> d;
  const auto v = hn::Set(d, w);
  for (size_t i = 0; i < count; i += hn::Lanes(d)) { // layers are whole vectors
    const auto x = hn::LoadU(d, from + i);
    hn::StoreU(add ? hn::MulAdd(v, x, hn::LoadU(d, to + i)) : hn::Mul(v, x), d, to + i);
  }
}

// Copies the sites that points at one instant need where that is cheap against finding them one by one; else
// false.
template<bool slopes>
bool CopySites(const FootprintPlan& plan, const std::array<Spans, 2>& spans, const Range& range,
               DenseScratch& scratch) {
  std::array<SiteBox, 2> box;
  for (size_t c = 0; c < static_cast<size_t>(plan.cosets); ++c)
    if (!FindBox(plan, spans[c], range, box[c])) return false;
  if (!scratch.reserve(plan, box, range.size(), slopes)) return false;
  for (size_t c = 0; c < static_cast<size_t>(plan.cosets); ++c) {
    const auto& coset = plan.coset[c];
    const Spans& s = spans[c];
    DenseSites& sites = scratch.sites[c];
    if (plan.timeless) {
      sites.air = !gather_box(*coset.layer[0], sites.box, sites.value);
      continue;
    }
    LayerWeights weights;
    WeighLayers<slopes>(plan, s.from[3].data() + range.begin, weights);
    for (size_t k = 0; k < static_cast<size_t>(plan.depth); ++k) {
      const auto layer = s.first[3][range.begin] + k; // wraps round below 0
      if (layer >= coset.layer.size()) continue;
      // Layers that are air add nothing.
      if (!gather_box(*coset.layer[layer], sites.box, scratch.single)) continue;
      AddScaled(hn::GetLane(weights.w[k]), scratch.single, sites.value, sites.layer, !sites.air);
      if (slopes)
        AddScaled(hn::GetLane(weights.dw[k]), scratch.single, sites.value + sites.layer, sites.layer,
                  !sites.air);
      sites.air = false;
    }
  }
  return true;
}

// The patches of a vector of points in the copies around them.
template<int edge, bool timed>
HWY_INLINE TurnedRows<edge, timed> LookUpCopies(const DenseSites& dense, const Spans& spans, size_t n) {
  const hn::RebindToSigned<Lanes> di;
  const auto along = [&](size_t a) HWY_ATTR {
    return hn::Sub(hn::Load(di, spans.first[a].data() + n), hn::Set(di, dense.box.origin[a]));
  };
  const auto times = [&](hn::Vec<decltype(di)> v, size_t by)
                         HWY_ATTR { return hn::Mul(v, hn::Set(di, static_cast<int32_t>(by))); };
  const auto offset = hn::Add(hn::Add(along(0), times(along(1), dense.row)), times(along(2), dense.plane));
  alignas(64) std::array<int32_t, lanes> offsets;
  hn::Store(offset, di, offsets.data());
  TurnedRows<edge, timed> rows{{}, dense.row, dense.plane, dense.layer};
  for (size_t i = 0; i < lanes; ++i) rows.corner[i] = dense.value + offsets[i];
  return rows;
}

// Points of one patch in a row; how many runs.
HWY_INLINE size_t FindRuns(const Spans& spans, size_t n, std::array<LaneRun, lanes>& runs) {
  const hn::RebindToSigned<Lanes> d;
  auto differs = hn::Zero(d); // from the next lane
  for (const auto& first : spans.first)
    differs = hn::Or(differs, hn::Xor(hn::Load(d, first.data() + n), hn::LoadU(d, first.data() + n + 1)));
  std::array<uint8_t, 8> bytes{};
  (void)hn::StoreMaskBits(d, hn::Ne(differs, hn::Zero(d)), bytes.data());
  uint32_t ends = bytes[0] | uint32_t{bytes[1]} << 8;
  ends |= 1u << (lanes - 1);
  size_t count = 0;
  for (size_t begin = 0; begin < lanes; ++count) {
    const size_t last = std::countr_zero(ends);
    runs[count] = {begin, last + 1};
    begin = last + 1;
    ends &= ends - 1;
  }
  return count;
}

// The part of the work space that is kept from one vector of points to the next.
struct LookUp {
  std::array<PatchSites, 2> patch;
  LanePatches single;
};

// Reads the sites of a vector of points that lie in several patches from bricks. False where all is air.
template<int edge, bool timed>
bool LookUpBricks(const FootprintPlan& plan, const FootprintPlan::Coset& coset, const Spans& spans, size_t n,
                  const LayerWeights& weights, std::span<const LaneRun> runs, PatchSites& patch,
                  LanePatches& single, LaneSites& sites) {
  const Lanes d;
  constexpr size_t shortest = 3; // that is worth vectors of its own
  bool any = false, singles = false;
  alignas(64) std::array<std::array<float, lanes>, max_stack> w, dw;
  for (const LaneRun& run : runs) {
    if (run.end - run.begin >= shortest) continue;
    if (!singles && !plan.timeless)
      for (size_t k = 0; k < static_cast<size_t>(plan.depth); ++k) {
        hn::Store(weights.w[k], d, w[k].data());
        if (timed) hn::Store(weights.dw[k], d, dw[k].data());
      }
    singles = true;
    find_patch(plan, coset, spans.patch(n + run.begin), patch);
    any = any || patch.layers > 0;
    for (size_t i = run.begin; i < run.end; ++i)
      FillPatchOf<edge, timed>(plan, patch, w[0].data() + i, dw[0].data() + i,
                               single.sites.data() + i * patch_sites,
                               single.sites.data() + LanePatches::rates + i * patch_sites);
  }
  if (singles) {
    TurnedRows<edge, timed> rows{{}, patch_edge, patch_rows, LanePatches::rates};
    for (size_t i = 0; i < lanes; ++i) rows.corner[i] = single.sites.data() + i * patch_sites;
    StoreRows(rows, sites);
  }
  for (const LaneRun& run : runs) {
    if (run.end - run.begin < shortest) continue;
    find_patch(plan, coset, spans.patch(n + run.begin), patch);
    any = any || patch.layers > 0;
    FillRunOf<edge, timed>(plan, patch, weights, run, sites);
  }
  return any;
}

// Which bodies there are, of those that take half a minute to be compiled:
//
//   kernel      points at one instant    a patch for all lanes    several patches
//   contact     copies of sites          rows to all lanes        patches to lanes
//   Gaussians   copies of sites          as several patches       patches to lanes
//
// Gaussians win 1.5 to 1.9 times by copies (grids, values) and nothing by rows of their own. Scalar code, for
// machines older than SSSE3, has the last body alone, for all kernels.
inline constexpr bool copying = HWY_TARGET != HWY_SCALAR;

template<int edge, bool slopes, bool timed, bool contact, bool dense>
void SumRange(const FootprintPlan& plan, const DenseScratch& copies, LookUp& bricks,
              const std::array<Spans, 2>& spans, std::span<const Vec4> points, const Range& range,
              float* values, std::array<float, 4>* gradients) {
  const Lanes d;
  const Curve<contact> curve(plan);
  const auto to_space = Set(-2 * plan.inverse_radius2 * static_cast<float>(plan.per_pitch[0])),
             to_time = Set(static_cast<float>(plan.per_pitch[3]));
  LaneSites sites;
  for (size_t n = range.begin; n < range.end; n += lanes) {
    auto sums = NoSums<edge, slopes>();
    for (size_t c = 0; c < static_cast<size_t>(plan.cosets); ++c) {
      const auto& from = spans[c].from;
      const Place place{from[0].data() + n, from[1].data() + n, from[2].data() + n};
      if constexpr (dense) {
        if (!copies.sites[c].air)
          AddPatches<edge, slopes, timed>(
              plan, curve, LookUpCopies<edge, timed>(copies.sites[c], spans[c], n), place, sums);
      } else {
        const auto& coset = plan.coset[c];
        LayerWeights weights;
        if (!plan.timeless) WeighLayers<slopes>(plan, from[3].data() + n, weights);
        std::array<LaneRun, lanes> runs;
        const size_t count = FindRuns(spans[c], n, runs);
        // The next vector's last patch, where it differs from this one's.
        if (const size_t next = n + 2 * lanes - 1;
            next < range.end && spans[c].patch(next) != spans[c].patch(n + lanes - 1))
          fetch_patch(plan, coset, spans[c].patch(next));
        if constexpr (contact)
          if (count == 1) {
            find_patch(plan, coset, spans[c].patch(n), bricks.patch[c]);
            if (bricks.patch[c].layers == 0) continue;
            const RunRows<edge, timed> rows{bricks.patch[c], weights, !plan.timeless};
            AddPatches<edge, slopes, timed>(plan, curve, rows, place, sums);
            continue;
          }
        if (LookUpBricks<edge, timed>(plan, coset, spans[c], n, weights, std::span(runs).first(count),
                                      bricks.patch[c], bricks.single, sites)) {
          AddPatches<edge, slopes, timed>(plan, curve, StoredRows<edge, timed>{sites}, place, sums);
        }
      }
    }
    const size_t count = std::min(lanes, range.end - n);
    if (count == lanes)
      hn::StoreU(Total(sums.value), d, values + n);
    else
      hn::BlendedStore(Total(sums.value), hn::FirstN(d, count), d, values + n);
    if constexpr (slopes) {
      alignas(64) std::array<std::array<float, 4>, lanes> rest;
      float* to = count == lanes ? gradients[n].data() : rest[0].data();
      hn::StoreInterleaved4(hn::Mul(to_space, Total(sums.x)), hn::Mul(to_space, sums.y),
                            hn::Mul(to_space, sums.z), hn::Mul(to_time, sums.time), d, to);
      if (count < lanes) std::copy_n(rest.begin(), count, gradients + n);
    }
    if (plan.kernel->normalised)
      for (size_t i = n; i < n + count; ++i)
        divide_by_lattice_sum(plan, points[i], values[i], slopes ? &gradients[i] : nullptr);
  }
}

template<int edge, bool slopes, bool timed, bool contact>
void SumBatches(const FootprintPlan& plan, std::span<const Vec4> points, float* values,
                std::array<float, 4>* gradients) {
  std::array<Spans, 2> spans;
  DenseScratch copies;
  LookUp bricks;
  for (size_t begin = 0; begin < points.size(); begin += footprint_batch) {
    const auto batch = points.subspan(begin, std::min(footprint_batch, points.size() - begin));
    for (int c = 0; c < plan.cosets; ++c) FindSpans(plan, plan.coset[c], batch, spans[c]);
    const auto sum = [&](const Range& range, bool dense) {
      auto body = SumRange<edge, slopes, timed, contact, false>;
      if constexpr (copying)
        if (dense) body = SumRange<edge, slopes, timed, contact, true>;
      body(plan, copies, bricks, spans, batch, range, values + begin, slopes ? gradients + begin : nullptr);
    };
    const Range all{0, batch.size()};
    constexpr size_t fewest = 8; // points worth a copy
    if (!copying || batch.size() < fewest) {
      sum(all, false);
      continue;
    }
    if (CopySites<slopes>(plan, spans, all, copies)) {
      sum(all, true);
      continue;
    }
    for (Range part{0, 0}; part.begin < all.end; part.begin = part.end) {
      part.end = std::min(part.begin + footprint_part, all.end);
      sum(part, CopySites<slopes>(plan, spans, part, copies));
    }
  }
}

void SumFootprints(const FootprintPlan& plan, std::span<const Vec4> points, float* values,
                   std::array<float, 4>* gradients) {
  const auto choose = [&]<int edge, bool contact>(std::integral_constant<int, edge>,
                                                  std::bool_constant<contact>) {
    if (!gradients) return SumBatches<edge, false, false, contact>;
    return plan.timeless ? SumBatches<edge, true, false, contact> : SumBatches<edge, true, true, contact>;
  };
  const auto of = [&](auto edge) {
    if constexpr (copying)
      if (plan.contact) return choose(edge, std::true_type());
    return choose(edge, std::false_type());
  };
  const auto sum =
      plan.edge == 3 ? of(std::integral_constant<int, 3>()) : of(std::integral_constant<int, 4>());
  sum(plan, points, values, gradients);
}

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {
HWY_EXPORT(SumFootprints);

void sum_footprints(const FootprintPlan& plan, std::span<const Vec4> points, float* values,
                    std::array<float, 4>* gradients) {
  HWY_DYNAMIC_DISPATCH(SumFootprints)(plan, points, values, gradients);
}

void sum_footprints(const FieldLayers& field, std::span<const Vec4> points, float* values,
                    std::array<float, 4>* gradients) {
  sum_footprints(FootprintPlan(field), points, values, gradients);
}

} // namespace bccsplat
#endif

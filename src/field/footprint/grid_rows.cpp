// SPDX-License-Identifier: Apache-2.0
// Weighs the three or four sites in reach of each sample, a vector of samples at a time: coefficients are
// taken out of one vector where it holds the sites of all, and are gathered from memory elsewhere. Made for
// all instruction sets.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "field/footprint/grid_rows.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>

#include "field/footprint/grid_rows.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace {

using Samples = hn::ScalableTag<float>;
using Index = hn::RebindToSigned<Samples>;

template<int edge, class Lookup>
HWY_INLINE hn::Vec<Samples> SumRows(const FootprintPlan& plan, std::span<const SiteRow> rows,
                                    const hn::Vec<Samples> from, hn::Vec<Samples> sum, const Lookup& lookup) {
  const Samples d;
  const auto scale = hn::Set(d, plan.inverse_radius2), zero = hn::Zero(d);
  hn::Vec<Samples> square[edge];
  for (int x = 0; x < edge; ++x) {
    const auto dx = hn::Sub(from, hn::Set(d, static_cast<float>(x)));
    square[x] = hn::Mul(scale, hn::Mul(dx, dx));
  }
  for (const SiteRow& row : rows) {
    hn::Vec<Samples> u[edge], weight[edge];
    for (int x = 0; x < edge; ++x) {
      u[x] = hn::Sub(hn::Set(d, row.u), square[x]);
      weight[x] = hn::Set(d, plan.a[static_cast<size_t>(plan.terms) - 1]);
    }
    for (int j = plan.terms - 2; j >= 0; --j) {
      const auto a = hn::Set(d, plan.a[j]);
      for (int x = 0; x < edge; ++x) weight[x] = hn::MulAdd(weight[x], u[x], a);
    }
    hn::Vec<Samples> c[edge];
    lookup(row.value, c);
    for (int x = 0; x < edge; ++x)
      sum = hn::MulAdd(hn::IfThenElseZero(hn::Gt(u[x], zero), weight[x]), c[x], sum);
  }
  return sum;
}

template<int edge>
void AddRow(const FootprintPlan& plan, std::span<const SiteRow> rows, int32_t base,
            std::span<const int32_t> first, const float* from, float* sums) {
  const Samples d;
  const Index di;
  const size_t lanes = hn::Lanes(d);
  for (size_t i = 0; i < first.size(); i += lanes) {
    const size_t end = std::min(i + lanes, first.size()) - 1;
    const int32_t low = std::min(first[i], first[end]), high = std::max(first[i], first[end]);
    // The padding may hold anything: lanes without a sample look at other samples' sites.
    const auto within =
        hn::Min(hn::Max(hn::LoadU(di, first.data() + i), hn::Set(di, low)), hn::Set(di, high));
    const auto at = hn::Sub(within, hn::Set(di, low));
    const auto distance = hn::LoadU(d, from + i), sum = hn::LoadU(d, sums + i);
    const auto skip = low - base;
    hn::Vec<Samples> result;
    if (static_cast<size_t>(high - low + edge) <= lanes) { // one vector holds the sites of all
      const auto lookup = [&](const float* row, hn::Vec<Samples>* c) HWY_ATTR {
        const auto sites = hn::LoadU(d, row + skip);
        for (int x = 0; x < edge; ++x)
          c[x] = hn::TableLookupLanes(sites, hn::IndicesFromVec(d, hn::Add(at, hn::Set(di, x))));
      };
      result = SumRows<edge>(plan, rows, distance, sum, lookup);
    } else {
      const auto lookup = [&](const float* row, hn::Vec<Samples>* c) HWY_ATTR {
        for (int x = 0; x < edge; ++x) c[x] = hn::GatherIndex(d, row + (skip + x), at);
      };
      result = SumRows<edge>(plan, rows, distance, sum, lookup);
    }
    hn::StoreU(result, d, sums + i);
  }
}

void AddGridRow(const FootprintPlan& plan, std::span<const SiteRow> rows, int32_t base,
                std::span<const int32_t> first, const float* from, float* sums) {
  const auto add = plan.edge == 3 ? AddRow<3> : AddRow<4>;
  add(plan, rows, base, first, from, sums);
}

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {
HWY_EXPORT(AddGridRow);

AxisSamples axis_samples(const FootprintPlan& plan, size_t coset, size_t axis,
                         std::span<const double> positions) {
  AxisSamples s;
  s.first.reserve(positions.size() + grid_row_padding);
  s.from.reserve(positions.size() + grid_row_padding);
  for (const double p : positions) {
    const double x = p * plan.per_pitch[axis] + plan.coset[coset].origin[axis];
    const double first = std::floor(x - plan.radius[axis]) + 1;
    s.first.push_back(static_cast<int32_t>(first));
    s.from.push_back(static_cast<float>(x - first));
  }
  s.first.resize(positions.size() + grid_row_padding);
  s.from.resize(positions.size() + grid_row_padding);
  return s;
}

void add_grid_row(const FootprintPlan& plan, std::span<const SiteRow> rows, int32_t base,
                  std::span<const int32_t> first, const float* from, float* sums) {
  HWY_DYNAMIC_DISPATCH(AddGridRow)(plan, rows, base, first, from, sums);
}

} // namespace bccsplat
#endif

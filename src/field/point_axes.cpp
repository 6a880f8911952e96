// SPDX-License-Identifier: Apache-2.0
// Places and scales the points of a caller, vector by vector.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "field/point_axes.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include <algorithm>
#include <limits>

#include "field/point_axes.h"
#include "field/slice.h"
#include "kernel/kernel_time.h"
#include "points/brick.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace {

using Numbers = hn::CappedTag<double, 8>;
using Integers = hn::Rebind<int32_t, Numbers>;
inline constexpr size_t step = hn::MaxLanes(Numbers());

void PlacePoints(const PointAxes& axes, const Vec4* points, size_t count, bool clip, PointPlace* places) {
  const Numbers d;
  const Integers di;
  const auto zero = hn::Zero(d);
  for (size_t n = 0; n < count; n += step) {
    std::array<Vec4, step> rest;
    const double* from = rest[0].data();
    if (n + step <= count)
      from = points[n].data();
    else
      for (size_t i = 0; i < step; ++i) rest[i] = points[std::min(n + i, count - 1)];
    hn::Vec<Numbers> p[4];
    hn::LoadInterleaved4(d, from, p[0], p[1], p[2], p[3]);
    const auto clamped = [&](size_t a) HWY_ATTR {
      const auto end = hn::Set(d, axes.end[a]);
      return hn::Max(hn::IfThenElse(hn::Lt(p[a], end), p[a], end), zero);
    };
    auto cell = hn::Zero(di), window = cell;
    if (axes.cell_count > 1)
      for (size_t a = 3; a-- > 0;)
        cell = hn::Add(hn::Mul(cell, hn::Set(di, axes.cells[a])),
                       hn::DemoteTo(di, hn::Mul(clamped(a), hn::Set(d, axes.per_cell[a]))));
    if (axes.per_layer != 0) {
      const auto layers = hn::Mul(clip ? clamped(3) : p[3], hn::Set(d, axes.per_layer));
      window = hn::DemoteTo(di, hn::Floor(layers));
    }
    alignas(32) std::array<int32_t, step> windows, cells;
    hn::Store(window, di, windows.data());
    hn::Store(cell, di, cells.data());
    for (size_t i = 0; i < std::min(step, count - n); ++i)
      places[n + i] = {windows[i], static_cast<uint32_t>(cells[i])};
  }
}

size_t ScalePoints(const PointAxes& axes, const Vec4* points, const uint64_t* at, size_t count, bool clip,
                   Vec4* scaled, uint8_t* outside) {
  const hn::CappedTag<double, 4> d;
  constexpr size_t ahead = 24; // points that are being fetched
  constexpr double infinity = std::numeric_limits<double>::infinity();
  // Whatever t is, it is within where there is no time.
  const Vec4 take{1, 1, 1, axes.per_layer != 0 ? 1.0 : 0.0};
  Vec4 low, high;
  for (size_t a = 0; a < 4; ++a) low[a] = -axes.slack[a], high[a] = axes.end[a] + axes.slack[a];
  if (!clip) low.fill(-infinity), high.fill(infinity);
  size_t misses = 0;
  for (size_t i = 0; i < count; ++i) {
    if (i + ahead < count) hwy::Prefetch(points + at[i + ahead]);
    const double* p = points[at[i]].data();
    bool in = true;
    for (size_t k = 0; k < 4; k += hn::Lanes(d)) {
      const auto v = hn::LoadU(d, p + k), taken = hn::LoadU(d, take.data() + k);
      const auto within =
          hn::And(hn::Ge(v, hn::LoadU(d, low.data() + k)), hn::Le(v, hn::LoadU(d, high.data() + k)));
      in = in && hn::AllTrue(d, hn::Or(within, hn::Eq(taken, hn::Zero(d))));
      const auto placed =
          hn::MulAdd(v, hn::LoadU(d, axes.scale.data() + k), hn::LoadU(d, axes.shift.data() + k));
      hn::StoreU(placed, d, scaled[i].data() + k);
    }
    const bool miss = clip && !in;
    outside[i] = miss;
    if (!miss) continue;
    scaled[i] = {};
    ++misses;
  }
  return misses;
}

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {
HWY_EXPORT(PlacePoints);
HWY_EXPORT(ScalePoints);

PointAxes::PointAxes(const Lattice4& lattice, size_t points) {
  const Vec3 unit = lattice.lattice_unit();
  for (size_t a = 0; a < 4; ++a) end[a] = lattice.domain_end(a), slack[a] = domain_tolerance(end[a]);
  const Vec3 first = lattice.first_sample();
  for (size_t a = 0; a < 3; ++a) scale[a] = 1 / unit[a], shift[a] = first[a];
  scale[3] = kernel_time_per_frame(lattice);
  if (lattice.is_static())
    end[3] = std::numeric_limits<double>::infinity();
  else
    per_layer = 1 / lattice.time_step;
  // Cells are half a brick wide, so that the sites around one stay in the fastest cache, or a brick where
  // that would be too many for so few points.
  for (const int sites : {brick_edge / 2, brick_edge}) {
    const double planes = sites * (lattice.space.bcc ? 2 : 1);
    for (size_t a = 0; a < 3; ++a) {
      per_cell[a] = 1 / (planes * lattice.space_step[a]);
      cells[a] = 1 + static_cast<int32_t>(end[a] * per_cell[a]);
    }
    const int64_t n = int64_t{cells[0]} * cells[1] * cells[2];
    cell_count = n <= INT32_MAX ? static_cast<uint32_t>(n) : 1;
    if (n * lattice.layers() < static_cast<int64_t>(points)) break;
  }
}

void PointAxes::place(std::span<const Vec4> points, bool clip, std::span<PointPlace> places) const {
  HWY_DYNAMIC_DISPATCH(PlacePoints)(*this, points.data(), points.size(), clip, places.data());
}

size_t PointAxes::scale_points(const Vec4* points, std::span<const uint64_t> at, bool clip, Vec4* scaled,
                               uint8_t* outside) const {
  return HWY_DYNAMIC_DISPATCH(ScalePoints)(*this, points, at.data(), at.size(), clip, scaled, outside);
}

} // namespace bccsplat
#endif

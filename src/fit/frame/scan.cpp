// SPDX-License-Identifier: Apache-2.0
// Scans the boxes of a frame row by row for ranges of cells and for values that are not finite.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fit/frame/scan.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <algorithm>
#include <atomic>
#include <cfloat>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "base/sizes.h"
#include "fit/frame/scan.h"
#include "fit/frame/unpack.h"

#ifndef BCCSPLAT_FIT_SCAN_LANES
#define BCCSPLAT_FIT_SCAN_LANES
namespace bccsplat {
// Sixteen of everything, so that the compiler keeps them in vectors.
struct ScanLanes {
  float low[16], high[16];
  void clear() {
    for (float& v : low) v = std::numeric_limits<float>::infinity();
    for (float& v : high) v = -std::numeric_limits<float>::infinity();
  }
};
struct ScanSums {
  ScanLanes absolute;
  uint32_t relevant[16]{}, nonfinite[16]{};
};
} // namespace bccsplat
#endif

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace {

HWY_INLINE void ScanSample(float value, float air, float threshold, size_t lane, ScanLanes& cell,
                           ScanSums& sums) {
  const float v = value - air;
  const bool finite = std::fabs(v) <= FLT_MAX;
  cell.low[lane] = finite && v < cell.low[lane] ? v : cell.low[lane];
  cell.high[lane] = finite && v > cell.high[lane] ? v : cell.high[lane];
  sums.absolute.low[lane] = finite && value < sums.absolute.low[lane] ? value : sums.absolute.low[lane];
  sums.absolute.high[lane] = finite && value > sums.absolute.high[lane] ? value : sums.absolute.high[lane];
  sums.relevant[lane] += finite && std::fabs(v) > threshold ? 1u : 0u;
  sums.nonfinite[lane] += finite ? 0u : 1u;
}

// A row that begins at sample `phase` of the first cell. Returns how many of its samples are not finite.
uint32_t ScanRow(const float* HWY_RESTRICT row, size_t count, size_t phase, float air, float threshold,
                 ScanLanes* HWY_RESTRICT cells, ScanSums& HWY_RESTRICT sums) {
  ScanSums local = sums;
  size_t x = 0;
  const auto singly = [&](size_t end) {
    for (; x < end; ++x) ScanSample(row[x], air, threshold, (x + phase) % 16, cells[(x + phase) / 16], local);
  };
  singly(count < (16 - phase) % 16 ? count : (16 - phase) % 16);
  for (; x + 16 <= count; x += 16) {
    ScanLanes& cell = cells[(x + phase) / 16];
    for (size_t i = 0; i < 16; ++i) ScanSample(row[x + i], air, threshold, i, cell, local);
  }
  singly(count);
  uint32_t nonfinite = 0;
  for (size_t i = 0; i < 16; ++i) nonfinite += local.nonfinite[i] - sums.nonfinite[i];
  sums = local;
  return nonfinite;
}

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {
HWY_EXPORT(ScanRow);

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

// The rows of one box in one row of cells, as far as they lie in a region.
struct ScanJob {
  uint32_t box;
  int64_t cy, cz;
  const Region* within;
};

struct ScanPart {
  uint64_t relevant = 0, nonfinite = 0, samples = 0;
  double low = infinity, high = -infinity;
  std::array<int64_t, 3> first_nonfinite{INT64_MAX, INT64_MAX, INT64_MAX};
  Region nonfinite_region{{INT64_MAX, INT64_MAX, INT64_MAX}, {INT64_MIN, INT64_MIN, INT64_MIN}};

  void add_region(const Region& region) { // INT64_MAX .. INT64_MIN where there is none
    for (size_t a = 0; a < 3; ++a) {
      nonfinite_region.begin[a] = std::min(nonfinite_region.begin[a], region.begin[a]);
      nonfinite_region.end[a] = std::max(nonfinite_region.end[a], region.end[a]);
    }
  }
  void add_nonfinite(const std::array<int64_t, 3>& p) {
    const auto key = [](const std::array<int64_t, 3>& q) { return std::array{q[2], q[1], q[0]}; };
    if (key(p) < key(first_nonfinite)) first_nonfinite = p;
    add_region({p, {p[0] + 1, p[1] + 1, p[2] + 1}});
  }
};

// Boxes may share a cell, and threads a box.
void widen(CellRanges::Cell& cell, float low, float high) {
  std::atomic_ref a(cell.low), b(cell.high);
  float old = a.load(std::memory_order_relaxed);
  while (low < old && !a.compare_exchange_weak(old, low, std::memory_order_relaxed)) {
  }
  old = b.load(std::memory_order_relaxed);
  while (high > old && !b.compare_exchange_weak(old, high, std::memory_order_relaxed)) {
  }
}

void scan_job(const Frame& frame, const ScanJob& job, float threshold, CellRanges& cells,
              std::vector<uint32_t>& covered, ScanPart& part) {
  const FrameBox& box = frame.boxes()[job.box];
  const auto& edge = CellRanges::edge;
  Region rows;
  for (size_t a = 1; a < 3; ++a) {
    rows.begin[a] = (a == 1 ? job.cy : job.cz) * edge[a];
    rows.end[a] = rows.begin[a] + edge[a];
  }
  rows.begin[0] = 0;
  rows.end[0] = INT64_MAX;
  rows = rows.cut(*job.within);
  // Float types are compared as they are; the others relative to air, in double.
  const bool wide = wider_than_float(box.type);
  const double unpack_air = wide ? frame.air() : 0;
  const float scan_air = wide ? 0 : static_cast<float>(frame.air());

  const int64_t first_cell = rows.begin[0] / edge[0];
  const size_t width = rows.length(0), phase = rows.begin[0] % edge[0];
  std::vector<float> row(width);
  std::vector<ScanLanes> lanes((width + phase + 15) / 16);
  for (ScanLanes& l : lanes) l.clear();
  std::vector<uint8_t> broken(lanes.size(), 0);
  ScanSums sums;
  sums.absolute.clear();
  for (int64_t z = rows.begin[2]; z < rows.end[2]; ++z)
    for (int64_t y = rows.begin[1]; y < rows.end[1]; ++y) {
      unpack_row(box.type, frame.sample(box, rows.begin[0], y, z), box.stride[0], width, unpack_air,
                 row.data());
      if (HWY_DYNAMIC_DISPATCH(ScanRow)(row.data(), width, phase, scan_air, threshold, lanes.data(), sums) ==
          0)
        continue;
      for (size_t x = 0; x < width; ++x)
        if (!std::isfinite(row[x] - scan_air)) {
          part.add_nonfinite({rows.begin[0] + static_cast<int64_t>(x), y, z});
          broken[(x + phase) / 16] = 1;
        }
    }
  for (size_t c = 0; c < lanes.size(); ++c) {
    const size_t cell = cells.index(first_cell + static_cast<int64_t>(c), job.cy, job.cz);
    widen(cells.cell[cell], *std::min_element(lanes[c].low, lanes[c].low + 16),
          *std::max_element(lanes[c].high, lanes[c].high + 16));
    if (broken[c]) std::atomic_ref(cells.cell[cell].broken).store(true, std::memory_order_relaxed);
    const size_t begin = std::max(16 * c, phase), end = std::min(16 * c + 16, phase + width);
    std::atomic_ref(covered[cell])
        .fetch_add(static_cast<uint32_t>(end - begin) *
                       static_cast<uint32_t>(rows.length(1) * rows.length(2)),
                   std::memory_order_relaxed);
  }
  for (size_t i = 0; i < 16; ++i) {
    part.relevant += sums.relevant[i];
    part.nonfinite += sums.nonfinite[i];
    const double base = wide ? frame.air() : 0;
    part.low = std::min(part.low, base + sums.absolute.low[i]);
    part.high = std::max(part.high, base + sums.absolute.high[i]);
  }
  part.samples += rows.samples();
}

} // namespace

CellRanges::CellRanges(const std::array<int64_t, 3>& dims) {
  for (size_t a = 0; a < 3; ++a) count_[a] = (dims[a] + edge[a] - 1) / edge[a];
  cell.resize(count_[0] * count_[1] * count_[2]);
}

Region whole_cells(const Region& region, const std::array<int64_t, 3>& n) {
  Region cells;
  for (size_t a = 0; a < 3; ++a) {
    const int64_t edge = CellRanges::edge[a];
    cells.begin[a] = region.begin[a] / edge * edge;
    cells.end[a] = std::min(n[a], (region.end[a] + edge - 1) / edge * edge);
  }
  return cells;
}

CellRanges::Cell CellRanges::range(const Region& region) const {
  Cell r;
  for (int64_t z = region.begin[2] / edge[2]; z <= (region.end[2] - 1) / edge[2]; ++z)
    for (int64_t y = region.begin[1] / edge[1]; y <= (region.end[1] - 1) / edge[1]; ++y)
      for (int64_t x = region.begin[0] / edge[0]; x <= (region.end[0] - 1) / edge[0]; ++x) {
        const Cell& c = cell[index(x, y, z)];
        r.low = std::min(r.low, c.low);
        r.high = std::max(r.high, c.high);
        r.broken = r.broken || c.broken;
      }
  return r;
}

namespace {

// What is given of a box, or a part of that.
struct ScanPiece {
  uint32_t box;
  Region region;
};

// Appends what a region has outside a part of it: up to six boxes.
void add_around(const Region& part, Region region, uint32_t box, std::vector<ScanPiece>& pieces) {
  const auto add = [&](const Region& r) {
    if (!r.empty()) pieces.push_back({box, r});
  };
  if (part.empty()) return add(region);
  for (size_t i = 3; i > 0; --i) {
    const size_t a = i - 1;
    Region before = region, behind = region;
    before.end[a] = part.begin[a], behind.begin[a] = part.end[a];
    add(before), add(behind);
    region.begin[a] = part.begin[a], region.end[a] = part.end[a];
  }
}

void add_jobs(const std::vector<ScanPiece>& pieces, std::vector<ScanJob>& jobs) {
  const auto& edge = CellRanges::edge;
  for (const ScanPiece& p : pieces) {
    const Region& r = p.region;
    for (int64_t cz = r.begin[2] / edge[2]; cz <= (r.end[2] - 1) / edge[2]; ++cz)
      for (int64_t cy = r.begin[1] / edge[1]; cy <= (r.end[1] - 1) / edge[1]; ++cy)
        jobs.push_back({p.box, cy, cz, &p.region});
  }
}

// What no box covers is air.
void widen_uncovered(const std::array<int64_t, 3>& n, const std::vector<uint32_t>& covered,
                     CellRanges& cells) {
  for (int64_t z = 0; z < cells.count()[2]; ++z)
    for (int64_t y = 0; y < cells.count()[1]; ++y)
      for (int64_t x = 0; x < cells.count()[0]; ++x) {
        const std::array<int64_t, 3> c{x, y, z};
        uint32_t volume = 1;
        for (size_t a = 0; a < 3; ++a)
          volume *= static_cast<uint32_t>(std::min(CellRanges::edge[a], n[a] - c[a] * CellRanges::edge[a]));
        if (covered[cells.index(x, y, z)] < volume) widen(cells.cell[cells.index(x, y, z)], 0, 0);
      }
}

} // namespace

FrameScan scan_frame(const Frame& frame, float threshold, const Context& context, const Region* counted) {
  FrameScan scan;
  const auto cells = [&](size_t axis) {
    return static_cast<uint64_t>((frame.dims()[axis] + CellRanges::edge[axis] - 1) / CellRanges::edge[axis]);
  };
  const uint64_t cell_bytes = sizeof(CellRanges::Cell) + sizeof(uint32_t);
  scan.memory = Reservation(context.memory, checked_product({cells(0), cells(1), cells(2), cell_bytes}),
                            "the map of a frame");
  scan.cells = CellRanges(frame.dims());
  std::vector<uint32_t> covered(scan.cells.cell.size(), 0);
  const Region own = counted ? *counted : frame.given();
  std::vector<ScanPiece> inside, around; // of what is counted
  for (uint32_t b = 0; b < frame.boxes().size(); ++b) {
    const Region given = frame.region(frame.boxes()[b]).cut(frame.given()), part = given.cut(own);
    if (given.empty()) continue;
    if (!part.empty()) inside.push_back({b, part});
    add_around(part, given, b, around);
  }
  std::vector<ScanJob> jobs;
  add_jobs(inside, jobs);
  const size_t counted_jobs = jobs.size();
  add_jobs(around, jobs);
  constexpr size_t group = 8; // jobs of a task
  std::vector<ScanPart> parts((jobs.size() + group - 1) / group), uncounted(parts.size());
  context.tasks.parallel_for(parts.size(), [&](uint64_t p) {
    context.progress.check();
    for (size_t j = p * group; j < std::min<size_t>(jobs.size(), p * group + group); ++j)
      scan_job(frame, jobs[j], threshold, scan.cells, covered, j < counted_jobs ? parts[p] : uncounted[p]);
  });

  ScanPart all;
  for (const ScanPart& part : uncounted) all.add_region(part.nonfinite_region);
  for (const ScanPart& part : parts) {
    all.relevant += part.relevant;
    all.nonfinite += part.nonfinite;
    all.samples += part.samples;
    all.low = std::min(all.low, part.low);
    all.high = std::max(all.high, part.high);
    if (part.nonfinite > 0) all.add_nonfinite(part.first_nonfinite);
    all.add_region(part.nonfinite_region);
  }
  widen_uncovered(frame.dims(), covered, scan.cells);
  const uint64_t total = own.samples();
  if (all.samples < total) {
    all.low = std::min(all.low, frame.air());
    all.high = std::max(all.high, frame.air());
  }
  scan.relevant = all.relevant;
  scan.nonfinite = all.nonfinite;
  scan.finite = total - std::min(total, all.nonfinite);
  if (scan.finite > 0) {
    scan.low = all.low;
    scan.high = all.high;
  }
  scan.first_nonfinite = all.first_nonfinite;
  if (all.nonfinite_region.begin[0] < all.nonfinite_region.end[0])
    scan.nonfinite_region = all.nonfinite_region;
  return scan;
}

} // namespace bccsplat
#endif

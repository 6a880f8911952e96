// SPDX-License-Identifier: Apache-2.0
// The loop of cell_column.h through Highway: one body is compiled for every target, and the best is chosen at
// run time.
//
// The smallest and largest corner of every cell are folded row by row of corners; a row is made where a block
// beside it may hold the value by its coefficients alone. When the last corners of a layer of cells are in,
// the ranges are widened by what may lie between corners, and compared with the value.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "rays/cell_column_simd.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "rays/cell_column.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace {

using D = hn::CappedTag<float, stretch_lanes>;
using V = hn::Vec<D>;
constexpr D d;

constexpr int kBlockRows = column_edge / 4;

// The smallest and the largest corners of the cells of a stretch, even and odd ones apart.
struct Corners {
  alignas(64) float low[2][stretch_lanes], high[2][stretch_lanes];
};

struct Stretch {
  Corners cells[2][column_edge]; // two layers under way, rows
  uint32_t active[kBlockRows];   // by layer of blocks: rows of blocks that may hold the value
  alignas(64) float corner[4][2 * stretch_lanes]; // of a row
  // The first corner of each lane row of the stretch behind, where it was made.
  float next[2 * column_edge + 1][2 * column_edge + 1];
  bool known[2 * column_edge + 1][2 * column_edge + 1];
};

// Puts the range of each row's 3 x 3 x 3 sites into `low` and `high`; of rows 1 .. column_sites - 2.
void Widen(const ColumnSites& s, std::ptrdiff_t lane) {
  const auto three = [&](const float* p, std::ptrdiff_t step, bool most) {
    const V a = hn::LoadU(d, p - step), b = hn::LoadU(d, p), c = hn::LoadU(d, p + step);
    return most ? hn::Max(hn::Max(a, b), c) : hn::Min(hn::Min(a, b), c);
  };
  const std::ptrdiff_t n = hn::Lanes(d);
  alignas(64) float along[2][column_sites * stretch_lanes],
      plane[2][column_sites][column_sites * stretch_lanes];
  for (size_t c = 0; c < 2; ++c)
    for (std::ptrdiff_t i = lane; i < lane + stretch_lanes; i += n) {
      for (int w = 0; w < column_sites; ++w) {
        for (int v = 0; v < column_sites; ++v) {
          const float* const p = s.value.data() + s.at(c, v, w) + i;
          hn::StoreU(three(p, 1, false), d, along[0] + v * stretch_lanes);
          hn::StoreU(three(p, 1, true), d, along[1] + v * stretch_lanes);
        }
        for (int v = 1; v < column_sites - 1; ++v) {
          hn::StoreU(three(along[0] + v * stretch_lanes, stretch_lanes, false), d,
                     plane[0][w] + v * stretch_lanes);
          hn::StoreU(three(along[1] + v * stretch_lanes, stretch_lanes, true), d,
                     plane[1][w] + v * stretch_lanes);
        }
      }
      constexpr std::ptrdiff_t next = column_sites * stretch_lanes;
      for (int w = 1; w < column_sites - 1; ++w)
        for (int v = 1; v < column_sites - 1; ++v) {
          const std::ptrdiff_t to = s.at(c, v, w) + i;
          hn::StoreU(three(plane[0][w] + v * stretch_lanes, next, false), d, s.low.data() + to);
          hn::StoreU(three(plane[1][w] + v * stretch_lanes, next, true), d, s.high.data() + to);
        }
    }
}

// The range of the coefficients in reach of the even or odd cells of lanes.
struct Reach {
  V low, high;
};
HWY_INLINE Reach ReachOf(const ColumnSites& s, int y, int z, std::ptrdiff_t lane, int odd) {
  const std::ptrdiff_t even_site = s.at(0, (y + 1) / 2 + 1, (z + 1) / 2 + 1) + lane + odd,
                       odd_site = s.at(1, y / 2 + 1, z / 2 + 1) + lane;
  return {hn::Min(hn::LoadU(d, s.low.data() + even_site), hn::LoadU(d, s.low.data() + odd_site)),
          hn::Max(hn::LoadU(d, s.high.data() + even_site), hn::LoadU(d, s.high.data() + odd_site))};
}

// Returns whether a row of blocks may hold the value in a stretch, lane by lane.
bool RowMayHold(const ColumnArgs& a, int block_y, int block_z, std::ptrdiff_t lane) {
  const V target = hn::Set(d, a.target), more = hn::Set(d, a.site_sum - 1);
  const std::ptrdiff_t n = hn::Lanes(d);
  for (std::ptrdiff_t i = lane; i < lane + stretch_lanes; i += n) {
    Reach all = ReachOf(*a.sites, 4 * block_y, 4 * block_z, i, 0);
    for (int z = 0; z < 4; ++z)
      for (int y = 0; y < 4; ++y)
        for (int odd = 0; odd < 2; ++odd) {
          const Reach r = ReachOf(*a.sites, 4 * block_y + y, 4 * block_z + z, i, odd);
          all = {hn::Min(all.low, r.low), hn::Max(all.high, r.high)};
        }
    const V size = hn::Max(hn::Abs(all.low), hn::Abs(all.high)), slack = hn::Mul(more, size);
    const auto any =
        hn::And(hn::And(hn::Le(hn::Sub(all.low, slack), target), hn::Ge(hn::Add(all.high, slack), target)),
                hn::Gt(size, hn::Zero(d)));
    if (!hn::AllFalse(d, any)) return true;
  }
  return false;
}

// The four corners of each lane: sums of sites. Taps go in pairs, so that sums do not wait for each other.
void SumTaps(const float* sites, const std::vector<CornerTap>& taps, Stretch& t) {
  const std::ptrdiff_t n = hn::Lanes(d);
  const CornerTap* const end = taps.data() + taps.size();
  for (std::ptrdiff_t i = 0; i < stretch_lanes; i += n) {
    V a0 = hn::Zero(d), a1 = a0, a2 = a0, a3 = a0, b0 = a0, b1 = a0, b2 = a0, b3 = a0;
    for (const CornerTap* tap = taps.data(); tap != end; tap += 2) {
      const V p = hn::LoadU(d, sites + tap[0].site[0] + i), q = hn::LoadU(d, sites + tap[0].site[1] + i);
      a0 = hn::MulAdd(hn::Set(d, tap[0].weight[0]), p, a0),
      a1 = hn::MulAdd(hn::Set(d, tap[0].weight[1]), p, a1);
      a2 = hn::MulAdd(hn::Set(d, tap[0].weight[2]), q, a2),
      a3 = hn::MulAdd(hn::Set(d, tap[0].weight[3]), q, a3);
      const V r = hn::LoadU(d, sites + tap[1].site[0] + i), s = hn::LoadU(d, sites + tap[1].site[1] + i);
      b0 = hn::MulAdd(hn::Set(d, tap[1].weight[0]), r, b0),
      b1 = hn::MulAdd(hn::Set(d, tap[1].weight[1]), r, b1);
      b2 = hn::MulAdd(hn::Set(d, tap[1].weight[2]), s, b2),
      b3 = hn::MulAdd(hn::Set(d, tap[1].weight[3]), s, b3);
    }
    hn::StoreU(hn::Add(a0, b0), d, t.corner[0] + i), hn::StoreU(hn::Add(a1, b1), d, t.corner[1] + i);
    hn::StoreU(hn::Add(a2, b2), d, t.corner[2] + i), hn::StoreU(hn::Add(a3, b3), d, t.corner[3] + i);
  }
}

// The first corner of one lane.
float FirstCorner(const float* sites, const std::vector<CornerTap>& taps) {
  float even = 0, odd = 0; // so that no sum waits for the last one
  for (size_t n = 0; n < taps.size(); n += 2) {
    even += taps[n].weight[0] * sites[taps[n].site[0]];
    odd += taps[n + 1].weight[0] * sites[taps[n + 1].site[0]];
  }
  return even + odd;
}

// Makes a row of corners, numbers of half planes from the column's beginning on.
void FillCorners(const ColumnArgs& a, int y, int z, std::ptrdiff_t lane, Stretch& t) {
  const float* const sites = a.sites->value.data() + a.sites->at(0, y / 4 + 1, z / 4 + 1) + lane;
  const std::vector<CornerTap>& taps = a.stencils->at(z, y);
  SumTaps(sites, taps, t);
  t.corner[0][stretch_lanes] = t.known[z][y] ? t.next[z][y] : FirstCorner(sites + stretch_lanes, taps);
  t.next[z][y] = t.corner[0][0], t.known[z][y] = true;
}

// Folds a row of corners into a row of cells that it bounds; `begins`: as its first.
void Fold(const Stretch& t, bool begins, Corners& to) {
  const size_t n = hn::Lanes(d);
  for (size_t i = 0; i < stretch_lanes; i += n) {
    const V c0 = hn::Load(d, t.corner[0] + i), c1 = hn::Load(d, t.corner[1] + i),
            c2 = hn::Load(d, t.corner[2] + i), c3 = hn::Load(d, t.corner[3] + i),
            c4 = hn::LoadU(d, t.corner[0] + i + 1);
    V low[2] = {hn::Min(hn::Min(c0, c1), c2), hn::Min(hn::Min(c2, c3), c4)};
    V high[2] = {hn::Max(hn::Max(c0, c1), c2), hn::Max(hn::Max(c2, c3), c4)};
    for (size_t odd = 0; odd < 2; ++odd) {
      if (!begins) {
        low[odd] = hn::Min(low[odd], hn::Load(d, to.low[odd] + i));
        high[odd] = hn::Max(high[odd], hn::Load(d, to.high[odd] + i));
      }
      hn::Store(low[odd], d, to.low[odd] + i), hn::Store(high[odd], d, to.high[odd] + i);
    }
  }
}

// A bit for each lane's even or odd cell.
uint32_t Compare(const ColumnArgs& a, const Corners& cells, int y, int z, std::ptrdiff_t lane, int odd) {
  const V target = hn::Set(d, a.target), half = hn::Set(d, a.of_range), middle = hn::Set(d, a.of_middle);
  const size_t n = hn::Lanes(d);
  uint32_t bits = 0;
  for (size_t i = 0; i < stretch_lanes; i += n) {
    const Reach r = ReachOf(*a.sites, y, z, lane + static_cast<std::ptrdiff_t>(i), odd);
    const V more = hn::MulAdd(half, hn::Sub(r.high, r.low), hn::Mul(middle, hn::Abs(hn::Add(r.high, r.low))));
    const auto may = hn::And(hn::And(hn::Le(hn::Sub(hn::Load(d, cells.low[odd] + i), more), target),
                                     hn::Ge(hn::Add(hn::Load(d, cells.high[odd] + i), more), target)),
                             hn::Gt(hn::Max(hn::Abs(r.low), hn::Abs(r.high)), hn::Zero(d)));
    uint8_t bytes[8] = {};
    hn::StoreMaskBits(d, may, bytes);
    uint16_t word;
    std::memcpy(&word, bytes, sizeof word);
    bits |= (word & ((uint32_t{1} << n) - 1)) << i;
  }
  return bits;
}

// Puts a zero before each of 16 bits.
HWY_INLINE uint32_t Spread(uint32_t x) {
  x = (x | x << 8) & 0x00ff00ff, x = (x | x << 4) & 0x0f0f0f0f;
  x = (x | x << 2) & 0x33333333, x = (x | x << 1) & 0x55555555;
  return x;
}

// Marks the cells of a layer whose corners are all in.
void MarkLayer(const ColumnArgs& a, int stretch, int z, const Stretch& t) {
  const std::ptrdiff_t lane = std::ptrdiff_t{stretch} * stretch_lanes;
  constexpr int per_stretch = stretch_lanes / 2;
  for (int y = 0; y < a.height; ++y) {
    if ((t.active[z / 4] >> (y / 4) & 1) == 0) continue;
    const Corners& cells = t.cells[z & 1][y];
    const uint32_t bits = Spread(Compare(a, cells, y, z, lane, 0)) | Spread(Compare(a, cells, y, z, lane, 1))
                                                                         << 1;
    if (bits == 0) continue;
    uint64_t* const row = a.bits + z / 4 * a.layer + y / 4 * a.row + stretch * per_stretch;
    for (int b = 0; b < per_stretch && stretch * per_stretch + b < a.blocks; ++b)
      row[b] |= uint64_t{bits >> (4 * b) & 15} << (4 * (y & 3) + 16 * (z & 3));
  }
}

void MarkStretch(const ColumnArgs& a, int stretch, Stretch& t) {
  const std::ptrdiff_t lane = std::ptrdiff_t{stretch} * stretch_lanes;
  for (int z = 0; z <= 2 * a.depth; ++z) {
    // Layers of cells on either side.
    const int before = (z - 1) / 2, behind = z < 2 * a.depth ? z / 2 : before;
    const uint32_t layers = (z > 0 ? t.active[before / 4] : 0) | t.active[behind / 4];
    for (int y = 0; layers != 0 && y <= 2 * a.height; ++y) {
      const int above = (y - 1) / 2, below = y < 2 * a.height ? y / 2 : above;
      if (((y > 0 ? layers >> (above / 4) : 0) | layers >> (below / 4)) % 2 == 0) {
        t.known[z][y] = false;
        continue;
      }
      FillCorners(a, y, z, lane, t);
      for (int l = z > 0 ? before : behind; l <= behind; ++l)
        for (int r = y > 0 ? above : below; r <= below; ++r)
          Fold(t, z == 2 * l && y == 2 * r, t.cells[l & 1][r]);
    }
    if (layers == 0)
      for (int y = 0; y <= 2 * a.height; ++y) t.known[z][y] = false;
    if (z > 0 && z % 2 == 0) MarkLayer(a, stretch, before, t);
  }
}

// Returns whether a field of coefficients in a range may hold the value, give or take the ripple of their
// weights' sum.
bool MayHold(const ColumnArgs& a, float low, float high) {
  const float size = std::max(std::fabs(low), std::fabs(high)), slack = (a.site_sum - 1) * size;
  return size > 0 && low - slack <= a.target && high + slack >= a.target;
}

// Leaves those stretches whose coefficients in reach may hold the value.
void FindStretches(const ColumnArgs& a, std::span<uint8_t> stretches) {
  const ColumnSites& s = *a.sites;
  const size_t count = s.stretches;
  const std::ptrdiff_t n = hn::Lanes(d);
  std::vector<float> low(count + 2, 0.0f), high(count + 2, 0.0f); // of the stretch before
  for (size_t part = 0; part <= count; ++part) {
    const bool before = part > 0 && stretches[part - 1] != 0,
               behind = part < count && stretches[part + 1] != 0;
    if (stretches[part] == 0 && !before && !behind) continue;
    V least = hn::Zero(d), most = hn::Zero(d);
    const float* row = s.value.data() + s.at(0, 0, 0) + static_cast<std::ptrdiff_t>(part) * stretch_lanes;
    for (int r = 0; r < 2 * column_sites * column_sites; ++r, row += s.pitch)
      for (std::ptrdiff_t i = 0; i < stretch_lanes; i += n) {
        const V c = hn::LoadU(d, row + i);
        least = hn::Min(least, c), most = hn::Max(most, c);
      }
    low[part + 1] = hn::GetLane(hn::MinOfLanes(d, least)),
               high[part + 1] = hn::GetLane(hn::MaxOfLanes(d, most));
  }
  for (size_t m = 0; m < count; ++m)
    if (stretches[m] != 0)
      stretches[m] = MayHold(a, std::min({low[m], low[m + 1], low[m + 2]}),
                             std::max({high[m], high[m + 1], high[m + 2]}));
}

void MarkColumn(const ColumnArgs& a) {
  const ColumnSites& s = *a.sites;
  const uint8_t* const may = a.stretches;
  // Ranges are asked for a lane beyond each stretch.
  for (int m = 0; m <= s.stretches; ++m)
    if (may[m] != 0 || (m > 0 && may[m - 1] != 0)) Widen(s, std::ptrdiff_t{m} * stretch_lanes);
  Stretch t;
  std::memset(t.known, 0, sizeof t.known);
  bool fresh = true;
  // From the last on: a stretch needs the first corners of the one behind it.
  for (int stretch = s.stretches; stretch-- > 0;) {
    bool any = false;
    for (int z = 0; may[stretch] != 0 && 4 * z < a.depth; ++z) {
      t.active[z] = 0;
      for (int y = 0; 4 * y < a.height; ++y)
        if (RowMayHold(a, y, z, std::ptrdiff_t{stretch} * stretch_lanes)) t.active[z] |= 1u << y;
      any |= t.active[z] != 0;
    }
    if (any) {
      MarkStretch(a, stretch, t);
      fresh = false;
    } else if (!fresh) {
      std::memset(t.known, 0, sizeof t.known);
      fresh = true;
    }
  }
}

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {
HWY_EXPORT(FindStretches);
HWY_EXPORT(MarkColumn);

void find_stretches(const ColumnArgs& args, std::span<uint8_t> stretches) {
  HWY_DYNAMIC_DISPATCH(FindStretches)(args, stretches);
}
void mark_column(const ColumnArgs& args) { HWY_DYNAMIC_DISPATCH(MarkColumn)(args); }

void ColumnSites::prepare(int stretch_count) {
  set_size(stretch_count);
  const size_t count = floats() + margin;
  value.reserve(count), low.reserve(count), high.reserve(count);
  std::fill_n(value.data(), count, 0.0f);
}

} // namespace bccsplat
#endif

// SPDX-License-Identifier: Apache-2.0
// The gaps between the sheets that points are drawn to: which sheets the points of a gap reach, through which
// windows of pixels, and the constants of both.
#pragma once

#include <cstdint>
#include <vector>

#include "splat/loop/loops.h"
#include "splat/plan/scene.h"

namespace bccsplat {

// The sheets that points are drawn to. As many as one gap reaches are held at a time, in a ring: those of the
// picture, or what these are raised from along their normal.
struct PlannedRing {
  int64_t first_sheet = 0, last_sheet = -1;
  int before = 0, after = 0; // a gap s reaches the sheets s - before .. s + after
  int sheets = 0;            // that are held, a multiple of 4
  int groups = 0;            // of four sheets
  // Around a tile's pixels.
  int spare_columns = 4, spare_rows = 0;
  bool whole_windows = false; // there is room for them: nothing is clipped

  [[nodiscard]] size_t slot(int64_t sheet) const { return ((sheet % sheets) + sheets) % sheets; }
};

// GapLanes of several gaps: set n has the slots n * slots .. n * slots + slots - 1 of every array.
struct LaneSets {
  size_t slots = 0;
  std::vector<float> offset, delta, xx, xy, yy, reach;

  void resize(size_t sets, size_t slots_of_set);
  [[nodiscard]] GapLanes at(size_t set) const;
};

struct PlannedGaps {
  int64_t first = 0, last = -1;
  bool isotropic = false; // orthographic, or a fan, and the sheets' metric is a multiple of the identity
  double depth2 = 0;      // (step / R)^2
  // Orthographic: gaps s and s + lane_period share lanes; 0: every gap has its own.
  int lane_period = 0;
  LaneSets lane_sets;
  std::vector<int16_t> row_ranges; // of the groups of a set, as GapLanes has them; empty: none
  int row_columns = 0;
  std::vector<float> lateral, half_x, half_y; // per gap
  std::vector<int32_t> columns, rows;         // of the window, per gap

  [[nodiscard]] size_t index(int64_t gap) const { return gap - first; }
  // Isotropic windows that are worth a table of rows per four columns.
  [[nodiscard]] bool large_window() const {
    return columns.front() > block_window || rows.front() > block_window;
  }
  [[nodiscard]] GapLanes lanes(int64_t gap, const PlannedRing& ring) const;
  [[nodiscard]] GapTables tables() const {
    return {first, lateral.data(), half_x.data(), half_y.data(), columns.data(), rows.data()};
  }
};

// Plans the gaps that reach the sheets ring.first_sheet .. ring.last_sheet, and sizes the ring for them.
// Points are of use to pixels that are `around` samples away.
void plan_gaps(const SplatScene& scene, int around, PlannedRing& ring, PlannedGaps& gaps);

} // namespace bccsplat

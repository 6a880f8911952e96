// SPDX-License-Identifier: Apache-2.0
// Plans gaps: the size of the ring, the constants of the sheets that each gap reaches, the window of pixels
// that holds what a point of it reaches, and the rows of the window that each group of sheets needs.
#include "splat/plan/plan_gaps.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "splat/plan/plan_bounds.h"
#include "view/sheet_metric.h"

namespace bccsplat {

void LaneSets::resize(size_t sets, size_t slots_of_set) {
  slots = slots_of_set;
  for (auto* lane : {&offset, &delta, &xx, &xy, &yy, &reach}) lane->resize(sets * slots);
}

GapLanes LaneSets::at(size_t set) const {
  const size_t n = set * slots;
  return {.offset = offset.data() + n,
          .delta = delta.data() + n,
          .xx = xx.data() + n,
          .xy = xy.data() + n,
          .yy = yy.data() + n,
          .reach = reach.data() + n};
}

GapLanes PlannedGaps::lanes(int64_t gap, const PlannedRing& ring) const {
  const size_t set = lane_period ? ring.slot(gap) : index(gap);
  GapLanes l = lane_sets.at(set);
  if (row_ranges.empty()) return l;
  const size_t ranges_of_set = static_cast<size_t>(ring.groups * row_columns) * 2;
  (large_window() ? l.row_range : l.group_rows) = row_ranges.data() + set * ranges_of_set;
  l.row_columns = row_columns;
  return l;
}

namespace {

// Windows of more rows have no table of them: its entries are 16 bits wide.
constexpr int most_table_rows = 4096;
// Windows of up to this many pixels a side are not clipped: room around the ring, which is larger for it,
// takes what they would lose. No measurement of the limit is noted.
constexpr int most_unclipped = 8;
// At most 7 columns to the left, 7 and the rest of a vector to the right.
constexpr int spare_columns = 12;
// The offset of a sheet behind the eye, which is out of reach of everything.
constexpr float out_of_reach = 1e6f;

class GapPlanner {
 public:
  GapPlanner(const SplatScene& scene, int around, PlannedRing& ring, PlannedGaps& gaps)
      : view_(*scene.view), radius_(scene.slice->kernel.space.radius), metric_(view_), around_(around),
        ring_(ring), gaps_(gaps) {}

  void plan() {
    size_ring();
    fill_lanes();
    find_windows();
    list_rows();
    spare_room();
  }

 private:
  const SheetView& view_;
  const double radius_;
  const SheetMetric metric_;
  const int around_;
  PlannedRing& ring_;
  PlannedGaps& gaps_;

  // Sheet k as the points of gap s see it.
  struct Seen {
    bool exists;  // in front of the eye
    double scale; // of its pixels
    double delta; // GapLanes::delta
  };
  [[nodiscard]] Seen see(int64_t k, int64_t s) const {
    if (!view_.perspective) return {true, 1, static_cast<double>(k - s)};
    const double scale = static_cast<double>(k) + view_.depth;
    const bool exists = k >= view_.first_sheet();
    return {exists, scale, exists ? 1 / scale - 1 / base_depth(view_, s) : 0};
  }

  void size_ring() {
    const double reach = std::ceil(radius_ / view_.step - 1e-9);
    if (!(2 * reach <= max_ring_sheets))
      fail(Code::invalid_argument, "render: sheet_step ", view_.step, " is below ",
           2 * radius_ / max_ring_sheets);
    ring_.after = static_cast<int>(reach);
    ring_.before = ring_.after - 1;
    ring_.sheets = (2 * ring_.after + 3) / 4 * 4;
    ring_.groups = ring_.sheets / 4;
    gaps_.first = ring_.first_sheet - ring_.after;
    gaps_.last = ring_.last_sheet + ring_.before;
    gaps_.isotropic = isotropic(view_);
    gaps_.depth2 = view_.step * view_.step / (radius_ * radius_);
  }

  void fill_lanes() {
    gaps_.lane_period = view_.perspective ? 0 : ring_.sheets;
    // Orthographic lanes are stored by gap modulo the period: those of the gaps 0 .. period - 1 stand for
    // all.
    const int64_t begin = view_.perspective ? gaps_.first : 0,
                  end = view_.perspective ? gaps_.last + 1 : gaps_.lane_period;
    LaneSets& lanes = gaps_.lane_sets;
    lanes.resize(end - begin, ring_.sheets);
    for (int64_t s = begin; s < end; ++s)
      for (int64_t k = s - ring_.before; k < s - ring_.before + ring_.sheets; ++k) {
        const Seen seen = see(k, s);
        const size_t n = (s - begin) * lanes.slots + ring_.slot(k);
        const double form = seen.scale * seen.scale / (radius_ * radius_);
        lanes.offset[n] = seen.exists ? static_cast<float>(k - s) : out_of_reach;
        lanes.delta[n] = static_cast<float>(seen.delta);
        lanes.xx[n] = seen.exists ? static_cast<float>(metric_.xx * form) : 0;
        lanes.xy[n] = seen.exists ? static_cast<float>(2 * metric_.xy * form) : 0;
        lanes.yy[n] = seen.exists ? static_cast<float>(metric_.yy * form) : 0;
        lanes.reach[n] = seen.exists ? static_cast<float>(metric_.determinant() / metric_.yy * form) : 0;
      }
  }

  void find_windows() {
    const size_t count = gaps_.index(gaps_.last + 1);
    for (auto* table : {&gaps_.lateral, &gaps_.half_x, &gaps_.half_y}) table->resize(count);
    gaps_.columns.resize(count), gaps_.rows.resize(count);
    for (size_t n = 0; n < count; ++n) {
      const int64_t s = gaps_.first + static_cast<int64_t>(n);
      const auto [half_x, half_y] = half_window(s);
      gaps_.lateral[n] =
          static_cast<float>(view_.perspective ? 1 / base_depth(view_, s) : static_cast<double>(n));
      gaps_.half_x[n] = static_cast<float>(half_x), gaps_.half_y[n] = static_cast<float>(half_y);
      gaps_.columns[n] = static_cast<int32_t>(std::clamp(std::ceil(2 * half_x), 1.0, farthest_pixel));
      gaps_.rows[n] = static_cast<int32_t>(std::clamp(std::ceil(2 * half_y), 1.0, farthest_pixel));
    }
  }

  // Half the window of the points of gap s: pixels from a point's foot to the farthest that it reaches on any
  // sheet.
  [[nodiscard]] std::array<double, 2> half_window(int64_t s) const {
    // Extent of a unit ball of this metric along x and y, pixels.
    const double extent_x = std::sqrt(metric_.yy / metric_.determinant()),
                 extent_y = std::sqrt(metric_.xx / metric_.determinant());
    // The farthest pixels from the foot of the eye bound |X| and |Y| of the points that are seen.
    const double foot_x = -dot(view_.gx, view_.ez), foot_y = -dot(view_.gy, view_.ez), halo = 2 + around_;
    const double far_x = std::max(std::fabs(foot_x), std::fabs(view_.width - 1 - foot_x)) + halo,
                 far_y = std::max(std::fabs(foot_y), std::fabs(view_.height - 1 - foot_y)) + halo;
    const auto [drift_x, drift_y] = drift(view_);
    double half_x = 0, half_y = 0;
    for (int64_t k = s - ring_.before; k < s - ring_.before + ring_.sheets; ++k) {
      const Seen seen = see(k, s);
      const double h =
          view_.step * std::max({0.0, static_cast<double>(s - k), static_cast<double>(k - s - 1)});
      if (!seen.exists || h >= radius_) continue;
      const double rho = std::sqrt(radius_ * radius_ - h * h) / seen.scale, shift = std::fabs(seen.delta);
      const double x = rho * extent_x, y = rho * extent_y;
      half_x =
          std::max(half_x, x + shift * (view_.perspective ? (far_x + x) * seen.scale : std::fabs(drift_x)));
      half_y =
          std::max(half_y, y + shift * (view_.perspective ? (far_y + y) * seen.scale : std::fabs(drift_y)));
    }
    return {half_x, half_y};
  }

  // Lists the rows that the sheets of a group reach: in any column where the window is not large, else per
  // four columns. The foot is between half - 1 and half pixels from the window's start.
  void list_rows() {
    if (!gaps_.isotropic || gaps_.rows[0] > most_table_rows) return;
    const double pixels = radius_ / std::sqrt(metric_.xx); // of the kernel's radius
    const double half_x = gaps_.half_x[0], half_y = gaps_.half_y[0];
    const bool by_column = gaps_.large_window();
    gaps_.row_columns = by_column ? (gaps_.columns[0] + 3) / 4 : 1;
    gaps_.row_ranges.resize(static_cast<size_t>(gaps_.lane_period * ring_.groups * gaps_.row_columns) * 2);
    int16_t* range = gaps_.row_ranges.data();
    for (size_t set = 0; set < static_cast<size_t>(gaps_.lane_period); ++set)
      for (int g = 0; g < ring_.groups; ++g) {
        const double near = nearest_sheet(gaps_.lane_sets.at(set).offset + 4 * g);
        for (int n = 0; n < gaps_.row_columns; ++n, range += 2) {
          const double across = by_column ? std::max({0.0, half_x - 1 - (4 * n + 3), 4 * n - half_x}) : 0;
          const double square = pixels * pixels * (1 - gaps_.depth2 * near * near) - across * across;
          if (square <= 0) continue; // none
          const double reach = std::sqrt(square) + 1e-3;
          range[0] = static_cast<int16_t>(std::max(0.0, std::ceil(half_y - 1 - reach)));
          range[1] = static_cast<int16_t>(std::min<double>(gaps_.rows[0], std::floor(half_y + reach) + 1));
        }
      }
  }

  // Returns the sheets between a gap and the nearest sheet of a group.
  [[nodiscard]] static double nearest_sheet(const float* offset) {
    double near = std::numeric_limits<double>::infinity();
    for (int l = 0; l < 4; ++l) {
      const double k = offset[l];
      near = std::min(near, std::max({0.0, -k, k - 1}));
    }
    return near;
  }

  // Small windows get room around the tile's ring: clipping them would cost more than it saves.
  void spare_room() {
    ring_.whole_windows =
        gaps_.isotropic && gaps_.columns[0] <= most_unclipped && gaps_.rows[0] <= most_unclipped;
    if (!ring_.whole_windows) return;
    ring_.spare_columns = spare_columns;
    ring_.spare_rows = gaps_.rows[0];
  }
};

} // namespace

void plan_gaps(const SplatScene& scene, int around, PlannedRing& ring, PlannedGaps& gaps) {
  GapPlanner(scene, around, ring, gaps).plan();
}

} // namespace bccsplat

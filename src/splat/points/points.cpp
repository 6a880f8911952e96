// SPDX-License-Identifier: Apache-2.0
// Makes the points of a slice: finds the bricks that its bricks reach, sums up their sites, then lists the
// points of those that hold any, with the ranges of coefficients around them by which pictures leave bricks
// out.
#include "splat/points/points.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "splat/points/brick_sites.h"
#include "splat/points/cell_ranges.h"
#include "splat/points/corrected_ranges.h"
#include "view/view.h"

namespace bccsplat {
namespace {

constexpr size_t vector_overhang = 16; // vectors read in whole, past the last point

// The grid of bricks, of points that are to be made, and the lattice's planes with the margin on either side.
struct PointGrid {
  SplatPoints points;
  Int3 planes{};
};

PointGrid grid_of(const Slice& slice) {
  PointGrid grid;
  SplatPoints& points = grid.points;
  const Lattice3& lattice = slice.lattice;
  points.plane_distance = lattice.plane_distance();
  const DrawnBox box = drawn_box(slice);
  double beyond = 0; // the outermost planes of the lattice
  for (size_t a = 0; a < 3; ++a) {
    const double outermost = points.plane_distance * lattice.last[a];
    beyond = std::max({beyond, 2 - box.begin[a], 2 - (outermost - box.end[a])});
  }
  points.margin = static_cast<int>(std::ceil((slice.kernel.space.radius + beyond) / points.plane_distance));
  points.margin += points.margin & 1; // even: local planes keep their parity
  points.edge = lattice.bcc ? 16 : 8;
  for (size_t a = 0; a < 3; ++a) {
    grid.planes[a] = lattice.last[a] + 1 + 2 * points.margin;
    points.dims[a] = (grid.planes[a] + points.edge - 1) / points.edge;
  }
  return grid;
}

// Returns the power of two that brings what the field holds below 1; coefficients go somewhat further. Fields
// beyond what floats code well keep `unit`.
float code_unit_of(const Slice& slice, float unit) {
  const double base = slice.base,
               largest = std::max(std::fabs(slice.bounds[0] - base), std::fabs(slice.bounds[1] - base));
  if (!(largest > 1e-30 && largest < 1e30)) return unit;
  return std::ldexp(1.0f, -std::ilogb(largest) - 1);
}

// The sites are read twice: first to see what each brick holds, then to write its points where they belong.
class PointMaker {
 public:
  PointMaker(const Slice& slice, const Context& context)
      : slice_(slice), context_(context), grid_(grid_of(slice)),
        folded_(fold_sites(slice.lattice, points_.margin, grid_.planes)),
        touched_(touched_slots(slice, folded_, points_.dims, points_.edge)), slots_(touched_.list()),
        reader_(slice, folded_) {}

  SplatPoints make() {
    points_.code_unit = code_unit_of(slice_, points_.code_unit);
    summarise_bricks();
    const uint64_t total = number_points();
    make_room(total);
    const SiteOrder order(slice_.lattice.bcc);
    context_.tasks.parallel_for(listed_.size(), [&](uint64_t n) {
      context_.progress.check();
      widen_reach(n);
      write_points(n, order);
    });
    points_.count = static_cast<uint32_t>(total);
    if (slice_.corrections) widen_by_corrections(slice_, points_);
    return std::move(points_);
  }

 private:
  [[nodiscard]] Int3 brick_at(size_t number) const {
    const uint64_t nx = points_.dims[0], ny = points_.dims[1];
    return Int3{static_cast<int>(slots_[number] % nx), static_cast<int>(slots_[number] / nx % ny),
                static_cast<int>(slots_[number] / (nx * ny))};
  }

  void read(size_t number, BrickSites& sites) const {
    const Int3 at = brick_at(number);
    reader_.read({at[0] * points_.edge, at[1] * points_.edge, at[2] * points_.edge}, sites);
  }

  void summarise_bricks() {
    made_.resize(slots_.size());
    cells_.resize(slots_.size());
    context_.tasks.parallel_for(slots_.size(), [&](uint64_t number) {
      context_.progress.check();
      BrickSites sites;
      read(number, sites);
      const Int3 at = brick_at(number);
      for (size_t a = 0; a < 3; ++a) made_[number].plane[a] = at[a] * points_.edge - points_.margin;
      summarise(sites, slice_.lattice.bcc, made_[number], cells_[number]);
    });
  }

  // Lists the bricks that hold points and numbers these; returns how many there are.
  uint64_t number_points() {
    uint64_t total = 0;
    for (size_t number = 0; number < made_.size(); ++number) {
      if (made_[number].count == 0) continue;
      made_[number].first = static_cast<uint32_t>(total);
      total += made_[number].count;
      listed_.push_back(number);
    }
    if (total > UINT32_MAX)
      fail(Code::limit_exceeded, "render: a slice of ", total, " points; at most 2^32 - 1 are drawn");
    return total;
  }

  void make_room(uint64_t total) {
    points_.memory =
        Reservation(context_.memory,
                    total * (sizeof(float) + sizeof(uint16_t)) +
                        listed_.size() * (sizeof(SplatBrick) + 3 * cells_per_brick * sizeof(CellRange) +
                                          SplatPoints::fine_cells),
                    "the points of a slice");
    points_.position.resize(total + vector_overhang);
    points_.coefficient.resize(total + vector_overhang);
    points_.bricks.resize(listed_.size());
    for (auto& range : points_.cells) range.resize(listed_.size() * cells_per_brick);
    points_.codes.resize(listed_.size() * SplatPoints::fine_cells);
  }

  // Sets brick n of those listed, with the range of the coefficients in it and in all bricks around it.
  void widen_reach(size_t n) {
    const Int3 at = brick_at(listed_[n]), &dims = points_.dims;
    SplatBrick& brick = points_.bricks[n] = made_[listed_[n]];
    for (int z = std::max(0, at[2] - 1); z <= std::min(dims[2] - 1, at[2] + 1); ++z)
      for (int y = std::max(0, at[1] - 1); y <= std::min(dims[1] - 1, at[1] + 1); ++y)
        for (int x = std::max(0, at[0] - 1); x <= std::min(dims[0] - 1, at[0] + 1); ++x) {
          const int64_t other = touched_.number((int64_t{z} * dims[1] + y) * dims[0] + x);
          if (other < 0) continue;
          const SplatBrick& beside = made_[other];
          brick.reach[0] = std::min(brick.reach[0], beside.coefficient[0]);
          brick.reach[1] = std::max(brick.reach[1], beside.coefficient[1]);
        }
  }

  void write_points(size_t n, const SiteOrder& order) {
    const SplatBrick& brick = points_.bricks[n];
    BrickSites sites;
    read(listed_[n], sites);
    list_points(sites, order, brick.count, points_.position.data() + brick.first,
                points_.coefficient.data() + brick.first);
    code_cells(sites, slice_.lattice.bcc, points_, points_.codes.data() + n * SplatPoints::fine_cells);
    CellCube cube;
    gather_cells(cells_, touched_, points_.dims, brick_at(listed_[n]), points_.edge / 4, cube);
    WidenedCells widened;
    for (size_t r = 0; r < widened.size(); ++r) widened[r] = points_.cells[r].data() + n * cells_per_brick;
    widen_cells(cube, widened);
  }

  const Slice& slice_;
  const Context& context_;
  PointGrid grid_;
  SplatPoints& points_ = grid_.points;
  const FoldedSites folded_;
  SlotSet touched_;
  const std::vector<uint64_t> slots_;
  const SiteReader reader_;
  std::vector<SplatBrick> made_;  // of all slots
  std::vector<BrickCells> cells_; // the same
  std::vector<size_t> listed_;    // of them, those with points
};

} // namespace

uint8_t SplatPoints::code(float c) const {
  const auto steps = std::bit_cast<int32_t>(std::fabs(c) * code_unit) >> code_shift;
  return static_cast<uint8_t>(std::clamp(steps - static_cast<int32_t>(code_zero), 0, most_code));
}

float SplatPoints::code_begin(int n) const {
  return std::bit_cast<float>((code_zero + n) << code_shift) / code_unit;
}

SplatPoints make_points(const Slice& slice, const Context& context) {
  return PointMaker(slice, context).make();
}

} // namespace bccsplat

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
#include "splat/view/view.h"

namespace bccsplat {
namespace {

constexpr size_t vector_overhang = 16; // vectors read in whole, past the last point

} // namespace

uint8_t SplatPoints::code(float c) const {
  const auto steps = std::bit_cast<int32_t>(std::fabs(c) * code_unit) >> code_shift;
  return static_cast<uint8_t>(std::clamp(steps - static_cast<int32_t>(code_zero), 0, most_code));
}

float SplatPoints::code_begin(int n) const {
  return std::bit_cast<float>((code_zero + static_cast<uint32_t>(n)) << code_shift) / code_unit;
}

SplatPoints make_points(const Slice& slice, const Context& context) {
  SplatPoints points;
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
  Int3 planes;
  for (size_t a = 0; a < 3; ++a) {
    planes[a] = lattice.last[a] + 1 + 2 * points.margin;
    points.dims[a] = (planes[a] + points.edge - 1) / points.edge;
  }

  // The power of two that brings what the field holds below 1; coefficients go somewhat further.
  const double base = static_cast<double>(slice.base),
               largest = std::max(std::fabs(slice.bounds[0] - base), std::fabs(slice.bounds[1] - base));
  if (largest > 1e-30 && largest < 1e30) points.code_unit = std::ldexp(1.0f, -std::ilogb(largest) - 1);

  const FoldedSites folded = fold_sites(lattice, points.margin, planes);
  SlotSet touched = touched_slots(slice, folded, points.dims, points.edge);
  const std::vector<uint64_t> slots = touched.list();
  const auto brick_at = [&](size_t number) {
    const auto nx = static_cast<uint64_t>(points.dims[0]), ny = static_cast<uint64_t>(points.dims[1]);
    return Int3{static_cast<int>(slots[number] % nx), static_cast<int>(slots[number] / nx % ny),
                static_cast<int>(slots[number] / (nx * ny))};
  };
  const SiteReader reader(slice, folded);
  const auto read = [&](size_t number, BrickSites& sites) {
    const Int3 at = brick_at(number);
    reader.read({at[0] * points.edge, at[1] * points.edge, at[2] * points.edge}, sites);
  };

  // The sites are read twice: first to see what each brick holds, then to write its points where they belong.
  std::vector<SplatBrick> made(slots.size());
  std::vector<BrickCells> cells(slots.size());
  context.tasks.parallel_for(slots.size(), [&](uint64_t number) {
    context.progress.check();
    BrickSites sites;
    read(number, sites);
    const Int3 at = brick_at(number);
    for (size_t a = 0; a < 3; ++a) made[number].plane[a] = at[a] * points.edge - points.margin;
    summarise(sites, lattice.bcc, made[number], cells[number]);
  });

  uint64_t total = 0;
  std::vector<size_t> listed; // among made
  for (size_t number = 0; number < made.size(); ++number) {
    if (made[number].count == 0) continue;
    made[number].first = static_cast<uint32_t>(total);
    total += made[number].count;
    listed.push_back(number);
  }
  if (total > UINT32_MAX)
    fail(Code::limit_exceeded, "render: a slice of ", total, " points; at most 2^32 - 1 are drawn");
  points.memory =
      Reservation(context.memory,
                  total * (sizeof(float) + sizeof(uint16_t)) +
                      listed.size() * (sizeof(SplatBrick) + 3 * cells_per_brick * sizeof(CellRange) +
                                       SplatPoints::fine_cells),
                  "the points of a slice");
  points.position.resize(total + vector_overhang);
  points.coefficient.resize(total + vector_overhang);
  points.bricks.resize(listed.size());
  for (auto& range : points.cells) range.resize(listed.size() * cells_per_brick);
  points.codes.resize(listed.size() * SplatPoints::fine_cells);
  const SiteOrder order(lattice.bcc);
  context.tasks.parallel_for(listed.size(), [&](uint64_t n) {
    context.progress.check();
    const size_t number = listed[n];
    const Int3 at = brick_at(number);
    SplatBrick& brick = points.bricks[n] = made[number];
    for (int z = std::max(0, at[2] - 1); z <= std::min(points.dims[2] - 1, at[2] + 1); ++z)
      for (int y = std::max(0, at[1] - 1); y <= std::min(points.dims[1] - 1, at[1] + 1); ++y)
        for (int x = std::max(0, at[0] - 1); x <= std::min(points.dims[0] - 1, at[0] + 1); ++x) {
          const int64_t other =
              touched.number(static_cast<uint64_t>((int64_t{z} * points.dims[1] + y) * points.dims[0] + x));
          if (other < 0) continue;
          const SplatBrick& beside = made[static_cast<size_t>(other)];
          brick.reach[0] = std::min(brick.reach[0], beside.coefficient[0]);
          brick.reach[1] = std::max(brick.reach[1], beside.coefficient[1]);
        }
    BrickSites sites;
    read(number, sites);
    list_points(sites, order, brick.count, points.position.data() + brick.first,
                points.coefficient.data() + brick.first);
    code_cells(sites, lattice.bcc, points, points.codes.data() + n * SplatPoints::fine_cells);
    CellCube cube;
    gather_cells(cells, touched, points.dims, at, points.edge / 4, cube);
    WidenedCells widened;
    for (size_t r = 0; r < widened.size(); ++r) widened[r] = points.cells[r].data() + n * cells_per_brick;
    widen_cells(cube, widened);
  });
  points.count = static_cast<uint32_t>(total);
  if (slice.corrections) widen_by_corrections(slice, points);
  return points;
}

} // namespace bccsplat

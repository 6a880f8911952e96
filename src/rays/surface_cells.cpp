// SPDX-License-Identifier: Apache-2.0
// Cells are looked at again row of blocks by row, column by column.
#include "rays/surface_cells.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <span>
#include <utility>

#include "rays/cell_bound.h"
#include "rays/cell_columns.h"
#include "rays/cell_marker.h"
#include "rays/cell_refine.h"

namespace bccsplat {
namespace {

// A mark is looked at again in less than a tenth of the time of so many rays, so that what each picture
// spends on marks shows in no picture's time (tests/bench/notes/isosurfaces.md).
constexpr uint64_t rays_per_mark = 6;
// The coefficients in reach of a cell of a column, as the cell is seen from its even site.
CellSites sites_of(const ColumnSites& sites, const Int3& cell) {
  CellSites out;
  std::array<std::ptrdiff_t, 3> step{1, sites.pitch, column_sites * sites.pitch};
  for (size_t a = 0; a < 3; ++a)
    if ((cell[a] & 1) != 0) step[a] = -step[a];
  float* to = out.data();
  for (size_t c = 0; c < 2; ++c) {
    const auto near = [&](size_t a) { return (cell[a] + (c == 0 ? 1 : 0)) / 2; };
    const float* const centre = sites.value.data() + sites.at(c, near(1) + 1, near(2) + 1) + near(0);
    for (int w = -1; w <= 1; ++w)
      for (int v = -1; v <= 1; ++v) {
        const float* const row = centre + w * step[2] + v * step[1];
        for (int u = -1; u <= 1; ++u) *to++ = row[u * step[0]];
      }
  }
  return out;
}

// Returns what is left of a block of a column.
uint64_t refine_block(const RefineArgs& args, const ColumnSites& sites, const Int3& block, uint64_t marks) {
  std::array<CellSites, 64> cells;
  std::array<int, 64> bits;
  size_t count = 0;
  for (uint64_t rest = marks; rest != 0; rest &= rest - 1) {
    const int bit = std::countr_zero(rest);
    bits[count] = bit;
    cells[count++] =
        sites_of(sites, {block_edge * block[0] + (bit & 3), block_edge * block[1] + (bit >> 2 & 3),
                         block_edge * block[2] + (bit >> 4)});
  }
  const uint64_t may = cells_that_may_hold(args, std::span(cells).first(count));
  uint64_t left = 0;
  for (size_t n = 0; n < count; ++n) left |= (may >> n & 1) << bits[n];
  return left;
}

constexpr uint64_t column_rows = column_blocks * column_blocks; // of blocks

int columns_along(const SurfaceCells& cells, size_t axis) {
  return (cells.cells[axis] + column_edge - 1) / column_edge;
}

// The blocks of a row, counted column by column; none where the column is cut off before it.
std::span<uint64_t> row_bits(SurfaceCells& cells, uint64_t row) {
  const auto column = static_cast<int>(row / column_rows), in_column = static_cast<int>(row % column_rows),
             in_row = columns_along(cells, 1);
  const int y = column % in_row * column_blocks + in_column % column_blocks,
            z = column / in_row * column_blocks + in_column / column_blocks;
  if (y >= cells.blocks[1] || z >= cells.blocks[2]) return {};
  return std::span(cells.bits).subspan(cells.at({0, y, z}), cells.blocks[0]);
}

uint64_t marks_of(std::span<const uint64_t> bits) {
  uint64_t sum = 0;
  for (const uint64_t word : bits) sum += std::popcount(word);
  return sum;
}

uint64_t waiting_of(const SurfaceCells& cells) {
  return std::count(cells.state.begin(), cells.state.end(), SurfaceCells::waiting);
}

} // namespace

uint64_t SurfaceCells::count() const { return marks_of(bits); }

bool SurfaceCells::any_marked(const Int3& stretch) const {
  const std::array<int, 3> edge{stretch_blocks, column_blocks, column_blocks};
  Int3 begin, end;
  for (size_t a = 0; a < 3; ++a)
    begin[a] = stretch[a] * edge[a], end[a] = std::min(begin[a] + edge[a], blocks[a]);
  for (int z = begin[2]; z < end[2]; ++z)
    for (int y = begin[1]; y < end[1]; ++y)
      for (int x = begin[0]; x < end[0]; ++x)
        if (bits[at({x, y, z})] != 0) return true;
  return false;
}

SurfaceCells mark_all_cells(const Slice& slice, const Context& context) {
  SurfaceCells cells = unmarked_cells(slice, context);
  std::fill(cells.bits.begin(), cells.bits.end(), ~uint64_t{0});
  return cells;
}

uint64_t row_count(const SurfaceCells& cells) {
  return column_rows * columns_along(cells, 1) * columns_along(cells, 2);
}

uint64_t refine_rows(const Slice& slice, double target, SurfaceCells& cells, uint64_t& row, uint64_t marks,
                     const Context& context) {
  const uint64_t begin = row, rows = row_count(cells);
  uint64_t end = begin, looked_at = 0;
  for (; end < rows; ++end) {
    const uint64_t more = marks_of(row_bits(cells, end));
    if (more > marks - looked_at) break;
    looked_at += more;
  }
  if (looked_at > 0) {
    const CellBound bound = margins_of(slice, refined_parts);
    const RefinedStencil stencil(slice.kernel.space);
    const RefineArgs args{&stencil, static_cast<float>(target), static_cast<float>(bound.of_range),
                          static_cast<float>(bound.of_middle)};
    CellColumns columns(slice, cells.cells, context);
    const uint64_t first_column = begin / column_rows;
    context.tasks.parallel_for((end + column_rows - 1) / column_rows - first_column, [&](uint64_t n) {
      const uint64_t column = first_column + n, first = column_rows * column;
      const auto at = static_cast<int>(column), in_row = columns_along(cells, 1);
      columns.read(at % in_row, at / in_row, 0, columns.count()[0] - 1, [&](CellColumns::Memory& memory) {
        for (uint64_t r = std::max(begin, first); r < std::min(end, first + column_rows); ++r) {
          context.progress.check();
          const auto in_column = static_cast<int>(r - first);
          int block = 0;
          for (uint64_t& word : row_bits(cells, r)) {
            const Int3 block_at{block++, in_column % column_blocks, in_column / column_blocks};
            if (word != 0) word = refine_block(args, memory.sites, block_at, word);
          }
        }
      });
    });
  }
  row = end;
  return looked_at;
}

void refine_cells(const Slice& slice, double target, SurfaceCells& cells, const Context& context) {
  uint64_t row = 0;
  (void)refine_rows(slice, target, cells, row, ~uint64_t{0}, context);
}

std::shared_ptr<SurfaceCells> KeptSurfaceCells::find(const Slice& slice, double target,
                                                     const Context& context, uint64_t rays) {
  const auto is = [&](const Kept& k) { return k.slice == &slice && k.target == target && k.cells; };
  if (is(kept_[1])) std::swap(kept_[0], kept_[1]);
  Kept& kept = kept_[0];
  if (!is(kept)) {
    // The older one gives its memory back first.
    kept_[1] = std::exchange(kept, {});
    kept = {&slice, target, std::make_shared<SurfaceCells>(cells_for_rays(slice, target, rays, context))};
  } else {
    // Where rays came to more cells than the last time, these are looked at, too.
    const uint64_t waiting = waiting_of(*kept.cells);
    if (kept.row == row_count(*kept.cells) && waiting < kept.waiting) kept.row = 0;
    if (kept.row == 0) kept.waiting = waiting;
    if (waiting == 0) kept.cells->state.clear();
    kept.rays -=
        rays_per_mark * refine_rows(slice, target, *kept.cells, kept.row, kept.rays / rays_per_mark, context);
  }
  kept.rays += rays;
  return kept.cells;
}

} // namespace bccsplat

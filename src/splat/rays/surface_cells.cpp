// SPDX-License-Identifier: Apache-2.0
// Cuts the plane grid into columns of 16 x 16 cells along x, reads the coefficients that each depends on, and
// has the loop of cell_column.h mark its cells.
#include "splat/rays/surface_cells.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <mutex>
#include <optional>
#include <span>
#include <utility>

#include "base/error.h"
#include "splat/rays/cell_bound.h"
#include "splat/rays/cell_column.h"
#include "splat/rays/cell_refine.h"

namespace bccsplat {
namespace {

// What sums of floats are off by at most, of the largest coefficient in reach: here and where rays sample.
constexpr double rounding = 4e-6;
// A mark is looked at again in less than a tenth of the time of so many rays, so that what each picture
// spends on marks shows in no picture's time (tests/bench/notes/isosurfaces.md).
constexpr uint64_t rays_per_mark = 6;
// A little more than any kernel's ripple makes of a constant.
constexpr float site_sum = 1.02f;

// The sites in reach of two corners half a plane apart, `first` being planes from a lane's site.
std::vector<CornerTap> pair_taps(const RadialKernel& kernel, const ColumnSites& sites, const Vec3& first) {
  constexpr int reach = 4; // sites of a coset
  const double square = kernel.radius * kernel.radius;
  std::vector<CornerTap> taps;
  for (size_t c = 0; c < 2; ++c)
    for (int w = -reach; w <= reach; ++w)
      for (int v = -reach; v <= reach; ++v)
        for (int u = -reach; u <= reach; ++u) {
          CornerTap tap;
          tap.site[0] = sites.at(c, v, w) - sites.at(0, 0, 0) + u;
          bool any = false;
          for (size_t n = 0; n < 2; ++n) {
            const auto coset = static_cast<double>(c);
            const Vec3 site{2.0 * u + coset, 2.0 * v + coset, 2.0 * w + coset};
            const Vec3 to = site - first - Vec3{0.5 * static_cast<double>(n), 0, 0};
            const double r2 = 0.5 * dot(to, to);
            if (r2 >= square) continue;
            tap.weight[n] = static_cast<float>(kernel.value(r2));
            any = true;
          }
          if (any) taps.push_back(tap);
        }
  return taps;
}

CornerStencils make_stencils(const RadialKernel& kernel, const ColumnSites& sites) {
  CornerStencils s;
  for (size_t z = 0; z < corner_phases; ++z)
    for (size_t y = 0; y < corner_phases; ++y) {
      const double at_y = 0.5 * static_cast<double>(y), at_z = 0.5 * static_cast<double>(z);
      const auto first = pair_taps(kernel, sites, {0, at_y, at_z}),
                 second = pair_taps(kernel, sites, {1, at_y, at_z});
      auto& taps = s.all[z * corner_phases + y];
      taps.resize((std::max(first.size(), second.size()) + 1) / 2 * 2); // what is left weighs nothing
      for (size_t n = 0; n < first.size(); ++n) {
        taps[n].site[0] = first[n].site[0];
        taps[n].weight[0] = first[n].weight[0], taps[n].weight[1] = first[n].weight[1];
      }
      for (size_t n = 0; n < second.size(); ++n) {
        taps[n].site[1] = second[n].site[0];
        taps[n].weight[2] = second[n].weight[0], taps[n].weight[3] = second[n].weight[1];
      }
    }
  return s;
}

// Reads the coefficients of columns.
class ColumnReader {
 public:
  ColumnReader(const Slice& slice, int stretches) : slice_(slice), stretches_(stretches) {
    for (size_t c = 0; c < 2; ++c) {
      const int count = slice.coset[c].dims()[0];
      for (int i = 1; i <= beyond; ++i) {
        ends_[c].push_back({-i, slice.lattice.mirror(0, static_cast<int>(c), -i)});
        ends_[c].push_back({count - 1 + i, slice.lattice.mirror(0, static_cast<int>(c), count - 1 + i)});
      }
    }
  }

  // Fills the sites of the column at (y, z), columns, in the stretches that have any brick in reach and
  // beside these, and says which they are; returns false where there is none.
  bool read(int y, int z, ColumnSites& sites, std::vector<uint8_t>& present) const {
    std::array<std::array<std::array<int, column_sites>, 2>, 2> at; // by coset and axis
    for (int c = 0; c < 2; ++c)
      for (int v = 0; v < column_sites; ++v) {
        auto& of = at[c];
        of[0][v] = slice_.lattice.mirror(1, c, column_edge / 2 * y - 1 + v);
        of[1][v] = slice_.lattice.mirror(2, c, column_edge / 2 * z - 1 + v);
      }
    present.assign(static_cast<size_t>(stretches_) + 2, 0);
    for (size_t c = 0; c < 2; ++c) find_bricks(slice_.coset[c], at[c], present);
    if (std::find(present.begin(), present.end(), 1) == present.end()) return false;
    spread(present);
    std::vector<uint8_t> filled = present;
    spread(filled);
    for (size_t c = 0; c < 2; ++c)
      for (int w = 0; w < column_sites; ++w)
        for (int v = 0; v < column_sites; ++v)
          read_row(c, at[c][0][v], at[c][1][w], sites.value.data() + sites.at(c, v, w), filled);
    return true;
  }

 private:
  static constexpr int beyond = 4; // sites that stretches look at

  // Marks the stretches that a brick of the column's rows is in.
  static void find_bricks(const BrickLayer& layer, const std::array<std::array<int, column_sites>, 2>& at,
                          std::vector<uint8_t>& present) {
    int last = -1;
    for (const int k : at[1])
      for (const int j : at[0]) {
        const int place = k / brick_edge * layer.brick_dims()[1] + j / brick_edge;
        if (place == last) continue;
        last = place;
        const size_t slot = layer.slot(0, j / brick_edge, k / brick_edge);
        for (size_t b = 0; b < layer.row_slots(); ++b)
          if (layer.brick(slot + b)) present[b] = 1;
      }
  }
  // Marks what is beside the stretches that are marked, too.
  static void spread(std::vector<uint8_t>& stretches) {
    uint8_t before = 0;
    for (size_t s = 0; s < stretches.size(); ++s) {
      const uint8_t here = stretches[s];
      const uint8_t behind = s + 1 < stretches.size() ? stretches[s + 1] : uint8_t{0};
      stretches[s] = before | here | behind;
      before = here;
    }
  }

  void read_row(size_t c, int j, int k, float* to, const std::vector<uint8_t>& filled) const {
    const BrickLayer& layer = slice_.coset[c];
    const size_t slot = layer.slot(0, j / brick_edge, k / brick_edge),
                 from = (k % brick_edge * brick_edge + j % brick_edge) * brick_edge;
    for (size_t b = 0; b < layer.row_slots(); ++b) {
      if (filled[b] == 0) continue;
      float* const part = to + static_cast<std::ptrdiff_t>(b) * brick_edge;
      if (const Brick* const brick = layer.brick(slot + b))
        std::memcpy(part, brick->value.data() + from, brick_edge * sizeof(float));
      else
        std::memset(part, 0, brick_edge * sizeof(float));
    }
    for (const auto& [beyond_end, inside] : ends_[c]) to[beyond_end] = to[inside];
  }

  const Slice& slice_;
  int stretches_;
  std::array<std::vector<std::array<int, 2>>, 2> ends_; // by coset: sites beyond the ends, and their mirrors
};

SurfaceCells empty_cells(const Slice& slice, const Context& context) {
  SurfaceCells cells;
  uint64_t words = 1;
  for (size_t a = 0; a < 3; ++a) {
    cells.cells[a] = slice.lattice.last[a];
    cells.blocks[a] = (cells.cells[a] + block_edge - 1) / block_edge;
    words *= cells.blocks[a];
  }
  cells.memory = Reservation(context.memory, words * sizeof(uint64_t), "the cells of a surface");
  cells.bits.assign(words, 0);
  return cells;
}

// What the columns of one thread work in.
struct ColumnMemory {
  Reservation memory;
  ColumnSites sites;
  std::vector<uint8_t> present;
};

ColumnSites column_shape(const SurfaceCells& cells) {
  const int lanes = cells.cells[0] / 2 + 1;
  ColumnSites shape;
  shape.set_size((lanes + stretch_lanes - 1) / stretch_lanes);
  return shape;
}

int columns_along(const SurfaceCells& cells, size_t axis) {
  return (cells.cells[axis] + column_edge - 1) / column_edge;
}
uint64_t column_count(const SurfaceCells& cells) {
  return static_cast<uint64_t>(columns_along(cells, 1)) * columns_along(cells, 2);
}

// Calls body(memory, y, z) for the columns at (y, z), columns, that have coefficients, with those read; of
// the columns begin .. end - 1, y fastest.
template<class Body>
void each_column(const Slice& slice, const SurfaceCells& cells, uint64_t begin, uint64_t end,
                 const Context& context, const Body& body) {
  const ColumnSites shape = column_shape(cells);
  const ColumnReader reader(slice, shape.stretches);
  std::mutex mutex;
  std::vector<std::unique_ptr<ColumnMemory>> idle;
  context.tasks.parallel_for(end - begin, [&](uint64_t n) {
    context.progress.check();
    std::unique_ptr<ColumnMemory> memory;
    {
      const std::scoped_lock lock(mutex);
      if (!idle.empty()) memory = std::move(idle.back()), idle.pop_back();
    }
    if (!memory) {
      memory = std::make_unique<ColumnMemory>();
      memory->memory = Reservation(context.memory, 3 * shape.floats() * sizeof(float), "a surface's corners");
      memory->sites.prepare(shape.stretches);
    }
    const auto column = static_cast<int>(begin + n), in_row = columns_along(cells, 1);
    const int y = column % in_row, z = column / in_row;
    if (reader.read(y, z, memory->sites, memory->present)) body(*memory, y, z);
    const std::scoped_lock lock(mutex);
    idle.push_back(std::move(memory));
  });
}

constexpr int column_blocks = column_edge / block_edge; // across

// The bits of the first block of a column.
uint64_t* column_bits(SurfaceCells& cells, int y, int z) {
  return cells.bits.data() + cells.at({0, y * column_blocks, z * column_blocks});
}

CellBound bound_of(const Slice& slice, int parts) {
  const std::optional<CellBound> bound = cell_bound(slice.kernel, parts);
  if (!bound) fail(Code::internal, "cells of a surface: kernel ", slice.kernel.name, " has no bound");
  return {0.5 * (bound->of_range + rounding), 0.5 * (bound->of_middle + rounding)};
}

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

} // namespace

uint64_t SurfaceCells::count() const { return marks_of(bits); }

SurfaceCells mark_all_cells(const Slice& slice, const Context& context) {
  SurfaceCells cells = empty_cells(slice, context);
  std::fill(cells.bits.begin(), cells.bits.end(), ~uint64_t{0});
  return cells;
}

SurfaceCells mark_cells(const Slice& slice, double target, const Context& context) {
  const CellBound bound = bound_of(slice, cell_parts);
  SurfaceCells cells = empty_cells(slice, context);
  const CornerStencils stencils = make_stencils(slice.kernel.space, column_shape(cells));
  ColumnArgs args;
  args.stencils = &stencils;
  args.target = static_cast<float>(target);
  args.of_range = static_cast<float>(bound.of_range), args.of_middle = static_cast<float>(bound.of_middle);
  args.site_sum = site_sum;
  args.blocks = cells.blocks[0];
  args.row = cells.blocks[0], args.layer = args.row * cells.blocks[1];
  each_column(slice, cells, 0, column_count(cells), context, [&](ColumnMemory& memory, int y, int z) {
    ColumnArgs column = args;
    column.sites = &memory.sites, column.present = memory.present.data();
    column.height = std::min(column_edge, cells.cells[1] - y * column_edge);
    column.depth = std::min(column_edge, cells.cells[2] - z * column_edge);
    column.bits = column_bits(cells, y, z);
    mark_column(column);
  });
  return cells;
}

uint64_t row_count(const SurfaceCells& cells) { return column_count(cells) * column_rows; }

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
    const CellBound bound = bound_of(slice, refined_parts);
    const RefinedStencil stencil(slice.kernel.space);
    const RefineArgs args{&stencil, static_cast<float>(target), static_cast<float>(bound.of_range),
                          static_cast<float>(bound.of_middle)};
    const auto refine_column = [&](ColumnMemory& memory, int y, int z) {
      const uint64_t first = column_rows * (z * columns_along(cells, 1) + y);
      for (uint64_t n = std::max(begin, first); n < std::min(end, first + column_rows); ++n) {
        context.progress.check();
        const auto in_column = static_cast<int>(n - first);
        int block = 0;
        for (uint64_t& word : row_bits(cells, n)) {
          const Int3 at{block++, in_column % column_blocks, in_column / column_blocks};
          if (word != 0) word = refine_block(args, memory.sites, at, word);
        }
      }
    };
    each_column(slice, cells, begin / column_rows, (end + column_rows - 1) / column_rows, context,
                refine_column);
  }
  row = end;
  return looked_at;
}

void refine_cells(const Slice& slice, double target, SurfaceCells& cells, const Context& context) {
  uint64_t row = 0;
  (void)refine_rows(slice, target, cells, row, ~uint64_t{0}, context);
}

std::shared_ptr<const SurfaceCells> KeptSurfaceCells::find(const Slice& slice, double target,
                                                           const Context& context, uint64_t rays) {
  const auto is = [&](const Kept& k) { return k.slice == &slice && k.target == target && k.cells; };
  if (is(kept_[1])) std::swap(kept_[0], kept_[1]);
  Kept& kept = kept_[0];
  if (!is(kept)) {
    // The older one gives its memory back first.
    kept_[1] = std::exchange(kept, {});
    kept = {&slice, target, std::make_shared<SurfaceCells>(mark_cells(slice, target, context))};
  } else if (kept.row < row_count(*kept.cells)) {
    kept.rays -=
        rays_per_mark * refine_rows(slice, target, *kept.cells, kept.row, kept.rays / rays_per_mark, context);
  }
  kept.rays += rays;
  return kept.cells;
}

} // namespace bccsplat

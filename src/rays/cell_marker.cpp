// SPDX-License-Identifier: Apache-2.0
// The bounds that marks follow from are those of cell_bound.h. A stretch that waits is marked by the thread
// that comes first, under a lock; its state says so to the others, which read the marks without one.
#include "rays/cell_marker.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "base/error.h"
#include "rays/cell_bound.h"

namespace bccsplat {
namespace {

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

// The bits of the first block of a column.
uint64_t* column_bits(SurfaceCells& cells, int y, int z) {
  return cells.bits.data() + cells.at({0, y * column_blocks, z * column_blocks});
}

} // namespace

CellBound margins_of(const Slice& slice, int parts) {
  // What sums of floats are off by at most, of the largest coefficient in reach: here and where rays sample.
  constexpr double rounding = 4e-6;
  const std::optional<CellBound> bound = cell_bound(slice.kernel, parts);
  if (!bound) fail(Code::internal, "cells of a surface: kernel ", slice.kernel.name, " has no bound");
  return {0.5 * (bound->of_range + rounding), 0.5 * (bound->of_middle + rounding)};
}

SurfaceCells unmarked_cells(const Slice& slice, const Context& context) {
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

CellMarker::CellMarker(const Slice& slice, double target, SurfaceCells& cells, const Context& context)
    : cells_(cells), context_(context), columns_(slice, cells.cells, context),
      stencils_(make_stencils(slice.kernel.space, columns_.shape())) {
  const CellBound bound = margins_of(slice, cell_parts);
  args_.stencils = &stencils_;
  args_.target = static_cast<float>(target);
  args_.of_range = static_cast<float>(bound.of_range), args_.of_middle = static_cast<float>(bound.of_middle);
  args_.site_sum = static_cast<float>(largest_site_sum(true));
  args_.blocks = cells.blocks[0];
  args_.row = cells.blocks[0], args_.layer = args_.row * cells.blocks[1];
}

ColumnArgs CellMarker::column_args(CellColumns::Memory& memory, int y, int z) {
  ColumnArgs column = args_;
  column.sites = &memory.sites, column.stretches = memory.stretches.data();
  column.height = std::min(column_edge, cells_.cells[1] - y * column_edge);
  column.depth = std::min(column_edge, cells_.cells[2] - z * column_edge);
  column.bits = column_bits(cells_, y, z);
  return column;
}

// Calls body(y, z) for the columns 0, step, ..., y fastest.
template<class Body> void CellMarker::each_column(uint64_t step, const Body& body) {
  const Int3 count = columns_.count();
  const auto columns = static_cast<uint64_t>(count[1]) * count[2];
  context_.tasks.parallel_for((columns + step - 1) / step, [&](uint64_t n) {
    context_.progress.check();
    const auto column = static_cast<int>(n * step);
    body(column % count[1], column / count[1]);
  });
}

void CellMarker::mark_all() {
  each_column(1, [&](int y, int z) {
    columns_.read(y, z, 0, columns_.count()[0] - 1, [&](CellColumns::Memory& memory) {
      const ColumnArgs column = column_args(memory, y, z);
      find_stretches(column, memory.stretches);
      mark_column(column);
    });
  });
}

uint64_t CellMarker::blocks_to_mark() {
  constexpr uint64_t step = 7;
  std::atomic<uint64_t> stretches{0};
  each_column(step, [&](int y, int z) {
    columns_.read(y, z, 0, columns_.count()[0] - 1, [&](CellColumns::Memory& memory) {
      find_stretches(column_args(memory, y, z), memory.stretches);
      stretches += std::count(memory.stretches.begin(), memory.stretches.end(), 1);
    });
  });
  return step * stretches * stretch_blocks * column_blocks * column_blocks;
}

void CellMarker::let_wait() {
  const Int3 count = columns_.count();
  cells_.stretches = count;
  cells_.state = std::vector<std::atomic<uint8_t>>(static_cast<size_t>(count[0]) * count[1] * count[2]);
  std::fill(cells_.state.begin(), cells_.state.end(), SurfaceCells::empty);
  each_column(1, [&](int y, int z) {
    columns_.read(y, z, 0, count[0] - 1, [&](CellColumns::Memory& memory) {
      find_stretches(column_args(memory, y, z), memory.stretches);
      for (int s = 0; s < count[0]; ++s)
        if (memory.stretches[s] != 0) cells_.state[cells_.stretch_at({s, y, z})] = SurfaceCells::waiting;
    });
  });
}

bool CellMarker::need(const Int3& begin, const Int3& end) {
  bool any = false;
  Int3 at;
  for (at[2] = begin[2] / column_blocks; at[2] * column_blocks < end[2]; ++at[2])
    for (at[1] = begin[1] / column_blocks; at[1] * column_blocks < end[1]; ++at[1])
      for (at[0] = begin[0] / stretch_blocks; at[0] * stretch_blocks < end[0]; ++at[0]) {
        std::atomic<uint8_t>& state = cells_.state[cells_.stretch_at(at)];
        if (state.load(std::memory_order_acquire) == SurfaceCells::waiting) mark_waiting(at, state);
        any |= state.load(std::memory_order_acquire) != SurfaceCells::empty;
      }
  return any;
}

void CellMarker::mark_waiting(const Int3& at, std::atomic<uint8_t>& state) {
  const std::scoped_lock lock(marking_[cells_.stretch_at(at) % marking_.size()]);
  if (state.load(std::memory_order_relaxed) != SurfaceCells::waiting) return;
  context_.progress.check();
  columns_.read(at[1], at[2], at[0], at[0],
                [&](CellColumns::Memory& memory) { mark_column(column_args(memory, at[1], at[2])); });
  state.store(cells_.any_marked(at) ? SurfaceCells::marked_some : SurfaceCells::empty,
              std::memory_order_release);
}

SurfaceCells mark_cells(const Slice& slice, double target, const Context& context) {
  SurfaceCells cells = unmarked_cells(slice, context);
  CellMarker(slice, target, cells, context).mark_all();
  return cells;
}

SurfaceCells cells_for_rays(const Slice& slice, double target, uint64_t rays, const Context& context) {
  // More blocks than this for each ray: most of them would lie behind what the rays hit.
  constexpr uint64_t blocks_of_ray = 2;
  SurfaceCells cells = unmarked_cells(slice, context);
  CellMarker marker(slice, target, cells, context);
  if (rays > 0 && marker.blocks_to_mark() > blocks_of_ray * rays)
    marker.let_wait();
  else
    marker.mark_all();
  return cells;
}

} // namespace bccsplat

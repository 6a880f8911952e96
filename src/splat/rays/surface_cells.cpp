// SPDX-License-Identifier: Apache-2.0
// Cuts the plane grid into columns of 16 x 16 cells along x, reads the coefficients that each depends on, and
// has the loop of cell_column.h mark its cells.
#include "splat/rays/surface_cells.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <mutex>
#include <optional>
#include <utility>

#include "base/error.h"
#include "splat/rays/cell_bound.h"
#include "splat/rays/cell_column.h"

namespace bccsplat {
namespace {

// What sums of floats are off by at most, of the largest coefficient in reach: here and where rays sample.
constexpr double rounding = 4e-6;
// A little more than any kernel's ripple makes of a constant.
constexpr float site_sum = 1.02f;

CornerStencil make_stencil(const RadialKernel& kernel, const ColumnSites& sites, const Vec3& first) {
  constexpr int reach = 4; // sites of a coset
  const double square = kernel.radius * kernel.radius;
  std::array<std::vector<CornerTap>, 3> taps; // of both corners, of either
  for (size_t c = 0; c < 2; ++c)
    for (int w = -reach; w <= reach; ++w)
      for (int v = -reach; v <= reach; ++v)
        for (int u = -reach; u <= reach; ++u) {
          CornerTap tap{sites.at(c, v, w) - sites.at(0, 0, 0) + u, {}};
          std::array<bool, 2> in{};
          for (size_t n = 0; n < 2; ++n) {
            const Vec3 site{2.0 * u, 2.0 * v, 2.0 * w}, half{0.5 * static_cast<double>(n), 0, 0};
            const auto coset = static_cast<double>(c);
            const Vec3 to = site + Vec3{coset, coset, coset} - first - half;
            const double r2 = 0.5 * dot(to, to);
            in[n] = r2 < square;
            if (in[n]) tap.weight[n] = static_cast<float>(kernel.value(r2));
          }
          if (in[0] || in[1]) taps[in[0] && in[1] ? 0 : in[0] ? 1 : 2].push_back(tap);
        }
  CornerStencil s;
  s.both = taps[0].size(), s.first = taps[1].size();
  for (const auto& part : taps) s.taps.insert(s.taps.end(), part.begin(), part.end());
  return s;
}

CornerStencils make_stencils(const RadialKernel& kernel, const ColumnSites& sites) {
  CornerStencils s;
  auto to = s.all.begin();
  for (size_t z = 0; z < corner_phases; ++z)
    for (size_t y = 0; y < corner_phases; ++y)
      for (const double x : {0.0, 1.0})
        *to++ = make_stencil(kernel, sites, {x, 0.5 * static_cast<double>(y), 0.5 * static_cast<double>(z)});
  return s;
}

// Reads the coefficients of columns.
class ColumnReader {
 public:
  ColumnReader(const Slice& slice, int stretches) : slice_(slice), stretches_(stretches) {}

  // Fills the sites of the column at (y, z), columns, and says which stretches have any brick in reach;
  // returns false where none has.
  bool read(int y, int z, ColumnSites& sites, std::vector<uint8_t>& present) const {
    present.assign(static_cast<size_t>(stretches_) + 2, 0);
    bool any = false;
    for (size_t c = 0; c < 2; ++c)
      for (int w = 0; w < column_sites; ++w)
        for (int v = 0; v < column_sites; ++v) {
          const int j = slice_.lattice.mirror(1, static_cast<int>(c), column_edge / 2 * y - 1 + v),
                    k = slice_.lattice.mirror(2, static_cast<int>(c), column_edge / 2 * z - 1 + w);
          any |= read_row(c, j, k, sites.value.data() + sites.at(c, v, w), present);
        }
    // A stretch looks at the bricks beside it, too.
    std::vector<uint8_t> near(present.size(), 0);
    for (size_t s = 0; s + 1 < present.size(); ++s)
      near[s] = static_cast<uint8_t>((s > 0 && present[s - 1]) || present[s] || present[s + 1]);
    present.swap(near);
    return any;
  }

 private:
  bool read_row(size_t c, int j, int k, float* to, std::vector<uint8_t>& present) const {
    const BrickLayer& layer = slice_.coset[c];
    const int count = layer.dims()[0], bricks = layer.brick_dims()[0];
    const size_t slot = layer.slot(0, j / brick_edge, k / brick_edge),
                 from = static_cast<size_t>((k % brick_edge * brick_edge + j % brick_edge) * brick_edge);
    bool any = false;
    for (int b = 0; b < bricks; ++b) {
      float* const part = to + static_cast<std::ptrdiff_t>(b) * brick_edge;
      if (const Brick* const brick = layer.brick(slot + static_cast<size_t>(b))) {
        std::memcpy(part, brick->value.data() + from, brick_edge * sizeof(float));
        present[static_cast<size_t>(std::min(b, stretches_))] = 1;
        any = true;
      } else {
        std::memset(part, 0, brick_edge * sizeof(float));
      }
    }
    constexpr int beyond = 4; // sites
    for (int i = 1; i <= beyond; ++i) {
      to[-i] = to[slice_.lattice.mirror(0, static_cast<int>(c), -i)];
      to[count - 1 + i] = to[slice_.lattice.mirror(0, static_cast<int>(c), count - 1 + i)];
    }
    return any;
  }

  const Slice& slice_;
  int stretches_;
};

SurfaceCells empty_cells(const Slice& slice, const Context& context) {
  SurfaceCells cells;
  uint64_t words = 1;
  for (size_t a = 0; a < 3; ++a) {
    cells.cells[a] = slice.lattice.last[a];
    cells.blocks[a] = (cells.cells[a] + block_edge - 1) / block_edge;
    words *= static_cast<uint64_t>(cells.blocks[a]);
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

} // namespace

SurfaceCells mark_all_cells(const Slice& slice, const Context& context) {
  SurfaceCells cells = empty_cells(slice, context);
  std::fill(cells.bits.begin(), cells.bits.end(), ~uint64_t{0});
  return cells;
}

SurfaceCells mark_cells(const Slice& slice, double target, const Context& context) {
  const std::optional<CellBound> bound = cell_bound(slice.kernel);
  if (!bound) fail(Code::internal, "mark_cells: kernel ", slice.kernel.name, " has no bound");
  SurfaceCells cells = empty_cells(slice, context);
  const int lanes = cells.cells[0] / 2 + 1, stretches = (lanes + stretch_lanes - 1) / stretch_lanes;
  ColumnSites shape;
  shape.set_size(stretches);
  const CornerStencils stencils = make_stencils(slice.kernel.space, shape);
  const ColumnReader reader(slice, stretches);
  ColumnArgs args;
  args.stencils = &stencils;
  args.target = static_cast<float>(target);
  args.of_range = static_cast<float>(0.5 * (bound->of_range + rounding));
  args.of_middle = static_cast<float>(0.5 * (bound->of_middle + rounding));
  args.site_sum = site_sum;
  args.blocks = cells.blocks[0];
  args.row = cells.blocks[0], args.layer = args.row * cells.blocks[1];
  const auto columns = [&](size_t a) { return (cells.cells[a] + column_edge - 1) / column_edge; };
  const auto count = static_cast<uint64_t>(columns(1)) * static_cast<uint64_t>(columns(2));
  constexpr int blocks = column_edge / block_edge;
  std::mutex mutex;
  std::vector<std::unique_ptr<ColumnMemory>> idle;
  context.tasks.parallel_for(count, [&](uint64_t n) {
    context.progress.check();
    std::unique_ptr<ColumnMemory> memory;
    {
      const std::scoped_lock lock(mutex);
      if (!idle.empty()) memory = std::move(idle.back()), idle.pop_back();
    }
    if (!memory) {
      memory = std::make_unique<ColumnMemory>();
      memory->memory = Reservation(context.memory, 3 * shape.floats() * sizeof(float), "a surface's corners");
      memory->sites.prepare(stretches);
    }
    const int y = static_cast<int>(n) % columns(1), z = static_cast<int>(n) / columns(1);
    if (reader.read(y, z, memory->sites, memory->present)) {
      ColumnArgs column = args;
      column.sites = &memory->sites, column.present = memory->present.data();
      column.height = std::min(column_edge, cells.cells[1] - y * column_edge);
      column.depth = std::min(column_edge, cells.cells[2] - z * column_edge);
      column.bits = cells.bits.data() + cells.at({0, y * blocks, z * blocks});
      mark_column(column);
    }
    const std::scoped_lock lock(mutex);
    idle.push_back(std::move(memory));
  });
  return cells;
}

std::shared_ptr<const SurfaceCells> KeptSurfaceCells::find(const Slice& slice, double target,
                                                           const Context& context) {
  const auto is = [&](const Kept& k) { return k.slice == &slice && k.target == target && k.cells; };
  if (is(kept_[1])) std::swap(kept_[0], kept_[1]);
  if (is(kept_[0])) return kept_[0].cells;
  // The older one gives its memory back first.
  kept_[1] = std::exchange(kept_[0], {});
  kept_[0] = {&slice, target, std::make_shared<const SurfaceCells>(mark_cells(slice, target, context))};
  return kept_[0].cells;
}

} // namespace bccsplat

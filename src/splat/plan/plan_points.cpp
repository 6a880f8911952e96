// SPDX-License-Identifier: Apache-2.0
// Picks the single points that a picture needs out of its bricks: those within reach of a point whose
// coefficient alone could make a sample visible. Cells of 2^3 planes stand for points, one bit each, so that
// a brick and its neighbours are judged by a few words (point_sizes.h).
#include "splat/plan/plan_points.h"

#include <algorithm>
#include <tuple>

#include "splat/points/point_sizes.h"

namespace bccsplat {
namespace {

constexpr size_t fine_edge = std::tuple_size_v<FineCells>; // fine cells along an edge of a brick

// Returns whether some bit is set in every block of 2^3 cells of a brick of 8^3.
bool fills_every_block(const FineCells& cells) {
  constexpr uint64_t first_of_blocks = 0x0055005500550055; // in two planes, put together
  for (size_t z = 0; z < fine_edge; z += 2) {
    uint64_t any = cells[z] | cells[z + 1];
    any |= any >> fine_edge;
    any |= any >> 1;
    if ((any & first_of_blocks) != first_of_blocks) return false;
  }
  return true;
}

// Takes out what the cells of 4^3 planes leave out.
void cut_cells(FineCells& fine, uint64_t cells) {
  constexpr uint64_t row_of_fine = 255, row_of_cells = 15;
  constexpr size_t cells_per_plane = 16, cells_per_row = 4;
  for (size_t z = 0; z < fine_edge; ++z)
    for (size_t y = 0; y < fine_edge; ++y) {
      const uint64_t row = cells >> (cells_per_plane * (z / 2) + cells_per_row * (y / 2)) & row_of_cells;
      uint64_t spread = 0; // each bit at twice its place
      for (size_t x = 0; x < cells_per_row; ++x) spread |= (row & uint64_t{1} << x) << x;
      fine[z] &= ~(row_of_fine << (fine_edge * y)) | (spread * 3) << (fine_edge * y);
    }
}

// The bricks of a neighbourhood by their slots, which rise with their numbers.
class BrickMap {
 public:
  explicit BrickMap(const SplatPoints& points) : points_(points) {
    slots_.reserve(points.bricks.size());
    for (const SplatBrick& b : points.bricks) slots_.push_back(points.slot(b));
  }

  // take(brick, {dx, dy, dz}) for the brick and those beside it.
  template<class Take> void around(size_t brick, const Take& take) const {
    const Int3& dims = points_.dims;
    const size_t nx = dims[0], ny = dims[1];
    const size_t slot = slots_[brick];
    const int x = static_cast<int>(slot % nx), y = static_cast<int>(slot / nx % ny),
              z = static_cast<int>(slot / (nx * ny));
    for (int dz = -1; dz <= 1; ++dz)
      for (int dy = -1; dy <= 1; ++dy) {
        if (y + dy < 0 || y + dy >= dims[1] || z + dz < 0 || z + dz >= dims[2]) continue;
        const size_t row = ((z + dz) * ny + (y + dy)) * nx;
        const size_t first = row + std::max(0, x - 1), last = row + std::min(dims[0] - 1, x + 1);
        for (auto at = std::lower_bound(slots_.begin(), slots_.end(), first);
             at != slots_.end() && *at <= last; ++at)
          take(at - slots_.begin(), Int3{static_cast<int>(*at - row) - x, dy, dz});
      }
  }

 private:
  const SplatPoints& points_;
  std::vector<size_t> slots_;
};

constexpr size_t overhang = 16; // vectors read past the last point
// Copies take at most this part of what the budget has left, for the rest is of better use to layers and
// slices. They save a fifth of a draft picture of smoke (tests/bench/notes/render-speed.md).
constexpr uint64_t copies_of_rest = 4;

} // namespace

bool reserve_copies(const SplatPoints& points, MemoryBudget& budget, PickedPoints& picked) {
  const uint64_t bytes = (uint64_t{points.count} + overhang) * (sizeof(uint16_t) + sizeof(float)) +
                         points.bricks.size() * sizeof(FineCells);
  if (bytes > (budget.limit() - budget.used()) / copies_of_rest || !budget.try_reserve(bytes)) return false;
  picked.memory = Reservation::adopt(budget, bytes);
  return true;
}

int least_code(const SplatScene& scene, const SplatOptions& options, const WeightBounds& weights, double look,
               const SplatPlan& plan) {
  const double distance = 2 * scene.slice->kernel.space.radius + look;
  if (scene.points->codes.empty() || plan.raise.taps > 0 || plan.raise.depth_taps > 0 ||
      !(distance <= farthest(scene.points->plane_distance)))
    return 0;
  int least = 0;
  while (least < SplatPoints::most_code) {
    const auto below = scene.points->code_begin(least + 1);
    if (shows(scene, options, weights, -below, below)) break;
    ++least;
  }
  return least;
}

void pick_points(const SplatScene& scene, double look, int least, const Context& context, SplatPlan& plan,
                 DrawStats& stats) {
  const SplatPoints& points = *scene.points;
  const double distance = 2 * scene.slice->kernel.space.radius + look;
  std::vector<FineCells> large(points.bricks.size());
  each_brick(context, large.size(), [&](size_t n) {
    large[n] = cells_from(points.codes.data() + n * SplatPoints::fine_cells, static_cast<uint8_t>(least));
  });
  plan.picked.position.reserve(points.count + overhang);
  plan.picked.coefficient.reserve(points.count + overhang);
  const BrickMap map(points);
  const FineBall ball = make_ball(distance, points.plane_distance);
  const int edge = points.edge / 2;
  FineCells all;
  all.fill(~uint64_t{0});
  each_brick(context, plan.bricks.size(), [&](size_t n) {
    PlannedBrick& b = plan.bricks[n];
    const SplatBrick& brick = points.bricks[b.brick];
    FineCells needed = all;
    if (!fills_every_block(large[b.brick])) {
      FineCube cube;
      map.around(b.brick, [&](size_t other, const Int3& at) { cube.add(large[other], at, edge); });
      needed = cells_within(cube, ball);
    }
    if (b.cells != ~uint64_t{0}) cut_cells(needed, b.cells);
    if (needed == all) return;
    b.picked = true;
    b.count = take_points(points, brick, needed, plan.picked.position.data() + brick.first,
                          plan.picked.coefficient.data() + brick.first);
  });
  for (const PlannedBrick& b : plan.bricks) stats.points_invisible += points.bricks[b.brick].count - b.count;
  stats.bricks_invisible += std::erase_if(plan.bricks, [](const PlannedBrick& b) { return b.count == 0; });
}

} // namespace bccsplat

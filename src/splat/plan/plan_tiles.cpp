// SPDX-License-Identifier: Apache-2.0
// Cutting a tile has points drawn twice along the cut, so that only tiles that are too much for one thread
// are cut, each in two across its longer side.
#include "splat/plan/plan_tiles.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

namespace bccsplat {
namespace {

// Tiles are not cut below this many pixels a side.
constexpr int least_side = 32;
// What classifying and raising take per pixel, in points: half of a dense frame's time (the same notes).
constexpr double points_per_pixel = 5;

// The part of [a0, a1) inside [b0, b1).
double overlap(double a0, double a1, double b0, double b1) {
  return std::max(0.0, std::min(a1, b1) - std::max(a0, b0)) / std::max(a1 - a0, 1.0);
}

// The samples of the ring, or the pixels, that the rectangles of bricks are compared with.
std::array<int, 4> reached(const SplatPlan& plan, const PlannedTile& t) {
  if (plan.raise.fan.taps > 0) return {t.x, t.y, t.x + t.width, t.y + t.height};
  return {t.ring_x, t.ring_y, t.ring_x + t.ring_width, t.ring_y + t.ring_height};
}

std::array<PlannedTile, 2> cut_in_two(const SplatPlan& plan, const PlannedTile& tile) {
  const bool across = tile.width >= tile.height;
  const int w = across ? tile.width / 2 : tile.width, h = across ? tile.height : tile.height / 2;
  std::array<PlannedTile, 2> halves{plan_tile(plan, tile.x, tile.y, w, h),
                                    across ? plan_tile(plan, tile.x + w, tile.y, tile.width - w, h)
                                           : plan_tile(plan, tile.x, tile.y + h, w, tile.height - h)};
  for (PlannedTile& half : halves) {
    for (const uint32_t n : tile.bricks)
      if (meets_tile(plan, plan.bricks[n], half)) half.bricks.push_back(n);
    half.corrections = tile.corrections;
  }
  return halves;
}

} // namespace

bool meets_tile(const SplatPlan& plan, const PlannedBrick& brick, const PlannedTile& tile) {
  const auto [x0, y0, x1, y1] = reached(plan, tile);
  const auto& r = brick.rect;
  return r[0] < x1 && r[2] > x0 && r[1] < y1 && r[3] > y0;
}

double tile_work(const SplatPlan& plan, const PlannedTile& tile) {
  if (tile.empty()) return 0;
  const auto [x0, y0, x1, y1] = reached(plan, tile);
  double points = points_per_pixel * tile.width * tile.height;
  for (const uint32_t n : tile.bricks) {
    const PlannedBrick& b = plan.bricks[n];
    points += b.count * overlap(b.rect[0], b.rect[2], x0, x1) * overlap(b.rect[1], b.rect[3], y0, y1);
  }
  return points;
}

void divide_tiles(SplatPlan& plan, int threads) {
  if (threads < 2) return;
  double all = 0;
  for (const PlannedTile& t : plan.tiles) all += tile_work(plan, t);
  // Half of a thread's share evens out their ends better, and has more points drawn twice than that gains
  // (tests/bench/notes/render-speed.md).
  const double most = all / threads;
  std::vector<PlannedTile> open = std::exchange(plan.tiles, {});
  while (!open.empty()) {
    PlannedTile tile = std::move(open.back());
    open.pop_back();
    if (tile_work(plan, tile) <= most || std::max(tile.width, tile.height) < 2 * least_side) {
      plan.tiles.push_back(std::move(tile));
      continue;
    }
    for (PlannedTile& half : cut_in_two(plan, tile)) open.push_back(std::move(half));
  }
}

std::vector<size_t> tiles_by_work(const SplatPlan& plan) {
  std::vector<double> work;
  for (const PlannedTile& t : plan.tiles) work.push_back(tile_work(plan, t));
  std::vector<size_t> order(plan.tiles.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return work[a] > work[b]; });
  return order;
}

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Estimates what a tile takes, array by array, before it is drawn, and lends memory for it: a
// thread that finds none waits for another tile to end.
#include "splat/tile/tile_pool.h"

#include <algorithm>

#include "splat/tile/drawn_sheets.h"
#include "splat/tile/sheet_painter.h"
#include "splat/tile/tile_matter.h"
#include "splat/tile/tile_rays.h"

namespace bccsplat {
namespace {

template<class T> uint64_t bytes_of(const AlignedArray<T>& a) { return a.capacity() * sizeof(T); }

uint64_t bytes_of(const RaiseAxis& axis) {
  return axis.sample.capacity() * sizeof(int32_t) + axis.weight.capacity() * sizeof(float);
}

uint64_t bytes_of(const SheetMemory& m) {
  uint64_t sum = bytes_of(m.zero_plane) + bytes_of(m.samples) + bytes_of(m.scratch) + bytes_of(m.fan_x) +
                 bytes_of(m.fan_y);
  for (const auto& sheet : m.stack.slot) sum += bytes_of(sheet);
  for (const auto& ring : m.ring) sum += bytes_of(ring);
  for (const auto& sheet : m.plane.slot)
    for (const auto& plane : sheet) sum += bytes_of(plane);
  for (const auto& bin : m.bins) sum += bytes_of(bin);
  return sum;
}

uint64_t bytes_of(const TileMemory& m) {
  uint64_t sum = bytes_of(m.pixels) + bytes_of(m.rays) + bytes_of(m.matter) + bytes_of(m.paint) +
                 bytes_of(m.mixed) + bytes_of(m.hole);
  for (const SheetMemory& sheets : m.sheets) sum += bytes_of(sheets);
  return sum + (m.apart ? bytes_of(*m.apart) : 0);
}

uint64_t rounded(int width) { return (width + 15) / 16 * 16; }

// Returns the floats of one plane of a tile with its border, as SheetMemory has them.
uint64_t plane_floats(const SplatPlan& plan, const PlannedTile& tile) {
  return (rounded(tile.width + 2 * plan.sheets.border) + 16) * (tile.height + 2 * plan.sheets.border) +
         2 * plane_margin + 16;
}

// Returns the floats that the pixels of an object are raised from.
uint64_t raise_floats(const SplatPlan& plan, const PlannedTile& tile) {
  const uint64_t pitch = rounded(tile.ring_width) + 16;
  const uint64_t sheet = pitch * tile.ring_height + 16;
  uint64_t sum = plan.raise.depth_taps > 0 ? finished_sheets * sheet : 0;
  if (plan.raise.taps > 0) sum += sheet + (pitch + 32) * raise_rows;
  if (plan.raise.fan.taps > 0)
    sum += static_cast<uint64_t>(tile.width + tile.height + 4 * plan.sheets.border + 32) *
           (1 + plan.raise.fan.taps);
  return sum;
}

// Returns the bytes of the planes, ring and bins of an object as SheetMemory prepares them, every bin with
// room for its largest brick and, because bricks follow each other, doubled once.
uint64_t sheet_bytes(const TileObject& object, size_t n, bool gradients) {
  const SplatPlan& plan = object.plan;
  const PlannedTile& tile = plan.tiles[n];
  const uint64_t plane = plane_floats(plan, tile);
  if (tile.empty()) return plane * sizeof(float);
  const uint64_t quantities = gradients ? 4 : 1;
  const uint64_t ring = (rounded(tile.ring_width) + 2 * static_cast<uint64_t>(plan.ring.spare_columns)) *
                        (tile.ring_height + 2 * plan.ring.spare_rows) * 4 * plan.ring.groups;
  uint64_t bins = 1, largest = 64;
  while (bins < static_cast<uint64_t>(plan.longest) + 2) bins *= 2;
  for (const uint32_t b : tile.bricks)
    largest = std::max<uint64_t>(largest, object.scene->points->bricks[plan.bricks[b].brick].count + 16);
  return (plane * (1 + finished_sheets * quantities) + ring * quantities + raise_floats(plan, tile)) *
             sizeof(float) +
         (bins + 1) * 2 * largest * sizeof(SplatRecord);
}

} // namespace

uint64_t tile_bytes(const TileJob& job, size_t n) {
  const bool gradients = job.options->shading && job.options->gradient == GradientMethod::analytic;
  uint64_t sum = 0, mixed = 0, painted = 0;
  for (const TileObject& o : job.objects) {
    sum += sheet_bytes(o, n, gradients);
    if (!job.alone()) painted = std::max<uint64_t>(painted, paint_planes(*o.scene));
  }
  for (const SplatStill& s : job.stills) mixed += s.shares.size() > 1 ? 1 : 0;
  const SplatPlan& plan = job.objects.front().plan;
  const PlannedTile& tile = plan.tiles[n];
  const uint64_t pixels = rounded(tile.width) * tile.height;
  const uint64_t planes = TileMemory::pixel_planes + painted + matter_planes(job) +
                          (job.alone() ? 1 : job.objects.size() + 1) * ray_planes;
  return sum +
         (planes * pixels + mixed * (finished_sheets + gradient_planes) * plane_floats(plan, tile)) *
             sizeof(float) +
         pixels * (job.alone() ? most_sheets_at_once : 1);
}

std::unique_ptr<TilePool::Held> TilePool::take(uint64_t bytes) {
  std::unique_lock lock(mutex_);
  for (;;) {
    idle_.reserve(idle_.size() + static_cast<size_t>(taken_) + 1); // so that giving back allocates nothing
    auto held = std::make_unique<Held>();
    if (!idle_.empty()) {
      held = std::move(idle_.back());
      idle_.pop_back();
    }
    const uint64_t want = std::max(bytes, held->reserved), more = want - held->reserved;
    if (budget_.try_reserve(more)) {
      held->reserved = want;
      ++taken_;
      return held;
    }
    drop(std::move(held));
    if (!idle_.empty()) {
      drop_idle();
      continue;
    }
    held = std::make_unique<Held>();
    if (budget_.try_reserve(bytes)) {
      held->reserved = bytes;
      ++taken_;
      return held;
    }
    if (taken_ == 0) { // fails, and says what the budget lacks
      [[maybe_unused]] const Reservation failed(budget_, bytes, "a tile of several objects");
      continue;
    }
    ended_.wait(lock);
  }
}

void TilePool::give_back(std::unique_ptr<Held> held) {
  const std::scoped_lock lock(mutex_);
  --taken_;
  // Bins may have grown beyond what was reserved.
  const uint64_t bytes = bytes_of(held->memory), more = bytes - std::min(bytes, held->reserved);
  if (budget_.try_reserve(more)) {
    held->reserved += more;
    budget_.release(held->reserved - bytes);
    held->reserved = bytes;
    idle_.push_back(std::move(held));
  } else {
    drop(std::move(held));
  }
  ended_.notify_all();
}

void TilePool::drop(std::unique_ptr<Held> held) {
  const uint64_t bytes = held->reserved;
  held.reset();
  budget_.release(bytes);
}

void TilePool::drop_idle() {
  for (auto& held : idle_) drop(std::move(held));
  idle_.clear();
}

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// What the groups of a tile's objects absorb on the sheets under way, and how that comes onto the pixels.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "splat/sheet/matter.h"
#include "splat/tile/tile.h"
#include "splat/tile/tile_front.h"

namespace bccsplat {

inline constexpr uint64_t group_planes = 6;

// Returns the planes of matter of a tile.
[[nodiscard]] inline uint64_t matter_planes(const TileJob& job) {
  return job.alone() ? 0 : most_sheets_at_once * job.groups() * group_planes;
}

class TileMatter {
 public:
  // Everything passed must outlive it. pixel: the tile's, with the rays of the picture.
  TileMatter(const TileJob& job, const PlannedTile& tile, TileMemory& memory, const PixelPlanes& pixel);

  // Nothing is on any sheet from now on.
  void clear();
  // Returns the planes of a group on sheet `n` of those under way, which hold nothing when it is first asked
  // for.
  const MatterPlanes& of(size_t n, size_t group);
  // Returns whether anything is on the sheet.
  [[nodiscard]] bool any(size_t n) const {
    return std::find(used_[n].begin(), used_[n].end(), 1) != used_[n].end();
  }
  // Adds a surface that rays go through, as group 0 of sheet k: pixels whose surface is in the sheet's
  // segment or before it are opaque.
  void add_front(const TileFront& front, int64_t k, size_t n);
  // Composites sheet k, which has something; returns the number of pixels that closed.
  int join(int64_t k, size_t n, float stop);

 private:
  [[nodiscard]] const MatterPlanes* used(size_t n, size_t group) const {
    return used_[n][group] ? &planes_[n][group] : nullptr;
  }

  const TileJob& job_;
  const PlannedTile& tile_;
  const PixelPlanes& pixel_;
  const MatterLoops& loops_;
  int pitch_;
  size_t pixels_;
  std::array<std::vector<MatterPlanes>, most_sheets_at_once> planes_; // by sheet and group
  std::array<std::vector<char>, most_sheets_at_once> used_;
};

} // namespace bccsplat

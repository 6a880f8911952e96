// SPDX-License-Identifier: Apache-2.0
// One tile of a picture with a trail.
#pragma once

#include <span>
#include <vector>

#include "splat/plan/plan.h"
#include "splat/tile/tile_memory.h"
#include "splat/trail/trail.h"
#include "splat/trail/trail_sheets.h"

namespace bccsplat {

// Pixels of a tile. Tiles of 80 took least time of 48, 64, 80 and 96, for larger ones draw fewer points twice
// (tests/bench/notes/trail.md); small ones are for short memory.
inline constexpr int large_trail_tile = 80, small_trail_tile = 32;

// A set of points with everything that is planned for it.
struct TrailObject {
  const SplatScene* scene = nullptr;
  SplatPlan plan;
  KernelPolynomial kernel;
  bool own_rays = false; // its domain is not the slice's
};

// Sheets that are classified together, each with what the groups of objects absorb on it, six planes: an
// object's ring and planes are fetched once for all of them, which saves 6 to 20 % of the time
// (tests/bench/notes/trail.md).
inline constexpr int sheets_together = 4;
inline constexpr uint64_t group_planes = 6;
// The groups that are composited, before those of the pairs.
inline constexpr size_t joined_groups = 2;

// The memory that a tile of a trail works in, which is kept from tile to tile.
struct TrailMemory {
  TileMemory slice;               // of the slice where it is drawn apart
  std::vector<TileMemory> sheets; // per object
  AlignedArray<float> pixels, matter, mixed, rays, paint;
  AlignedArray<float> front; // pixels of a slice of labels that is drawn apart
  AlignedArray<uint8_t> hole;
  DeepTile deep; // where the options ask for it
};

struct TrailJob {
  const TrailObject* slice = nullptr; // null: drawn apart
  std::span<const TrailObject> sources;
  std::span<const TrailStill> stills;
  TrailCombine combine = TrailCombine::physical;
  // How slice and trail of a pair are joined before its extinction is added to group 1. Pair n has the groups
  // joined_groups + 2 n, the slice's, and the one behind it.
  std::span<const TrailCombine> pairs{};
  const SplatOptions* options = nullptr;
  const Context* context = nullptr;
  const SplatScene* main = nullptr; // the slice's scene: its rays are the picture's
};

// Returns the planes of matter of a tile.
[[nodiscard]] inline uint64_t matter_planes(const TrailJob& job) {
  return sheets_together * (joined_groups + 2 * job.pairs.size()) * group_planes;
}

// Draws the tile `n` of every plan. `surface` (may be null): a pixel it covers ends the ray at its depth with
// its colour.
TilePixels draw_trail_tile(const TrailJob& job, size_t n, const PlannedTile& tile, const TilePixels* surface,
                           TrailMemory& memory, DrawStats& stats);

} // namespace bccsplat

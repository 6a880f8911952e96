// One tile, front to back.
#pragma once

#include "splat/plan.h"
#include "splat/stack.h"
#include "splat/tile_memory.h"

namespace bccsplat {

struct TileJob {
  const SplatScene* scene = nullptr;
  const SplatOptions* options = nullptr;
  const SplatPlan* plan = nullptr;
  const KernelPolynomial* kernel = nullptr;
  const Context* context = nullptr;
  // Not null (mode composite): sheets go here, their extinction times `weight`, instead of into the tile's
  // pixels.
  SheetStack* stack = nullptr;
  size_t group = 0;
  float weight = 1;
};

// Draws a tile; the pixels stay in `memory`.
TilePixels draw_tile(const TileJob& job, const PlannedTile& tile, TileMemory& memory, SplatStats& stats);

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Draws one tile of a picture, front to back.
#pragma once

#include "splat/plan/plan.h"
#include "splat/tile/kept_sheets.h"
#include "splat/tile/tile_memory.h"

namespace bccsplat {

struct TileJob {
  const SplatScene* scene = nullptr;
  const SplatOptions* options = nullptr;
  const SplatPlan* plan = nullptr;
  const KernelPolynomial* kernel = nullptr;
  const Context* context = nullptr;
  KeptSheets* kept = nullptr;
  KeptSheets::Use use = KeptSheets::Use::draw;
};

// Draws a tile; the pixels stay in `memory`.
TilePixels draw_tile(const TileJob& job, const PlannedTile& tile, TileMemory& memory, DrawStats& stats);

} // namespace bccsplat

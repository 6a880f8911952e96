// SPDX-License-Identifier: Apache-2.0
// What becomes of the sums of a tile's pixels when its sheets are done.
#pragma once

#include "draw/deep_tile.h"
#include "shade/surface.h"
#include "splat/plan/plan.h"
#include "splat/sheet/sheet.h"
#include "splat/tile/tile_front.h"

namespace bccsplat {

// The pixels of a tile, pitched as its planes are.
struct FinishedPixels {
  const SplatScene& scene;
  const SplatOptions& options;
  const PlannedTile& tile;
  int pitch;
  const PixelPlanes& pixel;
};

// Lays a surface that ends rays behind pixels that are less opaque than `stop`; deep: null: not asked for.
void add_behind(const FinishedPixels& pixels, const TileFront& front, float stop, DeepTile* deep);
// Composites and surfaces: values and times are means.
void finish_means(const FinishedPixels& pixels);
void finish_xray(const FinishedPixels& pixels);
// field: of the scene's slice.
void finish_maximum(const FinishedPixels& pixels, const SurfaceField& field);

} // namespace bccsplat

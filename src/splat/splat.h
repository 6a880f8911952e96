// SPDX-License-Identifier: Apache-2.0
// Image-aligned sheet-buffer splatting: the points of a slice, drawn tile by tile, front to back.
//
// Per tile a ring of live sheets gathers the kernels of the points; a sheet that no later point can reach is
// classified, shaded and composited. Every pixel closes by itself, every sample adds its points in one order
// (gap, brick, place in the brick) and positions come from tile-independent integers and fractions: the
// picture does not depend on tile size or threads, bit for bit. Sources: Westover 1990; Mueller, Shareef,
// Huang, Crawfis 1999 (sheets, post-classification); Neophytou & Mueller 2002.
#pragma once

#include <functional>

#include "base/context.h"
#include "draw/stats.h"
#include "draw/tile_pixels.h"
#include "splat/plan/scene.h"

namespace bccsplat {

class KeptSheets;

// `emit` is called once per tile, from any thread. `kept` holds sheets from picture to picture; null: none
// are kept.
DrawStats splat(const SplatScene& scene, const SplatOptions& options, const Context& context,
                const std::function<void(const TilePixels&)>& emit, KeptSheets* kept = nullptr);

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// How the work of a picture is shared by threads: tiles of one size, of which those that hold more than
// their share are cut.
#pragma once

#include <cstdint>
#include <vector>

#include "splat/plan/plan.h"

namespace bccsplat {

// Returns whether points of the brick may touch the ring of the tile.
[[nodiscard]] bool meets_tile(const SplatPlan& plan, const PlannedBrick& brick, const PlannedTile& tile);

// Returns about how many points the tile draws, and for its pixels as many as take as long as they do.
[[nodiscard]] double tile_work(const SplatPlan& plan, const PlannedTile& tile);

// Cuts tiles until none holds so much that a thread would draw it alone in the end. No cut changes a bit of
// the picture.
void divide_tiles(SplatPlan& plan, int threads);

// Returns the numbers of the tiles, those with the most work first.
[[nodiscard]] std::vector<size_t> tiles_by_work(const SplatPlan& plan);

} // namespace bccsplat

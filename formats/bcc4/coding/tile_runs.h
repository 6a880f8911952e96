// SPDX-License-Identifier: Apache-2.0
// Which sites of a tile are kept: its runs part, brick by brick.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "formats/bcc4/coding/chunk.h"
#include "formats/bcc4/coding/tile.h"

namespace bccsplat {

// Decodes the runs part of a tile: its bricks, x fastest, with all that is known of them but codes. Throws
// where it is damaged.
[[nodiscard]] std::vector<ChunkData> read_tile_runs(const TilePlace& place, const ChunkCodes& codes,
                                                    const Bcc4Chunk& entry, std::span<const std::byte> bytes,
                                                    ChunkScratch& scratch);

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// What a reader gets of a tile: of one that is being coded, beside what was wanted, and of one that is
// stored.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "formats/bcc4/coding/linear_tile.h"
#include "formats/bcc4/encode/encode_tile.h"

namespace bccsplat {

// Makes the bricks that a reader gets of the kept sites, within the range that these had, adds the squares of
// what they are off by, and returns the range of their codes.
[[nodiscard]] CodeRange read_back(const TileSites& sites, const SampleCoder& coder,
                                  std::vector<TileLayers> layers, EncodedTile& tile);
// The same of samples that are linear in what is coded.
[[nodiscard]] CodeRange read_linear(const TileSites& sites, const SampleCoder& coder, const LinearTile& back,
                                    EncodedTile& tile);

// The bricks of a stored tile, as EncodedTile has them. linear: as encode_tile says. Throws where its bytes
// are damaged.
[[nodiscard]] std::vector<SampleBrick> read_stored(const TilePlace& place, const SampleCoder& coder,
                                                   bool linear, const Bcc4Chunk& entry,
                                                   std::span<const std::byte> bytes, ChunkScratch& scratch);

} // namespace bccsplat

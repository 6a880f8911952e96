// SPDX-License-Identifier: Apache-2.0
// Chunks of wavelet coefficients: the sites of a cube of bricks through the layers of a slab, coded together
// (bcc4.md, section 12).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "formats/bcc4/coding/chunk.h"
#include "formats/bcc4/coding/codes.h"
#include "formats/bcc4/wavelet/wavelet_tile.h"
#include "points/sample_layer.h"

namespace bccsplat {

inline constexpr std::array<int, 3> tile_edges{2, 4, 8}; // bricks along each axis of a tile
inline constexpr int usual_tile_edge = 4;                // 64^3 sites
inline constexpr uint8_t wavelet_part = 2;               // how the values of a chunk are stored

// Where a tile is: its bricks, edge of them along each axis, and its layers.
struct TilePlace {
  const Lattice4* lattice = nullptr;
  int32_t first_layer = 0, layers = 0;
  Int3 brick{}; // the first one
  int edge = 1;
  [[nodiscard]] int bricks() const { return edge * edge * edge; }
  // The brick number i, x fastest.
  [[nodiscard]] Int3 brick_at(int i) const {
    return {brick[0] + i % edge, brick[1] + i / edge % edge, brick[2] + i / edge / edge};
  }
  // The sites of each coset inside the domain.
  [[nodiscard]] std::array<TileBox, 2> boxes() const;
  [[nodiscard]] uint64_t sites() const;
  // What decoding it takes at most: coefficients, magnitudes beside them and which sites are kept. Few bytes
  // may stand for all of it.
  [[nodiscard]] uint64_t decoding_bytes() const;
};

// The sites of a tile, by brick.
struct TileSites {
  TilePlace place;
  std::vector<ChunkSites> bricks;
  [[nodiscard]] uint64_t kept() const;
};

class OpenTile; // open_tile.h
// All codes of a tile: ChunkData whose `bricks` are those of the place.
[[nodiscard]] ChunkData whole_tile(const OpenTile& tile);
// A tile whose sites are all holes.
[[nodiscard]] ChunkData tile_of_holes(const TilePlace& place, const ChunkCodes& codes);

} // namespace bccsplat

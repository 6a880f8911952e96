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

// Keeps all sites of a brick but blocks of 4^3 of a coset that are air in all layers: run lists of single
// sites cost more than wavelets make of them. The code of air must stand for it.
void keep_but_blocks_of_air(ChunkSites& sites, uint32_t air);

// The codes of a tile less that of air, by coset; 0 where a site is not kept.
[[nodiscard]] std::array<std::vector<float>, 2> tile_values(const TileSites& sites, const ChunkCodes& codes);

struct EncodedTile {
  EncodedChunk chunk;
  double squared_error = 0;        // of all kept sites, in codes
  std::vector<SampleBrick> bricks; // what a reader gets: the layers of the first brick, those of the next ..
};
[[nodiscard]] EncodedTile encode_tile(const TileSites& sites, const SampleCoder& coder, const TileRule& rule,
                                      int level);

class OpenTile; // open_tile.h
// All codes of a tile: ChunkData whose `bricks` are those of the place.
[[nodiscard]] ChunkData whole_tile(const OpenTile& tile);
// A tile whose sites are all holes.
[[nodiscard]] ChunkData tile_of_holes(const TilePlace& place, const ChunkCodes& codes);

} // namespace bccsplat

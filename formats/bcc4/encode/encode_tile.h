// SPDX-License-Identifier: Apache-2.0
// Codes a tile: the wavelet coefficients of its kept sites.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "formats/bcc4/coding/tile.h"
#include "formats/bcc4/encode/choose_tile.h"
#include "points/sample_layer.h"

namespace bccsplat {

// Raised whenever the same samples become other tiles: an import that another version began is then not
// resumed, and parts of different versions are not joined.
inline constexpr int tile_rules = 1;

// Keeps all sites of a brick but blocks of 4^3 of a coset that are air in all layers: run lists of single
// sites cost more than wavelets make of them. The code of air must stand for it.
void keep_but_blocks_of_air(ChunkSites& sites, uint32_t air);

// The codes of a tile less that of air, by coset; 0 where a site is not kept. room: is used for them.
using CosetValues = std::array<std::vector<float>, 2>;
[[nodiscard]] CosetValues tile_values(const TileSites& sites, const ChunkCodes& codes, CosetValues room = {});

struct EncodedTile {
  EncodedChunk chunk;
  double squared_error = 0;        // of all kept sites, in codes
  std::vector<SampleBrick> bricks; // what a reader gets: the layers of the first brick, those of the next ..
};
// linear: samples are what is coded adds up to (coding/linear_tile.h). What a reader gets of these is rounded
// by as_read_rounding of a step between codes at most.
inline constexpr double as_read_rounding = 1.0 / 64;
[[nodiscard]] EncodedTile encode_tile(const TileSites& sites, const SampleCoder& coder, const TileRule& rule,
                                      int level, bool linear, TileRoom& room);

} // namespace bccsplat

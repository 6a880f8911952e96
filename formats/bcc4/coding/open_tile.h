// SPDX-License-Identifier: Apache-2.0
// A decoded tile of which any layer of any brick can be made.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/bcc4/coding/chunk.h"
#include "formats/bcc4/coding/tile.h"

namespace bccsplat {

class OpenTile {
 public:
  // Decodes the stored bytes of a tile, padding included. Throws where they are damaged.
  OpenTile(const TilePlace& place, const ChunkCodes& codes, const Bcc4Chunk& entry,
           std::span<const std::byte> bytes, ChunkScratch& scratch);
  // What these sites become within that range of codes. layers: by coset.
  OpenTile(const TileSites& sites, const ChunkCodes& codes, const CodeRange& range,
           std::vector<TileLayers> layers);

  // The bricks, x fastest, with all that is known of them but codes.
  [[nodiscard]] std::span<const ChunkData> bricks() const { return bricks_; }
  // Writes the codes of the kept sites of a layer of a brick; beyond them beyond_sums more may be written.
  void make_codes(int brick, int layer, std::byte* to) const;
  // The smallest and the largest of all codes of kept sites.
  [[nodiscard]] CodeRange range() const;
  [[nodiscard]] uint64_t bytes() const;
  // The bytes of the codes of these layers, a bit each.
  [[nodiscard]] uint64_t code_bytes(uint32_t layers) const;

 private:
  std::vector<ChunkData> bricks_;
  int edge_; // bricks along an axis
  std::array<TileBox, 2> boxes_;
  std::vector<TileLayers> layers_; // by coset
  RoundedCodes rounded_;
};

} // namespace bccsplat

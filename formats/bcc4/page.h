// SPDX-License-Identifier: Apache-2.0
// The pages of the index and their directory (bcc4.md, section 4).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "formats/bcc4/coding/chunk.h"
#include "formats/bcc4/coding/tile.h"
#include "formats/bcc4/info.h"
#include "formats/bcc4/layout.h"

namespace bccsplat {

inline constexpr uint32_t page_entries = 4096;      // of a page as this library writes it
inline constexpr uint32_t max_page_entries = 65536; // of a page that a reader accepts
inline constexpr uint64_t page_ref_bytes = 64;
// The decoded bytes of the largest page: the known columns, and about as many bytes again for columns of
// later versions.
inline constexpr uint64_t max_page_bytes = uint64_t{max_page_entries} * 128;

// A page of the index: entries of one channel at one level with rising (slab, slot).
struct PageRef {
  uint32_t channel = 0, level = 0;
  int32_t first_slab = 0, last_slab = 0;
  uint32_t first_slot = 0, last_slot = 0;
  uint32_t entries = 0;
  BlockRef block;
  uint32_t min_code = 0, max_code = 0; // of all its chunks
  bool operator==(const PageRef&) const = default;
  [[nodiscard]] ChannelLevel at() const { return {static_cast<int>(channel), static_cast<int>(level)}; }
};

// The number of chunks along x, y, z: of bricks of a layer of coset 0, or of tiles of them.
[[nodiscard]] Int3 slot_dims(const StoredLattice& info);
[[nodiscard]] uint64_t slot_count(const StoredLattice& info);
// The number of bricks of a layer of coset 0.
[[nodiscard]] uint64_t brick_count(const Lattice4& lattice);
// The first brick of a slot's chunk.
[[nodiscard]] inline Int3 slot_brick(const Int3& dims, uint32_t slot, int tile_edge) {
  const uint32_t nx = dims[0], ny = dims[1];
  return {static_cast<int32_t>(slot % nx) * tile_edge, static_cast<int32_t>(slot / nx % ny) * tile_edge,
          static_cast<int32_t>(slot / nx / ny) * tile_edge};
}

// The chunk of a slab at a brick position.
[[nodiscard]] inline ChunkShape chunk_shape(const StoredLattice& info, int32_t slab, const Int3& brick) {
  return chunk_shape(info.lattice, slab * info.slab_layers, info.layers_of(slab), brick);
}
// The tile of a slab whose first brick that is.
[[nodiscard]] inline TilePlace tile_place(const StoredLattice& info, int32_t slab, const Int3& brick) {
  return {&info.lattice, slab * info.slab_layers, info.layers_of(slab), brick, info.tile_edge};
}

[[nodiscard]] std::vector<std::byte> write_page(std::span<const Bcc4Chunk> chunks);
// Describes a page but for its block, which is not written yet.
[[nodiscard]] PageRef describe_page(const ChannelLevel& at, std::span<const Bcc4Chunk> chunks);
// Reads a page and checks every entry against the lattice, the channel and the directory.
[[nodiscard]] std::vector<Bcc4Chunk> read_page(std::span<const std::byte> decoded, const PageRef& ref,
                                               const VolumeInfo& info, uint64_t file_bytes);

[[nodiscard]] std::vector<std::byte> write_directory(std::span<const PageRef> pages);
// Reads the directory; its pages rise by (channel, level, slab, slot).
[[nodiscard]] std::vector<PageRef> read_directory(std::span<const std::byte> decoded, const VolumeInfo& info,
                                                  const Root& root, uint64_t offset);

} // namespace bccsplat

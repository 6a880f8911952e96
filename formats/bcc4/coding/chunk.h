// SPDX-License-Identifier: Apache-2.0
// One chunk: the sites of a 4D brick as codes, and its two coded parts (bcc4.md, sections 5 to 7).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "formats/bcc4/coding/chunk_entry.h"
#include "lattice/lattice.h"
#include "points/brick.h"
#include "points/values.h"

namespace bccsplat {

inline constexpr int32_t max_slab_layers = 32;

// The layers of a chunk and their sites inside the domain.
struct ChunkShape {
  int layers = 0;
  int period = 1;     // layers between layers of one coset
  bool still = false; // of a static lattice, where layers of one coset do not follow each other in time
  int first_coset = 0;
  // Sites per axis, 0 .. 16; all zero where the coset has no such brick.
  std::array<Int3, max_slab_layers> box{};

  [[nodiscard]] int coset(int layer) const { return period == 2 ? (first_coset + layer) & 1 : 0; }
  [[nodiscard]] bool empty(int layer) const { return box[layer][0] == 0; }
  // Returns whether a layer of the same coset comes before.
  [[nodiscard]] bool has_previous(int layer) const { return !still && layer >= period; }
  // Returns whether the layer before exists and is of the other coset.
  [[nodiscard]] bool has_cross(int layer) const { return period == 2 && layer >= 1 && !empty(layer - 1); }
  [[nodiscard]] uint64_t sites() const;
};

// The chunk at a brick position in the layers first_layer .. first_layer + layers - 1.
[[nodiscard]] ChunkShape chunk_shape(const Lattice4& lattice, int32_t first_layer, int32_t layers,
                                     const Int3& brick);

// The kept sites of a chunk. Codes are ordered codes: unsigned integers in the order of their values.
struct ChunkSites {
  ChunkShape shape;
  std::vector<BrickMask> kept; // one per layer
  std::vector<BrickMask> hole; // one per layer, within `kept`; empty: no holes
  std::vector<uint32_t> codes; // of the kept sites: layer, z, y, x, x fastest
  [[nodiscard]] uint32_t holes() const;
};

// How samples of one channel become codes.
struct ChunkCodes {
  ValueType type = ValueType::f32;
  uint32_t air = 0; // sites that are not kept count as this code when neighbours are predicted
  [[nodiscard]] uint32_t bytes() const { return value_bytes(type); }
  [[nodiscard]] uint32_t mask() const { return bytes() == 4 ? UINT32_MAX : (1u << (8 * bytes())) - 1; }
};

struct EncodedChunk {
  Bcc4Chunk entry;              // all but slab, slot and offset
  std::vector<std::byte> bytes; // entry.stored() of them
};

using CodeRange = std::array<uint32_t, 2>; // the smallest and the largest

// A chunk of which only the first layers have been decoded.
struct ChunkRest {
  ChunkShape shape;
  ChunkCodes coded;
  Bcc4Chunk entry;
  std::vector<BrickMask> kept, hole; // as in ChunkSites
  std::vector<uint32_t> first;       // as in ChunkData, of all layers
  std::vector<std::byte> values;     // the values part, as it is stored
  int layers = 0;                    // that have been decoded
  CodeRange range{};                 // of their codes
  [[nodiscard]] uint64_t bytes() const {
    return sizeof(*this) + (kept.size() + hole.size()) * sizeof(BrickMask) + first.size() * 4 + values.size();
  }
};

class LinearTile; // linear_tile.h
class OpenTile;   // open_tile.h

// A decoded chunk as it is cached: codes in as many bytes as their type has.
struct ChunkData {
  ChunkShape shape;
  ChunkCodes coded;
  std::vector<BrickMask> kept, hole; // as in ChunkSites
  std::vector<uint32_t> first;       // index of the first code of each layer, and their number
  std::vector<std::byte> codes;      // of a chunk with a rest only those of the layers that were decoded
  std::shared_ptr<const ChunkRest> rest{};
  bool lost = false; // read as holes, as it could not be decoded
  // A tile (tile.h) has one of these three, and beside it only `coded` and `lost`: its bricks, x fastest, or
  // what they are made of.
  std::vector<std::shared_ptr<const ChunkData>> bricks{};
  std::shared_ptr<const OpenTile> tile{};
  std::shared_ptr<const LinearTile> linear{};
  [[nodiscard]] uint64_t bytes() const {
    return sizeof(*this) + (kept.size() + hole.size()) * sizeof(BrickMask) + first.size() * 4 +
           codes.capacity();
  }
};
struct ChunkScratch; // scratch.h
// Decodes the stored bytes of a chunk, padding included. The entry keeps the rules of its page (page.h).
// `layers`: as many are wanted, the first ones; where it saves something no others are decoded, and the chunk
// has a rest.
[[nodiscard]] ChunkData decode_chunk(const ChunkShape& shape, const ChunkCodes& channel,
                                     const Bcc4Chunk& entry, std::span<const std::byte> bytes,
                                     ChunkScratch& scratch, int layers = max_slab_layers);
// Codes of the last layer but one before a rest, and of the last layer, as in ChunkData; empty where nothing
// is kept.
using LayersBefore = std::array<std::span<const std::byte>, 2>;
// Decodes the other layers, or all where it is not told what comes before them; data.first counts the codes
// that are there.
[[nodiscard]] ChunkData finish_chunk(const ChunkRest& rest, const std::optional<LayersBefore>& before,
                                     ChunkScratch& scratch);
// A chunk whose sites are all holes.
[[nodiscard]] ChunkData chunk_of_holes(const ChunkShape& shape, const ChunkCodes& channel);

} // namespace bccsplat

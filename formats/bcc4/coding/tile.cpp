// SPDX-License-Identifier: Apache-2.0
// Decodes a tile: boxes of numbers, one for each coset, are spread over its bricks as codes. Run lists go
// through the bricks one after the other.
#include "formats/bcc4/coding/tile.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

#include "base/bytes.h"
#include "formats/bcc4/coding/chunk_parts.h"
#include "formats/bcc4/coding/chunk_rows.h"
#include "formats/bcc4/coding/tile_rows.h"

namespace bccsplat {
namespace {

void read_tile_runs(std::span<ChunkData> bricks, const Bcc4Chunk& entry, std::span<const std::byte> bytes,
                    uint64_t sites) {
  ByteReader in(bytes, "runs of the chunk", entry.offset + entry.values_bytes);
  RunDecoder occupancy(in, sites, entry.kept);
  for (ChunkData& b : bricks) {
    b.kept.assign(b.shape.layers, BrickMask{});
    for_rows(b.shape, [&](size_t m, size_t r, int width) { b.kept[m][r] = occupancy.row(width); });
  }
  occupancy.finish();
  if (entry.holes > 0) {
    RunDecoder holes(in, entry.kept, entry.holes);
    for (ChunkData& b : bricks) {
      b.hole.assign(b.shape.layers, BrickMask{});
      for_rows(b.shape, [&](size_t m, size_t r, int) {
        const uint16_t kept = b.kept[m][r];
        b.hole[m][r] = expand_bits(holes.row(std::popcount(kept)), kept);
      });
    }
    holes.finish();
  }
  in.expect_end();
}

void put_code(std::byte* to, uint32_t code, uint32_t bytes) { std::memcpy(to, &code, bytes); }

// The codes of the kept sites of a brick.
void read_codes(const TilePlace& place, int i, ChunkData& b, const RoundedCodes& rounded,
                std::span<const std::vector<float>> values) {
  const uint32_t bytes = b.coded.bytes();
  b.codes.resize(size_t{b.first.back()} * bytes);
  std::byte* to = b.codes.data();
  for_tile_rows(place, i, b.shape, [&](int m, int row, int width, int coset, size_t first) {
    for (int x = 0; x < width; ++x)
      if (b.kept[m][row] >> x & 1) put_code(to, rounded(values[coset][first + x]), bytes), to += bytes;
  });
}

ChunkData brick_of_tile(const TilePlace& place, int i, const ChunkCodes& codes) {
  ChunkData b;
  b.shape = shape_at(place, i);
  b.coded = codes;
  return b;
}

} // namespace

std::array<TileBox, 2> TilePlace::boxes() const {
  std::array<TileBox, 2> out;
  const int period = lattice->layer_period();
  for (int32_t m = 0; m < std::min(layers, period); ++m) {
    const int coset = lattice->coset(first_layer + m);
    TileBox& box = out[coset];
    const Int3 dims = lattice->space.dims(coset);
    bool any = true;
    for (size_t a = 0; a < 3; ++a) {
      box.size[a] = std::clamp(dims[a] - brick[a] * brick_edge, 0, edge * brick_edge);
      any = any && box.size[a] > 0;
    }
    box.layers = (layers - m + period - 1) / period;
    if (!any) box = {};
  }
  return out;
}

uint64_t TilePlace::sites() const {
  uint64_t n = 0;
  for (const TileBox& box : boxes()) n += box.sites();
  return n;
}

ChunkData decode_tile_chunk(const TilePlace& place, const ChunkCodes& codes, const Bcc4Chunk& entry,
                            std::span<const std::byte> bytes, ChunkScratch& scratch) {
  check_stored(entry, bytes);
  std::vector<ChunkData> bricks;
  for (int i = 0; i < place.bricks(); ++i) bricks.push_back(brick_of_tile(place, i, codes));
  read_tile_runs(bricks, entry, open_runs(entry, bytes, scratch), place.sites());
  const auto boxes = place.boxes();
  const auto values = decode_tile(boxes, bytes.first(entry.values_bytes), entry.offset);
  ChunkData data;
  data.coded = codes;
  const RoundedCodes rounded = rounded_codes(codes, entry.min_code, entry.max_code);
  for (int i = 0; i < place.bricks(); ++i) {
    find_layers(bricks[i]);
    read_codes(place, i, bricks[i], rounded, values);
    data.bricks.push_back(std::make_shared<const ChunkData>(std::move(bricks[i])));
  }
  return data;
}

ChunkData tile_of_holes(const TilePlace& place, const ChunkCodes& codes) {
  ChunkData data;
  data.coded = codes;
  for (int i = 0; i < place.bricks(); ++i) {
    ChunkData brick = chunk_of_holes(shape_at(place, i), codes);
    brick.lost = true;
    data.bricks.push_back(std::make_shared<const ChunkData>(std::move(brick)));
  }
  return data;
}

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Codes are made of the boxes of a tile when they are asked for.
#include "formats/bcc4/coding/open_tile.h"

#include <algorithm>
#include <utility>

#include "formats/bcc4/coding/chunk_parts.h"
#include "formats/bcc4/coding/range.h"
#include "formats/bcc4/coding/scratch.h"
#include "formats/bcc4/coding/tile_rows.h"
#include "formats/bcc4/coding/tile_runs.h"

namespace bccsplat {
OpenTile::OpenTile(const TilePlace& place, const ChunkCodes& codes, const Bcc4Chunk& entry,
                   std::span<const std::byte> bytes, ChunkScratch& scratch)
    : edge_(place.edge), boxes_(place.boxes()),
      rounded_(rounded_codes(codes, entry.min_code, entry.max_code)) {
  check_stored(entry, bytes);
  bricks_ = read_tile_runs(place, codes, entry, bytes, scratch);
  const auto values = bytes.first(entry.values_bytes);
  for (size_t c = 0; const auto& of : decode_tile(boxes_, values, entry.offset, scratch.room.walk))
    layers_.emplace_back(of, scratch.room.layers[c++]);
}

OpenTile::OpenTile(const TileSites& sites, const ChunkCodes& codes, const CodeRange& range,
                   std::vector<TileLayers> layers)
    : edge_(sites.place.edge), boxes_(sites.place.boxes()), layers_(std::move(layers)),
      rounded_(rounded_codes(codes, range[0], range[1])) {
  for (const ChunkSites& from : sites.bricks) {
    ChunkData& b = bricks_.emplace_back();
    b.shape = from.shape, b.coded = codes;
    b.kept = from.kept, b.hole = from.hole;
    find_layers(b);
  }
}

void OpenTile::make_codes(int brick, int layer, std::byte* to) const {
  const ChunkShape& shape = bricks_[brick].shape;
  const int coset = shape.coset(layer);
  const auto& n = boxes_[coset].size;
  const size_t x = brick % edge_, y = brick / edge_ % edge_, z = brick / edge_ / edge_;
  BrickRows rows{0, static_cast<size_t>(n[0]), static_cast<size_t>(n[0]) * n[1]};
  rows.first = brick_edge * (x + y * rows.row + z * rows.plane);
  const std::vector<WeighedLayer> sum = layers_[coset].sum_of(layer / shape.period);
  const BrickMask& kept = bricks_[brick].kept[layer];
  if (bricks_[brick].coded.bytes() == 1)
    sum_to_codes(sum, rows, rounded_, kept, reinterpret_cast<uint8_t*>(to));
  else
    sum_to_codes(sum, rows, rounded_, kept, reinterpret_cast<uint16_t*>(to));
}

CodeRange OpenTile::range() const {
  CodeRange all{UINT32_MAX, 0};
  std::vector<std::byte> codes;
  for (int i = 0; i < static_cast<int>(bricks_.size()); ++i) {
    const ChunkData& b = bricks_[i];
    const uint32_t each = b.coded.bytes();
    for (int m = 0; m < b.shape.layers; ++m) {
      const size_t kept = b.first[m + 1] - b.first[m];
      if (kept == 0) continue;
      codes.resize((kept + beyond_sums) * each);
      make_codes(i, m, codes.data());
      const auto [low, high] = packed_range(std::span(codes).first(kept * each), each);
      all = {std::min(all[0], low), std::max(all[1], high)};
    }
  }
  return all;
}

uint64_t OpenTile::bytes() const {
  uint64_t sum = sizeof *this;
  for (const ChunkData& b : bricks_) sum += b.bytes();
  for (const TileLayers& l : layers_) sum += l.bytes();
  return sum;
}

uint64_t OpenTile::code_bytes(uint32_t layers) const {
  uint64_t codes = 0;
  for (const ChunkData& b : bricks_)
    for (int m = 0; m < b.shape.layers; ++m)
      if (layers >> m & 1) codes += b.first[m + 1] - b.first[m];
  return codes * bricks_.front().coded.bytes();
}

} // namespace bccsplat

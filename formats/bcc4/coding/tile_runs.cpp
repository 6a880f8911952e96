// SPDX-License-Identifier: Apache-2.0
// Run lists go through the bricks of a tile one after the other.
#include "formats/bcc4/coding/tile_runs.h"

#include <bit>

#include "base/bytes.h"
#include "formats/bcc4/coding/chunk_parts.h"
#include "formats/bcc4/coding/chunk_rows.h"
#include "formats/bcc4/coding/scratch.h"
#include "formats/bcc4/coding/tile_rows.h"

namespace bccsplat {
namespace {

void read_kept(RunDecoder& occupancy, ChunkData& b) {
  b.kept.assign(b.shape.layers, BrickMask{});
  for (int m = 0; m < b.shape.layers; ++m) {
    const Int3& n = b.shape.box[m];
    if (n == Int3{brick_edge, brick_edge, brick_edge}) {
      occupancy.fill(b.kept[m]);
      continue;
    }
    for (int z = 0; z < n[2]; ++z)
      for (int y = 0; y < n[1]; ++y) b.kept[m][z * brick_edge + y] = occupancy.row(n[0]);
  }
}

void read_holes(RunDecoder& holes, ChunkData& b) {
  b.hole.assign(b.shape.layers, BrickMask{});
  for_rows(b.shape, [&](size_t m, size_t r, int) {
    const uint16_t kept = b.kept[m][r];
    b.hole[m][r] = expand_bits(holes.row(std::popcount(kept)), kept);
  });
}

} // namespace

std::vector<ChunkData> read_tile_runs(const TilePlace& place, const ChunkCodes& codes, const Bcc4Chunk& entry,
                                      std::span<const std::byte> bytes, ChunkScratch& scratch) {
  std::vector<ChunkData> bricks(place.bricks());
  for (int i = 0; i < place.bricks(); ++i) bricks[i].shape = shape_at(place, i), bricks[i].coded = codes;
  ByteReader in(open_runs(entry, bytes, scratch), "runs of the chunk", entry.offset + entry.values_bytes);
  RunDecoder occupancy(in, place.sites(), entry.kept);
  for (ChunkData& b : bricks) {
    if (b.shape.sites() > 0) read_kept(occupancy, b);
    find_layers(b);
    b.first.resize(b.shape.layers + 1, 0); // also of a brick outside
  }
  occupancy.finish();
  if (entry.holes > 0) {
    RunDecoder holes(in, entry.kept, entry.holes);
    for (ChunkData& b : bricks)
      if (b.shape.sites() > 0) read_holes(holes, b);
    holes.finish();
  }
  in.expect_end();
  return bricks;
}

} // namespace bccsplat

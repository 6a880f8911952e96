// SPDX-License-Identifier: Apache-2.0
// Codes a tile: the codes of its bricks are collected in boxes, one for each coset. Run lists go through the
// bricks one after the other.
#include <algorithm>
#include <bit>
#include <utility>

#include "base/bytes.h"
#include "formats/bcc4/coding/chunk_parts.h"
#include "formats/bcc4/coding/tile_rows.h"
#include "formats/bcc4/encode/choose_tile.h"
#include "formats/bcc4/encode/encode_tile.h"
#include "formats/bcc4/encode/tile_as_read.h"

namespace bccsplat {
namespace {

constexpr int block_edge = 4, blocks = brick_edge / block_edge; // of a block of air; along a brick
constexpr unsigned block_bits = 15;

std::vector<std::byte> tile_runs(const TileSites& sites) {
  ByteWriter out;
  RunEncoder occupancy(out);
  for (const ChunkSites& b : sites.bricks)
    for_rows(b.shape, [&](size_t m, size_t r, int width) { occupancy.row(b.kept[m][r], width); });
  occupancy.finish();
  const auto has_holes = [](const ChunkSites& b) { return !b.hole.empty(); };
  if (std::none_of(sites.bricks.begin(), sites.bricks.end(), has_holes)) return out.release();
  RunEncoder holes(out);
  for (const ChunkSites& b : sites.bricks)
    for_rows(b.shape, [&](size_t m, size_t r, int) {
      const uint16_t kept = b.kept[m][r], hole = b.hole.empty() ? uint16_t{0} : b.hole[m][r];
      holes.row(compress_bits(hole, kept), std::popcount(kept));
    });
  holes.finish();
  return out.release();
}

} // namespace

uint64_t TileSites::kept() const {
  uint64_t n = 0;
  for (const ChunkSites& b : bricks) n += b.codes.size();
  return n;
}

void keep_but_blocks_of_air(ChunkSites& sites, uint32_t air) {
  if (sites.codes.empty() || sites.codes.size() == sites.shape.sites()) return;
  // A bit for each block along x of a row of blocks, by coset.
  std::array<std::array<uint8_t, blocks * blocks>, 2> filled{};
  const auto row_of = [](size_t r) {
    return r / brick_edge / block_edge * blocks + r % brick_edge / block_edge;
  };
  for_rows(sites.shape, [&](size_t m, size_t r, int) {
    for (int b = 0; b < blocks; ++b)
      if (sites.kept[m][r] >> (b * block_edge) & block_bits)
        filled[m % sites.shape.period][row_of(r)] |= static_cast<uint8_t>(1 << b);
  });
  std::vector<uint32_t> codes;
  const uint32_t* next = sites.codes.data();
  for_rows(sites.shape, [&](size_t m, size_t r, int width) {
    unsigned kept = 0;
    for (int b = 0; b < blocks; ++b)
      if (filled[m % sites.shape.period][row_of(r)] >> b & 1) kept |= block_bits << (b * block_edge);
    kept &= (1u << width) - 1;
    for (int x = 0; x < width; ++x)
      if (kept >> x & 1) codes.push_back(sites.kept[m][r] >> x & 1 ? *next++ : air);
    sites.kept[m][r] = static_cast<uint16_t>(kept);
  });
  sites.codes = std::move(codes);
}

CosetValues tile_values(const TileSites& sites, const ChunkCodes& codes, CosetValues out) {
  const auto boxes = sites.place.boxes();
  for (size_t c = 0; c < 2; ++c) out[c].assign(boxes[c].sites(), 0);
  for (int i = 0; i < sites.place.bricks(); ++i) {
    const ChunkSites& b = sites.bricks[i];
    const uint32_t* next = b.codes.data();
    const auto value = [air = static_cast<int32_t>(codes.air)](uint32_t code) {
      return static_cast<float>(static_cast<int32_t>(code) - air);
    };
    for_tile_rows(sites.place, i, b.shape, [&](int m, int row, int width, int coset, size_t first) {
      const unsigned kept = b.kept[m][row];
      float* const to = out[coset].data() + first;
      if (kept == whole_row) {
        std::transform(next, next + brick_edge, to, value);
        next += brick_edge;
        return;
      }
      for (int x = 0; x < width; ++x)
        if (kept >> x & 1) to[x] = value(*next++);
    });
  }
  return out;
}

EncodedTile encode_tile(const TileSites& sites, const SampleCoder& coder, const TileRule& asked, int level,
                        bool linear, TileRoom& room) {
  const auto boxes = sites.place.boxes();
  CosetValues values = tile_values(sites, coder.codes(), std::move(room.values));
  std::array<TileBands, 2> bands;
  for (size_t c = 0; c < 2; ++c) {
    bands[c] = analyse_tile(boxes[c], std::move(values[c]), asked.steps.step, asked.halvings_along_z);
    if (!bands[c].coefficients.empty()) bands[c].steps = std::move(room.steps[c]);
  }
  TileRule rule = asked;
  fit_into_steps(bands, rule.steps);
  std::vector<TileLayers> layers(2);
  for (size_t c = 0; c < 2; ++c) {
    if (bands[c].coefficients.empty()) continue;
    choose_steps(bands[c], rule, room.walk); // of which all that follows is made
    if (!linear) layers[c] = TileLayers(coefficients_of(bands[c], rule.steps), room.layers[c]);
  }
  EncodedTile tile;
  const CodeRange range =
      linear ? read_linear(sites, coder, {sites, coefficients_of(bands[0], rule.steps)}, tile)
             : read_back(sites, coder, std::move(layers), tile);
  Bcc4Chunk& entry = tile.chunk.entry;
  entry.kept = static_cast<uint32_t>(sites.kept());
  for (const ChunkSites& b : sites.bricks) entry.holes += b.holes();
  entry.min_code = range[0], entry.max_code = range[1];
  const RunsPart runs = pack_runs(tile_runs(sites), level);
  std::vector<std::byte>& bytes = tile.chunk.bytes = code_tile(bands, rule.steps, room.walk);
  entry.values_bytes = static_cast<uint32_t>(bytes.size());
  finish_entry(runs, wavelet_part, tile.chunk);
  for (size_t c = 0; c < 2; ++c)
    room.values[c] = std::move(bands[c].coefficients), room.steps[c] = std::move(bands[c].steps);
  return tile;
}

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Where the boxes of a tile are, and tiles as bricks of codes.
#include "formats/bcc4/coding/tile.h"

#include <algorithm>
#include <utility>

#include "formats/bcc4/coding/open_tile.h"
#include "formats/bcc4/coding/tile_rows.h"

namespace bccsplat {
namespace {

// All codes of a brick.
ChunkData whole_brick(const OpenTile& tile, int i) {
  ChunkData b = tile.bricks()[i];
  const size_t bytes = b.coded.bytes();
  b.codes.resize((b.first.back() + beyond_sums) * bytes);
  for (int m = 0; m < b.shape.layers; ++m)
    if (b.first[m + 1] > b.first[m]) tile.make_codes(i, m, b.codes.data() + b.first[m] * bytes);
  b.codes.resize(b.first.back() * bytes);
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

uint64_t TilePlace::decoding_bytes() const {
  constexpr uint64_t of_site = 10; // a list of coefficients, what it is put together in, magnitudes
  return sites() * of_site + uint64_t(bricks()) * layers * 2 * sizeof(BrickMask);
}

ChunkData whole_tile(const OpenTile& tile) {
  ChunkData data;
  data.coded = tile.bricks().front().coded;
  for (int i = 0; i < static_cast<int>(tile.bricks().size()); ++i)
    data.bricks.push_back(std::make_shared<const ChunkData>(whole_brick(tile, i)));
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

// SPDX-License-Identifier: Apache-2.0
// What coding and decoding of tiles share: where the rows of their bricks are in the boxes, and what numbers
// are rounded to.
#pragma once

#include <array>
#include <cstdint>

#include "formats/bcc4/coding/chunk_rows.h"
#include "formats/bcc4/coding/tile.h"

namespace bccsplat {

inline ChunkShape shape_at(const TilePlace& place, int i) {
  return chunk_shape(*place.lattice, place.first_layer, place.layers, place.brick_at(i));
}

// Calls body(layer, row of the brick, width, coset, first value of the row) for the rows of brick i of a
// tile.
template<class Body>
void for_tile_rows(const TilePlace& place, int i, const ChunkShape& shape, const Body& body) {
  const auto boxes = place.boxes();
  const Int3 at = place.brick_at(i);
  std::array<size_t, 3> offset{};
  for (size_t a = 0; a < 3; ++a) offset[a] = static_cast<size_t>(at[a] - place.brick[a]) * brick_edge;
  for_rows(shape, [&](int m, int row, int width) {
    const int coset = shape.coset(m);
    const auto& n = boxes[coset].size;
    const size_t layer = m / shape.period, z = layer * n[2] + offset[2] + row / brick_edge,
                 y = z * n[1] + offset[1] + row % brick_edge;
    body(m, row, width, coset, y * n[0] + offset[0]);
  });
}

// What a reader's numbers are rounded to.
inline RoundedCodes rounded_codes(const ChunkCodes& codes, uint32_t low, uint32_t high) {
  return {static_cast<float>(codes.air), static_cast<float>(low), static_cast<float>(high)};
}

} // namespace bccsplat

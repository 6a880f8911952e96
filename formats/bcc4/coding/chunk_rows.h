// SPDX-License-Identifier: Apache-2.0
// The rows of a chunk, as its two parts are coded and decoded.
#pragma once

#include <cstddef>
#include <cstdint>

#include "formats/bcc4/coding/chunk.h"

namespace bccsplat {

// How a part of a chunk is stored.
inline constexpr uint8_t raw_part = 0, deflated_part = 1;

inline constexpr unsigned whole_row = 0xffff; // of a mask

[[nodiscard]] inline int count_bits(const BrickMask& mask) {
  // Adds up growing groups of bits, which the compiler does in vectors: not every target counts bits in
  // hardware.
  unsigned n = 0;
  for (const uint16_t row : mask) {
    unsigned v = row;
    v -= v >> 1 & 0x5555;
    v = (v & 0x3333) + (v >> 2 & 0x3333);
    v = (v + (v >> 4)) & 0x0f0f;
    n += (v + (v >> 8)) & 31;
  }
  return n;
}

// Calls body(layer, row index z*16 + y, row width) for the rows inside the domain, in coding order.
template<class Body> void for_rows(const ChunkShape& shape, Body&& body) {
  for (int m = 0; m < shape.layers; ++m) {
    const Int3& n = shape.box[m];
    for (int z = 0; z < n[2]; ++z)
      for (int y = 0; y < n[1]; ++y) body(m, z * brick_edge + y, n[0]);
  }
}

} // namespace bccsplat

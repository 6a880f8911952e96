// SPDX-License-Identifier: Apache-2.0
// Sums of weighed layers, in vectors. Targets agree to the bit: each operation is rounded, in the order of
// the layers, from 0 on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "points/brick.h"

namespace bccsplat {

struct WeighedLayer {
  const float* first;
  float weight;
};
// Writes the sums of `count` values of each layer, from the one at `begin` on.
void sum_layers(std::span<const WeighedLayer> layers, size_t begin, size_t count, float* to);

// What numbers are rounded to: whole codes of u8 or u16 in a range.
struct RoundedCodes {
  float air = 0, low = 0, high = 0;
};
// Rows of a brick in a box: its first one, and how far apart rows and planes are.
struct BrickRows {
  size_t first = 0, row = 0, plane = 0;
};
inline constexpr size_t beyond_sums =
    brick_edge; // values that may be read, and codes written, beyond the last
// Writes the codes of the kept sites of a brick; returns behind the last one.
uint8_t* sum_to_codes(std::span<const WeighedLayer> layers, const BrickRows& rows, const RoundedCodes& codes,
                      const BrickMask& kept, uint8_t* to);
uint16_t* sum_to_codes(std::span<const WeighedLayer> layers, const BrickRows& rows, const RoundedCodes& codes,
                       const BrickMask& kept, uint16_t* to);

} // namespace bccsplat

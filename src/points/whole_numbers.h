// SPDX-License-Identifier: Apache-2.0
// The values of a brick as whole numbers of a power of two, of 12 or 16 bits each: less than half of the
// memory of floats, where what is lost by it is nothing beside the rounding to the stored type.
//
// Numbers count from the smallest one of the brick, so that how far it is from air matters as little as the
// range of other bricks. A plane of 256 sites has its low bytes first, then the high ones, which at 12 bits
// row y shares with row y + 8.
#pragma once

#include <cstddef>
#include <cstdint>

#include "points/brick.h"
#include "points/sample_layer.h"

namespace bccsplat {

// value = step * (first + number). bits: 12, 16, or 0 where the values fit neither.
struct NumberForm {
  float step = 1; // a power of two, so that every value is exact in single precision
  int32_t first = 0;
  int bits = 0;
};

// Bytes of a brick's numbers, with those behind the last row that may be read.
[[nodiscard]] constexpr size_t number_bytes(int bits) {
  return static_cast<size_t>(brick_sites) * static_cast<size_t>(bits) / 8 + brick_edge;
}

// Returns the form of fewest bits in which the size[0] x size[1] x size[2] first values fit, and of that the
// one of the smallest step. finest, coarsest: powers of two, the first at most the second.
[[nodiscard]] NumberForm number_form(const float* values, const Int3& size, float finest, float coarsest);

// Rounds to nearest, halves to even. values: aligned to 64 bytes; what did not have to fit becomes any
// number.
void write_numbers(const NumberForm& form, const float* values, uint8_t* to);

// Writes values in rows `stride` apart; behind rows of fewer than 16 sites up to 15 more are written.
void read_numbers(const NumberForm& form, const uint8_t* from, const PlanePart& part, float* to,
                  std::ptrdiff_t stride);

} // namespace bccsplat

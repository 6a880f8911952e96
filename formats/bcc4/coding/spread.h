// SPDX-License-Identifier: Apache-2.0
// Puts the values of kept sites at their places in a brick.
#pragma once

#include <cstddef>
#include <span>

#include "formats/bcc4/coding/codes.h"
#include "points/brick.h"
#include "points/runs.h"
#include "points/sample_layer.h"

namespace bccsplat {

// `codes` are the packed codes of a chunk, of which those of this brick's kept sites start at index `first`.
// All of `brick` is written, 0 where no site is kept.
void spread_codes(const SampleCoder& coder, const BrickMask& kept, std::span<const std::byte> codes,
                  size_t first, std::span<float, brick_sites> brick);

// The codes of a brick of integers.
struct BrickCodes {
  static constexpr size_t beside = 2 * brick_edge; // codes of any value before the first and behind the last
  const std::byte* codes;                          // the first
  const BrickMask* kept;                           // null: all sites
  const RowIndex* first;                           // code of each row; null where all sites are kept
};
// Writes some of its sites as CodedBrick::read does.
void spread_part(const SampleCoder& coder, const BrickCodes& brick, const PlanePart& part, float* to,
                 std::ptrdiff_t stride);

} // namespace bccsplat

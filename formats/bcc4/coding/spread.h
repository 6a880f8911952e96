// Puts the values of kept sites at their places in a brick.
#pragma once

#include <cstddef>
#include <span>

#include "formats/bcc4/coding/codes.h"
#include "points/brick.h"

namespace bccsplat {

// `codes` are the packed codes of a chunk, coded as `coded`, of which those of this brick's kept sites start
// at index `first`. All of `brick` is written, 0 where no site is kept.
void spread_codes(const SampleCoder& coder, const ChunkCodes& coded, const BrickMask& kept,
                  std::span<const std::byte> codes, size_t first, std::span<float, brick_sites> brick);

} // namespace bccsplat

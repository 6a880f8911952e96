// Puts the values of kept sites at their places in a brick.
#pragma once

#include <cstddef>
#include <span>

#include "formats/bcc4/coding/codes.h"
#include "points/brick.h"

namespace bccsplat {

// `codes` are packed codes, coded as `coded`, of which those of the kept sites of some rows of a brick start
// at index `first`. All sixteen sites of each row are written, rows `stride` apart, 0 where none is kept.
void spread_codes(const SampleCoder& coder, const ChunkCodes& coded, std::span<const uint16_t> kept,
                  std::span<const std::byte> codes, size_t first, float* rows,
                  std::ptrdiff_t stride = brick_edge);

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Where a block of a file is, and how it is coded.
#pragma once

#include <cstdint>

#include "base/byte_range.h"

namespace bccsplat {

// A block: bytes at a multiple of 8, zeros up to the next multiple; the checksum covers the zeros too.
struct BlockRef {
  uint64_t offset = 0;
  uint32_t stored = 0; // without the zeros
  uint32_t decoded = 0;
  uint32_t crc = 0;
  uint32_t coding = 0; // 0 raw, 1 deflate
  [[nodiscard]] uint64_t padded() const { return (uint64_t{stored} + 7) / 8 * 8; }
  [[nodiscard]] ByteRange range() const { return {offset, padded()}; }
  bool operator==(const BlockRef&) const = default;
};

} // namespace bccsplat

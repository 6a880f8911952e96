// SPDX-License-Identifier: Apache-2.0
// A series of frames larger than memory, written in blocks of space by a host that makes each sample when it
// is asked for: neither a frame nor the source is ever held.
#pragma once

#include <cstdint>
#include <string>

#include "tests/bench/report.h"

namespace bccsplat::bench {

struct BlockSeries {
  uint32_t n = 64, frames = 4, levels = 0;
  uint32_t pieces = 4; // along z, and half as many along y
};

// Reads "N,FRAMES,LEVELS,PIECES"; throws Error.
[[nodiscard]] BlockSeries parse_block_series(const std::string& text);

// Writes n^3 x frames samples of u8, a blob with waves that moves through air, block by block beside `path`,
// joins them to `path`, and reports CPU time, memory and bytes.
void write_block_series(const Report& report, const BlockSeries& series, const std::string& path);

} // namespace bccsplat::bench

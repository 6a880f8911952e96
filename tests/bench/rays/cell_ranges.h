// SPDX-License-Identifier: Apache-2.0
// Between which values the field of a slice on BCC lies in each cell of the plane grid (edge 1/sqrt2),
// proven, whatever value a surface is wanted of.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "field/slice.h"
#include "tests/bench/rays/cell_bound.h"

namespace bccsplat::bench {

inline constexpr int block_edge = 4; // cells

// The cells of a block, x fastest: low + scale * byte, rounded outward. Relative to the base.
struct BlockRanges {
  float low = 0, high = 0, scale = 0;
  alignas(64) std::array<uint8_t, 64> from{}, to{};
};

struct CellRanges {
  Int3 cells{}, blocks{};
  std::vector<int32_t> of_block; // -1: nothing but the base
  std::vector<BlockRanges> ranges;
  [[nodiscard]] uint64_t bytes() const {
    return of_block.size() * sizeof(int32_t) + ranges.size() * sizeof(BlockRanges);
  }
};

// parts: 1 looks at the corners of the cells, 2 at those of their eighths. The kernel's radius is at most 2.
[[nodiscard]] CellRanges make_cell_ranges(const Slice& slice, int parts, const CellBound& bound);

} // namespace bccsplat::bench

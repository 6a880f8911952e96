// SPDX-License-Identifier: Apache-2.0
// Makes few rectangular boxes of the scattered blocks of a sparse grid.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace bcc4 {

// A box, counted in blocks.
struct BlockBox {
  std::array<int32_t, 3> begin{};
  std::array<int32_t, 3> dims{};
};

// Makes boxes so that every block of `blocks` (each within [0, extent), given once or more) lies in exactly
// one box, and a box holds no other block. It is greedy: boxes grow along x, then y, then z, up to `side`
// blocks. It takes one bit of memory per block of the extent.
[[nodiscard]] std::vector<BlockBox> merge_blocks(const std::vector<std::array<int32_t, 3>>& blocks,
                                                 const std::array<int32_t, 3>& extent, int32_t side);

} // namespace bcc4

// Scattered blocks of a sparse grid -> few rectangular boxes.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace bcc4 {

// In blocks.
struct BlockBox {
  std::array<int32_t, 3> begin{};
  std::array<int32_t, 3> dims{};
};

// Every block of `blocks` (each within [0, extent), given once or more) lies in exactly one box, and a box
// holds no other block. Greedy: boxes grow along x, then y, then z, up to `side` blocks. Memory: one bit per
// block of the extent.
[[nodiscard]] std::vector<BlockBox> merge_blocks(const std::vector<std::array<int32_t, 3>>& blocks,
                                                 const std::array<int32_t, 3>& extent, int32_t side);

} // namespace bcc4

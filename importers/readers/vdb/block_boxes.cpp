// SPDX-License-Identifier: Apache-2.0
#include "readers/vdb/block_boxes.h"

#include <algorithm>
#include <cstddef>

namespace bcc4 {

std::vector<BlockBox> merge_blocks(const std::vector<std::array<int32_t, 3>>& blocks,
                                   const std::array<int32_t, 3>& extent, int32_t side) {
  const size_t nx = extent[0], ny = extent[1], nz = extent[2];
  std::vector<bool> left(nx * ny * nz);
  const auto index = [&](int32_t x, int32_t y, int32_t z) { return (z * ny + y) * nx + x; };
  for (const auto& b : blocks) left[index(b[0], b[1], b[2])] = true;
  std::vector<std::array<int32_t, 3>> order = blocks;
  std::sort(order.begin(), order.end(), [](const auto& a, const auto& b) {
    return std::array{a[2], a[1], a[0]} < std::array{b[2], b[1], b[0]};
  });

  std::vector<BlockBox> boxes;
  for (const std::array<int32_t, 3>& first : order) {
    const int32_t x0 = first[0], y0 = first[1],
                  z0 = first[2]; // lambdas of C++20 take no bindings in clang 14
    if (!left[index(x0, y0, z0)]) continue;
    const auto row_is_left = [&](int32_t x1, int32_t y, int32_t z) {
      for (int32_t x = x0; x < x1; ++x)
        if (!left[index(x, y, z)]) return false;
      return true;
    };
    int32_t x1 = x0 + 1, y1 = y0 + 1, z1 = z0 + 1;
    while (x1 < extent[0] && x1 - x0 < side && left[index(x1, y0, z0)]) ++x1;
    while (y1 < extent[1] && y1 - y0 < side && row_is_left(x1, y1, z0)) ++y1;
    const auto layer_is_left = [&](int32_t z) {
      for (int32_t y = y0; y < y1; ++y)
        if (!row_is_left(x1, y, z)) return false;
      return true;
    };
    while (z1 < extent[2] && z1 - z0 < side && layer_is_left(z1)) ++z1;
    for (int32_t z = z0; z < z1; ++z)
      for (int32_t y = y0; y < y1; ++y)
        for (int32_t x = x0; x < x1; ++x) left[index(x, y, z)] = false;
    boxes.push_back({{x0, y0, z0}, {x1 - x0, y1 - y0, z1 - z0}});
  }
  return boxes;
}

} // namespace bcc4

// SPDX-License-Identifier: Apache-2.0
#include "splat/points/cell_ranges.h"

#include <algorithm>
#include <cstring>

namespace bccsplat {

void gather_cells(const std::vector<BrickCells>& cells, const SlotSet& touched, const Int3& dims,
                  const Int3& at, int edge, CellCube& cube) {
  constexpr int margin = CellCube::margin;
  cube.low.fill(0), cube.high.fill(0);
  const int far = (margin + edge - 1) / edge; // bricks
  const auto begin = [&](size_t a) { return std::max(-far, -at[a]); };
  const auto end = [&](size_t a) { return std::min(far, dims[a] - 1 - at[a]); };
  for (int bz = begin(2); bz <= end(2); ++bz)
    for (int by = begin(1); by <= end(1); ++by)
      for (int bx = begin(0); bx <= end(0); ++bx) {
        const Int3 slot{at[0] + bx, at[1] + by, at[2] + bz};
        const int64_t number =
            touched.number((static_cast<int64_t>(slot[2]) * dims[1] + slot[1]) * dims[0] + slot[0]);
        if (number < 0) continue;
        const BrickCells& from = cells[number];
        for (int z = std::max(0, -margin - bz * edge); z < std::min(edge, (1 - bz) * edge + margin); ++z)
          for (int y = std::max(0, -margin - by * edge); y < std::min(edge, (1 - by) * edge + margin); ++y) {
            const size_t to = CellCube::at(bx * edge, by * edge + y, bz * edge + z);
            const size_t row = y << 2 | z << 4;
            const auto copy = [&](auto& out, const auto& in) {
              if (edge == 4)
                std::memcpy(out.data() + to, in.data() + row, 4 * sizeof(float));
              else
                std::memcpy(out.data() + to, in.data() + row, 2 * sizeof(float));
            };
            copy(cube.low, from.low), copy(cube.high, from.high);
          }
      }
}

void widen_cells_reference(CellCube& cube, const WidenedCells& out) {
  for (size_t r = 0; r < out.size(); ++r) {
    const int reach = SplatPoints::cell_reach[r];
    for (int z = 0; z < 4; ++z)
      for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x) {
          CellRange range{cube.low[CellCube::at(x, y, z)], cube.high[CellCube::at(x, y, z)]};
          for (int dz = -reach; dz <= reach; ++dz)
            for (int dy = -reach; dy <= reach; ++dy)
              for (int dx = -reach; dx <= reach; ++dx) {
                const size_t n = CellCube::at(x + dx, y + dy, z + dz);
                range = {std::min(range.low, cube.low[n]), std::max(range.high, cube.high[n])};
              }
          out[r][x | y << 2 | z << 4] = range;
        }
  }
}

} // namespace bccsplat

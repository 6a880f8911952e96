// SPDX-License-Identifier: Apache-2.0
// The range of coefficients around each cell of a brick, from the cells of the bricks beside it.
#pragma once

#include <array>
#include <vector>

#include "splat/points/brick_sites.h"

namespace bccsplat {

// The cells of a brick and of those around it: rows of 16 along x, of which the brick's begin at `before`;
// `margin` cells beyond it are asked for along each axis.
struct CellCube {
  static constexpr int margin = SplatPoints::cell_reach.back(), side = 4 + 2 * margin, before = 4, pitch = 16;
  using Field = std::array<float, (side * side + 2) * pitch>; // a row to spare on either side
  alignas(64) Field low, high;

  // Returns the index of cell (x, y, z), counted from the brick's first; x is in -before .. pitch - before -
  // 1, y and z from -margin on.
  [[nodiscard]] static constexpr size_t at(int x, int y, int z) {
    return ((z + margin) * side + y + margin + 1) * pitch + x + before;
  }
};

// Fills the cube around the brick at slot `at`. `cells` are those of the bricks among `touched`, by their
// numbers; edge is the number of cells per brick and axis, 4 or 2.
void gather_cells(const std::vector<BrickCells>& cells, const SlotSet& touched, const Int3& dims,
                  const Int3& at, int edge, CellCube& cube);

// For each reach of SplatPoints::cell_reach (1, 2, 3), both write the ranges of the brick's 64 cells over
// those at most as many cells away along every axis: the reference loop, and the best target of this machine,
// which spoils the cube.
using WidenedCells = std::array<CellRange*, SplatPoints::cell_reach.size()>;
void widen_cells_reference(CellCube& cube, const WidenedCells& out);
void widen_cells(CellCube& cube, const WidenedCells& out);

} // namespace bccsplat

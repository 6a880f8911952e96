// SPDX-License-Identifier: Apache-2.0
// How large the coefficients in cells of 2^3 planes are, and from that which points are near enough to one
// that a picture may show.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "splat/points/points.h"

namespace bccsplat {

// One bit per fine cell of a brick: word z >> 1, bit x >> 1 | y >> 1 << 3 of the local planes.
using FineCells = std::array<uint64_t, 8>;

[[nodiscard]] inline unsigned fine_cell(unsigned position) {
  return (position >> 1 & 7u) | (position >> 2 & 56u) | (position >> 3 & 448u);
}

// Returns the cells of a brick that hold a point whose code is at least `least`, 1 .. 127.
[[nodiscard]] FineCells cells_from(const uint8_t* codes, uint8_t least);

// The neighbourhood of one brick: rows of cells along x as bits, `margin` cells beyond the brick on all
// sides.
struct FineCube {
  static constexpr int margin = 4, side = 8 + 2 * margin;
  std::array<uint16_t, side * side> row{}; // [z][y], bit x

  // Adds the cells of a brick `at` bricks away (-1, 0, 1 along each axis); edge: fine cells per brick.
  void add(const FineCells& cells, const Int3& at, int edge);
};

// Cells whose points may be closer than a distance: for each row of a neighbourhood, how many cells to either
// side along x; -1: none.
struct FineBall {
  static constexpr int side = 2 * FineCube::margin + 1;
  std::array<int, side * side> reach{}; // [z][y], from -margin on
};
// The distance is at most farthest(); plane_distance is lattice units between planes.
[[nodiscard]] FineBall make_ball(double distance, double plane_distance);
[[nodiscard]] double farthest(double plane_distance);

// Both return the cells of the brick in the middle of `cube` that a ball around some cell of the cube meets:
// the reference loop, and the best target of this machine.
[[nodiscard]] FineCells cells_within_reference(const FineCube& cube, const FineBall& ball);
[[nodiscard]] FineCells cells_within(const FineCube& cube, const FineBall& ball);

// Both copy the points of a brick that are in those cells, in their order, and return how many there are.
// There must be room for all points of the brick.
uint32_t take_points_reference(const SplatPoints& points, const SplatBrick& brick, const FineCells& cells,
                               uint16_t* position, float* coefficient);
uint32_t take_points(const SplatPoints& points, const SplatBrick& brick, const FineCells& cells,
                     uint16_t* position, float* coefficient);

} // namespace bccsplat

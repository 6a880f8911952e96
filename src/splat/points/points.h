// SPDX-License-Identifier: Apache-2.0
// The points of a slice as the splatter reads them: bricks of compact points, mirror images included.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "base/context.h"
#include "field/slice.h"

namespace bccsplat {

// A cube of planes of the lattice, both cosets together: 16^3 planes of BCC (up to 1024 points, 11.3 T wide),
// 8^3 of CC.
struct SplatBrick {
  Int3 plane{};                         // plane numbers of the local origin
  uint32_t first = 0, count = 0;        // its points
  std::array<uint8_t, 3> low{}, high{}; // local planes its points stand on, inclusive
  float coefficient[2] = {0, 0};        // smallest and largest of its points, and 0
  float reach[2] = {0, 0};              // the same over its 27-neighbourhood
};

// The smallest and the largest coefficient of the sites in and around a cell of 4^3 planes, and 0 where any
// of these is no point.
struct CellRange {
  float low = 0, high = 0;
};
inline constexpr int cells_per_brick = 64; // local planes x >> 2 | y >> 2 << 2 | z >> 2 << 4

struct SplatPoints {
  double plane_distance = 0;      // lattice units between planes
  int margin = 0;                 // planes of mirror images beyond the domain
  int edge = 0;                   // planes per brick
  Int3 dims{};                    // bricks
  std::vector<SplatBrick> bricks; // those that hold points, x fastest
  uint32_t count = 0;
  std::vector<uint16_t> position; // local planes x | y << 4 | z << 8; spare entries at the end, so
                                  // that vectors may read over it
  std::vector<float> coefficient; // relative to the base of the field
  // Per brick and cell, over the cells at most cell_reach[n] cells away along every axis.
  static constexpr std::array<int, 3> cell_reach{1, 2, 3};
  std::array<std::vector<CellRange>, 3> cells;
  // Per brick, its fine cells of 2^3 planes (point_sizes.h): the code of the largest |coefficient| in them.
  // Codes rise with |coefficient| / code_unit by 8 steps per octave; 0: no point, or hardly one.
  static constexpr size_t fine_cells = 512;
  static constexpr int most_code = 127;
  static constexpr int code_shift = 20;           // three bits of the mantissa are kept
  static constexpr uint32_t code_zero = 111 << 3; // exponent and mantissa of 2^-16, shifted
  std::vector<uint8_t> codes;                     // empty: nothing is known of them
  float code_unit = 1;
  Reservation memory;

  [[nodiscard]] uint8_t code(float c) const;
  // Coefficients with codes below n are smaller than this, in magnitude.
  [[nodiscard]] float code_begin(int n) const;

  // Number of a brick among dims, x fastest.
  [[nodiscard]] size_t slot(const SplatBrick& b) const {
    const auto n = [&](size_t a) { return static_cast<size_t>((b.plane[a] + margin) / edge); };
    return (n(2) * dims[1] + n(1)) * dims[0] + n(0);
  }
  // Lattice position of a point.
  [[nodiscard]] Vec3 at(const SplatBrick& b, uint32_t n) const {
    const uint16_t p = position[n];
    return {plane_distance * (b.plane[0] + (p & 15)), plane_distance * (b.plane[1] + (p >> 4 & 15)),
            plane_distance * (b.plane[2] + (p >> 8 & 15))};
  }
};

// Makes the points within a kernel radius and two T (gradients look beyond the ends) of the box that is
// drawn, in an order that depends on the lattice only: bricks with x fastest, points of a brick in a fixed
// shuffle (neighbours in the list then fall on different sheets and pixels, and updates of the same
// accumulator do not follow each other).
[[nodiscard]] SplatPoints make_points(const Slice& slice, const Context& context);

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
#include "splat/points/point_sizes.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace bccsplat {
namespace {

// Planes between the points of two cells `n` cells apart, at least.
double planes_between(int n) { return n == 0 ? 0.0 : 2.0 * std::abs(n) - 1; }

} // namespace

FineCells cells_from(const uint8_t* codes, uint8_t least) {
  // A byte's highest bit says whether it is at least `least`; a product brings the eight bits together.
  const uint64_t ones = 0x0101010101010101u, add = ones * (128u - least);
  FineCells cells{};
  for (size_t z = 0; z < 8; ++z)
    for (size_t y = 0; y < 8; ++y) {
      uint64_t row;
      std::memcpy(&row, codes + 64 * z + 8 * y, 8);
      const uint64_t high = (row + add) >> 7 & ones;
      cells[z] |= (high * 0x0102040810204080u >> 56) << (8 * y);
    }
  return cells;
}

void FineCube::add(const FineCells& cells, const Int3& at, int edge) {
  const auto first = [&](size_t a) { return at[a] * edge + margin; };
  const auto begin = [&](size_t a) { return std::max(0, -first(a)); };
  const auto end = [&](size_t a) { return std::min(edge, side - first(a)); };
  const uint64_t columns = (uint64_t{1} << edge) - 1;
  const int x = first(0);
  for (int z = begin(2); z < end(2); ++z) {
    const uint64_t rows = cells[z];
    if (rows == 0) continue;
    for (int y = begin(1); y < end(1); ++y) {
      const uint64_t bits = rows >> (8 * y) & columns;
      uint16_t& to = row[(first(2) + z) * side + first(1) + y];
      to = static_cast<uint16_t>(to | (x >= 0 ? bits << x : bits >> -x));
    }
  }
}

double farthest(double plane_distance) {
  return planes_between(FineCube::margin + 1) * plane_distance * (1 - 1e-9);
}

FineBall make_ball(double distance, double plane_distance) {
  constexpr int margin = FineCube::margin;
  const double square = distance / plane_distance * (distance / plane_distance) * (1 + 1e-9);
  FineBall ball;
  for (int z = -margin; z <= margin; ++z)
    for (int y = -margin; y <= margin; ++y) {
      int& reach = ball.reach[(z + margin) * FineBall::side + y + margin];
      reach = -1;
      const double left =
          square - planes_between(z) * planes_between(z) - planes_between(y) * planes_between(y);
      while (reach < margin && planes_between(reach + 1) * planes_between(reach + 1) <= left) ++reach;
    }
  return ball;
}

FineCells cells_within_reference(const FineCube& cube, const FineBall& ball) {
  constexpr int margin = FineCube::margin, side = FineCube::side;
  const auto large = [&](int x, int y, int z) {
    const bool inside = x >= 0 && x < side && y >= 0 && y < side && z >= 0 && z < side;
    return inside && (cube.row[z * side + y] >> x & 1);
  };
  FineCells cells{};
  for (int z = 0; z < 8; ++z)
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x) {
        bool near = false;
        for (int dz = 0; dz < FineBall::side; ++dz)
          for (int dy = 0; dy < FineBall::side; ++dy) {
            const int reach = ball.reach[dz * FineBall::side + dy];
            for (int dx = -reach; dx <= reach; ++dx) near = near || large(x + margin + dx, y + dy, z + dz);
          }
        cells[z] |= uint64_t{near} << (x | y << 3);
      }
  return cells;
}

uint32_t take_points_reference(const SplatPoints& points, const SplatBrick& brick, const FineCells& cells,
                               uint16_t* position, float* coefficient) {
  const uint16_t* const from = points.position.data() + brick.first;
  const float* const c = points.coefficient.data() + brick.first;
  uint32_t count = 0;
  for (uint32_t n = 0; n < brick.count; ++n) {
    const unsigned cell = fine_cell(from[n]);
    position[count] = from[n], coefficient[count] = c[n];
    count += static_cast<uint32_t>(cells[cell >> 6] >> (cell & 63) & 1);
  }
  return count;
}

} // namespace bccsplat

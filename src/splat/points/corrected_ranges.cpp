// SPDX-License-Identifier: Apache-2.0
#include "splat/points/corrected_ranges.h"

#include <algorithm>
#include <cmath>

namespace bccsplat {
namespace {

// Ranges are of coefficients, corrections are values: the sum of kernel weights that lies between them is no
// less than the inverse of this (plan_cells.h).
constexpr float per_least_weight = 1.125f;
constexpr double rounding = 1e-3; // planes

} // namespace

void widen_by_corrections(const Slice& slice, SplatPoints& points) {
  points.codes.clear();
  size_t slots = 1;
  for (const int n : points.dims) slots *= n;
  std::vector<std::array<float, 2>> range(slots); // by slot
  const Affine3 to_lattice = slice.lattice_to_slice.inverse();
  // Samples near a brick look at the bricks and cells around it.
  const int around = std::max(points.edge, 4 * SplatPoints::cell_reach.back());
  for (const SparseGrid::Brick& c : slice.corrections->add.bricks()) {
    std::array<std::array<int, 2>, 3> bricks; // along each axis
    for (size_t a = 0; a < 3; ++a) {
      const double per = to_lattice.linear[a][a] / points.plane_distance,
                   from = to_lattice.point(slice.corrections->origin)[a] / points.plane_distance;
      const auto brick = [&](double plane) {
        return std::clamp(static_cast<int>(std::floor((plane + points.margin) / points.edge)), 0,
                          points.dims[a] - 1);
      };
      bricks[a] = {brick(from + per * (c.begin[a] - 1.0) - around - rounding),
                   brick(from + per * (c.begin[a] + SparseGrid::edge) + around + rounding)};
    }
    for (int z = bricks[2][0]; z <= bricks[2][1]; ++z)
      for (int y = bricks[1][0]; y <= bricks[1][1]; ++y)
        for (int x = bricks[0][0]; x <= bricks[0][1]; ++x) {
          auto& r = range[(z * points.dims[1] + y) * points.dims[0] + x];
          r = {std::min(r[0], per_least_weight * c.low), std::max(r[1], per_least_weight * c.high)};
        }
  }
  for (size_t n = 0; n < points.bricks.size(); ++n) {
    SplatBrick& b = points.bricks[n];
    const auto [low, high] = range[points.slot(b)];
    b.reach[0] += low, b.reach[1] += high;
    for (auto& cells : points.cells)
      for (size_t k = n * cells_per_brick; k < (n + 1) * cells_per_brick; ++k)
        cells[k].low += low, cells[k].high += high;
  }
}

} // namespace bccsplat

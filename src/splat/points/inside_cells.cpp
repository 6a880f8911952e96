// SPDX-License-Identifier: Apache-2.0
#include "splat/points/inside_cells.h"

namespace bccsplat {

bool InsideCells::contains(const Vec3& p) const {
  const double per_plane = 1 / points->plane_distance;
  int brick[3], cell[3];
  for (size_t a = 0; a < 3; ++a) {
    const double plane = p[a] * per_plane + points->margin;
    if (!(plane >= 0 && plane < points->dims[a] * points->edge)) return false;
    const int n = static_cast<int>(plane);
    brick[a] = n / points->edge, cell[a] = n % points->edge >> 2;
  }
  const int slot = (brick[2] * points->dims[1] + brick[1]) * points->dims[0] + brick[0];
  return cells[slot] >> (cell[0] | cell[1] << 2 | cell[2] << 4) & 1;
}

} // namespace bccsplat

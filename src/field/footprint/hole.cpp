// SPDX-License-Identifier: Apache-2.0
#include "field/footprint/hole.h"

#include <cmath>
#include <limits>

namespace bccsplat {

bool is_hole_at(std::array<const BrickLayer*, 2> layers, const Vec3& p) {
  double best = std::numeric_limits<double>::infinity();
  bool hole = false;
  for (const BrickLayer* layer : layers) {
    if (!layer) continue;
    const Lattice3& lattice = layer->lattice();
    const double d = lattice.plane_distance();
    const int c = layer->coset();
    Int3 i;
    Vec3 v;
    for (size_t a = 0; a < 3; ++a) {
      const double h = p[a] / d;
      const auto near = static_cast<int32_t>(std::lround(lattice.bcc ? (h - c) / 2 : h));
      v[a] = p[a] - d * lattice.plane(c, near);
      i[a] = lattice.mirror(a, c, near);
    }
    const double r2 = dot(v, v);
    if (r2 >= best) continue;
    best = r2;
    const Brick* b = layer->brick(i[0] / brick_edge, i[1] / brick_edge, i[2] / brick_edge);
    hole = b &&
           b->is_hole((i[2] % brick_edge * brick_edge + i[1] % brick_edge) * brick_edge + i[0] % brick_edge);
  }
  return hole;
}

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
#include "fit/axis/site_axis.h"

#include <algorithm>
#include <cmath>

namespace bccsplat {

std::vector<double> site_positions(const Lattice4& lattice, int coset, size_t axis) {
  const double end = lattice.domain_end(axis);
  std::vector<double> positions;
  for (int32_t i = 0; i < lattice.space.dims(coset)[axis]; ++i)
    positions.push_back((lattice.space.plane(coset, i) - lattice.before[axis]) * end /
                        lattice.inner_planes(axis));
  return positions;
}

int64_t nearest_sample(double position, int64_t n) {
  return std::clamp<int64_t>(static_cast<int64_t>(std::floor(position + 0.5)), 0, n - 1);
}

} // namespace bccsplat

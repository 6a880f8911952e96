// SPDX-License-Identifier: Apache-2.0
#include "slice/plane_spacing.h"

#include <algorithm>
#include <cmath>

#include "slice/even_slice.h"

namespace bccsplat {

double plane_refinement(const UnevenAxes& axes, const Vec4& direction) {
  double most = 1;
  for (size_t a = 0; a < 3; ++a)
    if (axes.uneven(a)) most = std::max(most, std::fabs(direction[a]) * wanted_refinement(axes, a));
  return most;
}

Vec3 plane_spacings(const Lattice4& lattice, const HypersliceOptions& options, const PlaneAxes& axes) {
  Vec3 spacing;
  for (size_t k = 0; k < 3; ++k) {
    const double density = lattice_density(lattice, axes.basis[k]);
    spacing[k] = options.spacing > 0 ? options.spacing : 1 / std::max(density, 1.0);
    if (options.even && options.spacing == 0)
      spacing[k] /= std::min(plane_refinement(*options.even, axes.basis[k]), most_refined);
  }
  return spacing;
}

double slice_margin(const Slice& slice, double unit) {
  return unit * (slice.kernel.space.radius +
                 (prefilter_reach(slice.kernel.prefilter3).space + 2) * slice.lattice.plane_distance());
}

} // namespace bccsplat

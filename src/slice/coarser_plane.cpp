// SPDX-License-Identifier: Apache-2.0
#include "slice/coarser_plane.h"

#include <algorithm>

#include "slice/lowpass_slice.h"
#include "slice/plane_spacing.h"

namespace bccsplat {
namespace {

// A spacing this much larger than the volume's own asks for a low pass.
constexpr double coarser_by = 1.02;

} // namespace

bool coarser_plane(const Lattice4& lattice, const HypersliceOptions& options, const PlaneAxes& axes) {
  if (options.spacing == 0 || options.bandwidth) return false;
  HypersliceOptions own = options;
  own.spacing = 0;
  const Vec3 finest = plane_spacings(lattice, own, axes);
  return std::any_of(finest.begin(), finest.end(),
                     [&](double s) { return options.spacing > coarser_by * s; });
}

std::vector<BrickLayer> lowpassed_plane(Slice& slice, const Slice& fine, const Lattice4& lattice,
                                        const HypersliceOptions& options, const Context& context) {
  const PlaneAxes axes{slice.origin, slice.basis};
  HypersliceOptions own = options;
  own.spacing = 0;
  const Vec3 coarse = plane_spacings(lattice, options, axes), finest = plane_spacings(lattice, own, axes);
  Vec3 unit;
  for (size_t a = 0; a < 3; ++a) unit[a] = std::max(coarse[a], finest[a]);
  const double margin = slice_margin(slice, *std::max_element(unit.begin(), unit.end()));
  const auto near = [&](const Vec3& uvw) {
    for (size_t i = 0; i < 4; ++i) {
      double p = slice.origin[i];
      for (size_t k = 0; k < 3; ++k) p += uvw[k] * slice.basis[k][i];
      if (p < -margin || p > lattice.domain_end(i) + margin) return false;
    }
    return true;
  };
  slice.base = fine.base, slice.air = fine.air, slice.has_holes = fine.has_holes;
  return lowpassed_samples(fine, slice, unit, near, context);
}

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Any hyperplane, resampled: the 4D field evaluated at the sites of a BCC (or CC) lattice in the hyperplane,
// then the 3D prefilter, so that the slice's own reconstruction interpolates those values.
#pragma once

#include <memory>
#include <optional>

#include "base/context.h"
#include "field/coefficients/coefficients.h"
#include "field/slice.h"
#include "points/uneven_axes.h"
#include "slice/plane_geometry.h"
#include "slice/thickness.h"

namespace bccsplat {

struct PlaneOptions {
  // The distance of the target lattice, in index units; 0: along each of its axes that of the source's
  // samples, or less where the volume's lattice is finer. What is coarser than that is low-passed
  // (lowpass_slice.h).
  double spacing = 0;
  double time_length = 1;                // world units that one frame is drawn as
  LatticeKind target = LatticeKind::bcc; // or cc
  // Means, sums and maxima come from Gauss-Legendre quadrature along the normal at each site, clipped to the
  // domain.
  Thickness thickness;
  // Values are those of equation (6) of the paper with these bandwidths (gaussian_mean.h), with its kernel
  // and without a thickness; none: those of the field.
  std::optional<Vec4> bandwidth;
  std::optional<PlaneAxes> axes; // slice space; none: plane_axes of the hyperplane
  // The hyperplane and slice space are of even positions along these axes: the field is evaluated point by
  // point, without a thickness, and the lattice is finer where it runs along them (even_slice.h). Null: none.
  std::shared_ptr<const UnevenAxes> even;
};

// The hyperplane is its unit normal (a, b, c, d) and e in index space, t in frames. World space of the slice
// keeps the lengths and angles that directions have in the volume's world with time as a fourth, orthogonal
// axis. A hyperplane that misses the domain gives an empty slice. Only bricks in reach of the thickness
// around the hyperplane are read.
[[nodiscard]] Slice plane_slice(const Coefficients& coefficients, const Hyperplane& hyperplane,
                                const PlaneOptions& options, const Affine3& index_to_world,
                                const Context& context);

// Returns the place, domain and lattice of such a slice without any points.
[[nodiscard]] Slice bare_plane(const Coefficients& coefficients, const Hyperplane& hyperplane,
                               const PlaneOptions& options, const Affine3& index_to_world);

// Asks the samples for all that plane_slice would ask for, and makes nothing of it.
void rehearse_plane_slice(const Coefficients& coefficients, const Hyperplane& hyperplane,
                          const PlaneOptions& options, const Context& context);

} // namespace bccsplat

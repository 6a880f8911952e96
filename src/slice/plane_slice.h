// SPDX-License-Identifier: Apache-2.0
// Any hyperplane, resampled: the 4D field evaluated at the sites of a BCC (or CC) lattice in the hyperplane,
// then the 3D prefilter, so that the slice's own reconstruction interpolates those values.
#pragma once

#include "base/context.h"
#include "field/coefficients/coefficients.h"
#include "field/slice.h"
#include "slice/slice_options.h"

namespace bccsplat {

// The hyperplane is its unit normal (a, b, c, d) and e in index space, t in frames. World space of the slice
// keeps the lengths and angles that directions have in the volume's world with time as a fourth, orthogonal
// axis. A hyperplane that misses the domain gives an empty slice. Only bricks in reach of the thickness
// around the hyperplane are read. Means, sums and maxima come from Gauss-Legendre quadrature along the normal
// at each site, clipped to the domain. Along uneven axes the field is evaluated point by point, without a
// thickness, and the lattice is finer where it runs along them (even_slice.h).
[[nodiscard]] Slice plane_slice(const Coefficients& coefficients, const Hyperplane& hyperplane,
                                const HypersliceOptions& options, const Affine3& index_to_world,
                                const Context& context);

// Returns the place, domain and lattice of such a slice without any points.
[[nodiscard]] Slice bare_plane(const Coefficients& coefficients, const Hyperplane& hyperplane,
                               const HypersliceOptions& options, const Affine3& index_to_world);

// Tells what of the file plane_slice asks for.
void list_plane_reads(const Coefficients& coefficients, const Hyperplane& hyperplane,
                      const HypersliceOptions& options, LayerReads& out);

} // namespace bccsplat

// Any hyperplane a x + b y + c z + d t + e = 0: the 4D field evaluated at the sites of a BCC (or CC) lattice
// in the hyperplane, then the 3D prefilter, so that the slice's own reconstruction interpolates those values.
#pragma once

#include <array>

#include "base/context.h"
#include "base/vec.h"
#include "slice/coefficients.h"
#include "slice/slice.h"

namespace bccsplat {

struct PlaneOptions {
  double spacing = 1;                    // T of the target lattice
  double time_length = 1;                // world units that one frame is drawn as
  LatticeKind target = LatticeKind::bcc; // or cc
};

// hyperplane: unit normal (a, b, c, d) and e, index space (t in frames). Slice space: origin is the foot of
// the index origin on the hyperplane; the basis are the coordinate axes, without the one closest to the
// normal, projected and orthonormalised in order. World space of the slice keeps the lengths and angles that
// directions have in the volume's world with time as a fourth, orthogonal axis. A hyperplane that misses the
// domain gives a slice without points.
[[nodiscard]] Slice plane_slice(const Coefficients& coefficients, const std::array<double, 5>& hyperplane,
                                const PlaneOptions& options, const Affine3& index_to_world,
                                const Context& context);

} // namespace bccsplat

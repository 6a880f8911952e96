// SPDX-License-Identifier: Apache-2.0
// The hyperplane t = constant. With a kernel that is a product of space and time the 3D coefficients are
// weighted sums of the layers in reach, coset by coset, and the result is exact: evaluating it is evaluating
// the 4D field.
#pragma once

#include <vector>

#include "base/context.h"
#include "base/vec.h"
#include "field/coefficients/coefficients.h"
#include "field/slice.h"
#include "slice/thickness.h"

namespace bccsplat {

struct LayerWeight {
  int32_t layer; // may lie beyond the ends: the mirror image counts
  float weight;
};

// These return the layers of both cosets that take part in the instant `frame`, or in the mean over [begin,
// end] (frames, begin < end). A normalised kernel divides by the sum over all layers of the coset. A static
// lattice has one layer per coset.
[[nodiscard]] std::vector<LayerWeight> instant_weights(const Lattice4& lattice, const Kernel& kernel,
                                                       double frame);
[[nodiscard]] std::vector<LayerWeight> mean_weights(const Lattice4& lattice, const Kernel& kernel,
                                                    double begin, double end);

// Returns the part of [begin, end] that lies in the series; of a periodic one that lies in it or in a turn
// before or behind.
[[nodiscard]] std::array<double, 2> time_span(const Lattice4& lattice, double begin, double end);

// Returns the slice at `frame`, or the mean over [frame + interval[0], frame + interval[1]] clipped to
// time_span when the interval is not empty. Of a periodic series frames may lie a turn beyond. index_to_world
// is the volume's spatial affine. Throws out_of_domain.
[[nodiscard]] Slice time_slice(const Coefficients& coefficients, double frame,
                               const std::array<double, 2>& interval, const Affine3& index_to_world,
                               const Context& context);

// Makes the layers that such a slice is merged of, and leaves them in the cache.
void prepare_time_slice(const Coefficients& coefficients, double frame, const std::array<double, 2>& interval,
                        const Context& context);

// Cuts whatever a thickness can hold. The sum is the integral over the interval, in value times frames, exact
// as the mean is; its air is the integral of the air value. The maximum is at each site the largest value at
// the nodes of a quadrature over the interval (thickness.h), interpolated between them; it is nowhere less
// than the mean at a site but for rounding. An empty interval is the instant, whatever the kind.
// later: a moment of a series is merged when its bricks are first looked at, where it has no holes; until
// then its bounds are those of all moments between the same layers.
[[nodiscard]] Slice thick_time_slice(const Coefficients& coefficients, double frame,
                                     const std::array<double, 2>& interval, ThicknessKind kind,
                                     const Affine3& index_to_world, const Context& context,
                                     bool later = false);

} // namespace bccsplat

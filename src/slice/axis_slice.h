// SPDX-License-Identifier: Apache-2.0
// The hyperplanes x, y or z = constant: how a plane of space changes over time.
//
// D4* is the same along all four axes, so an axis slice is a time slice of the turned volume, under the
// kernel that is radial in the other two axes and time and a B-spline along the axis: a weighted sum of the
// few planes of sites in reach, with one weight per plane, from the samples of those planes alone. Its values
// differ from the volume's own reconstruction, whose kernel is turned the other way, by about the error that
// each of them has.
#pragma once

#include "field/coefficients/coefficients.h"
#include "field/slice.h"
#include "slice/plane_geometry.h"
#include "slice/thickness.h"

namespace bccsplat {

// Returns whether the volume can be turned: it has time, and an extent along the axis.
[[nodiscard]] bool can_turn(const Coefficients& coefficients, size_t axis);

// `position` is along the axis, in index units, inside the domain. Slice space is that of plane_axes; the
// result's lattice is the source's. Thick slices are as exact as those of time slices, clipped to the domain.
[[nodiscard]] Slice axis_slice(const Coefficients& coefficients, size_t axis, double position,
                               const Thickness& thickness, const Context& context);

// Tells what of the file axis_slice asks for.
void list_axis_reads(const Coefficients& coefficients, size_t axis, double position,
                     const Thickness& thickness, LayerReads& out);

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Puts the corrections of a volume's field into slices of it.
#pragma once

#include "base/context.h"
#include "field/coefficients/coefficients.h"
#include "field/corrections.h"
#include "field/slice.h"
#include "slice/thickness.h"

namespace bccsplat {

// Index units: a point this far beyond an end of the domain is on it.
inline constexpr double touches_end = 1e-6;

// Gives a slice corrections, and bounds that hold them.
void set_corrections(Slice& slice, SliceCorrections&& made);

// Corrects a time slice, merged from layers, by the corrections of the frames around it, as exactly as the
// slice itself is. Where there are several they are taken in the mean, or the sum, over these frames. box: of
// the source samples whose corrections are looked at.
void correct_time_slice(Slice& slice, const Coefficients& coefficients, std::array<double, 2> frames,
                        const Corrections::Box& box, ThicknessKind kind);

// Corrects any other slice, at the points of a grid of spacing 1 in slice space that begins where the domain
// does, by what it lacks of the volume's field, corrections included. This also mends what the slice's own
// lattice, or its turned kernel, loses there. For x, y and z slices at a source sample these points are all
// source samples in it.
void correct_slice(Slice& slice, const Coefficients& coefficients, const Thickness& thickness,
                   const Context& context);

} // namespace bccsplat

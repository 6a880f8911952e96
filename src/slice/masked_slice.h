// Gives slices of a volume the masks of its missing samples: a point of a slice has no value where the volume
// has none, at the resolution of the source.
#pragma once

#include "field/coefficients/coefficients.h"
#include "field/slice.h"

namespace bccsplat {

// Of a time slice the frame nearest to it decides, of one with an interval or a thickness that of its middle.
void mask_time_slice(Slice& slice, const Coefficients& coefficients);
// Of any other slice: the frames that it meets. Its origin and basis are set.
void mask_slice(Slice& slice, const Coefficients& coefficients);

} // namespace bccsplat

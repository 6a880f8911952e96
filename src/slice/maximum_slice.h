// The largest value that the field takes over several instants, as one slice.
#pragma once

#include <span>

#include "slice/coefficients.h"
#include "slice/slice.h"

namespace bccsplat {

// Maximum over the instants at the sites of the slices' lattice, and the 3D prefilter, so that the slice
// interpolates those maxima. The slices are time slices of one volume under one kernel; frame, origin and
// maps are the first one's.
[[nodiscard]] Slice maximum_slice(std::span<const Slice> instants, const Context& context);

} // namespace bccsplat

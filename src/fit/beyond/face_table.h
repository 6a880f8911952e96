// SPDX-License-Identifier: Apache-2.0
// Filters for the sites of an axis with planes outside its source samples.
//
// Samples beyond a face are replaced by what predicts them (ends.h); on BCC and D4* the outermost of two
// planes makes up for the mirrors behind it (against_mirrors.h).
#pragma once

#include "fit/axis/filter.h"
#include "lattice/lattice.h"

namespace bccsplat {

// noise: of the predictions.
[[nodiscard]] FilterTable face_table(const Lattice4& lattice, int coset, size_t axis, double widening,
                                     double noise);

} // namespace bccsplat

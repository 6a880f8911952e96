// Filters for the sites of an axis with planes outside its source samples.
//
// Samples beyond a face are replaced by what predicts them (ends.h). Readers take mirror images beyond the
// outermost plane, which the field is not: on BCC and D4* the samples of that plane make up for it. With s_k
// for what stands k planes outside, plane 2 holds s_2 + (s_0 - s_1 + s_3 - s_4) / 4 in place of s_2. The
// factors are those that bring the field between the face and a sample inside closest to waves in the ball,
// with the default kernel: found by search among all combinations of s_4 - s_0 and s_3 - s_1 on planes 1 and
// 2 (tests/bench/notes/ends.md).
#pragma once

#include "fit/filter.h"
#include "lattice/lattice.h"

namespace bccsplat {

// noise: of the predictions.
[[nodiscard]] FilterTable face_table(const Lattice4& lattice, int coset, size_t axis, Filter filter,
                                     double widening, double noise);

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// The inner loop of the low-pass.
#pragma once

#include <cstddef>

namespace bccsplat {

// out[x] = v[x] + sum over k of weight[k] * (q[4k][x] + q[4k+1][x] + q[4k+2][x] + q[4k+3][x] - 4 v[x]) for
// x = 0 .. n-1, n a multiple of 16; v[x] where that is beyond the range of floats.
void lowpass_row(const float* v, const float* const* q, const float* weight, size_t count, size_t n,
                 float* out);

} // namespace bccsplat

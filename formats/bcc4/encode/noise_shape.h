// SPDX-License-Identifier: Apache-2.0
// Where the rounding errors of coefficients go: to frequencies that the kernel does not pass.
//
// What rounding adds to a coefficient is taken back, with weights, from neighbours that are rounded later.
// The field's error is the errors under the kernel; the weights are those by which its mean square is
// smallest when the errors of single roundings are white: the linear predictor, with the sign turned, of
// noise that the kernel has coloured (Gerzon & Craven, Optimal noise shaping and dither of digital signals,
// 1989). On D4* and the default kernel the field errs by 3 dB less. A reader need not know of it.
#pragma once

#include "formats/bcc4/coding/predict_walk.h"
#include "kernel/kernel.h"

namespace bccsplat {

// How the rounding of a layer is shaped: the weights, in units of 1/4096, at the sites that a site is a tap
// of (predict_walk.h), by the layers there are behind it: bit 0 the next one, bit 1 the next of its coset.
struct NoiseShape {
  ClassWeights weights{};
};

// Returns the shape for BCC (still) and D4*, whose layers of one coset are two apart.
[[nodiscard]] NoiseShape noise_shape(const Kernel& kernel, bool still);

// The weights of the errors at the taps of the sites of a layer, in the order of gather_taps.
[[nodiscard]] Weights taps_of_layer(const NoiseShape& noise, const ChunkShape& shape, int layer);

} // namespace bccsplat

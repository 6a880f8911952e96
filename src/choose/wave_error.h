// SPDX-License-Identifier: Apache-2.0
// What lattices make of plane waves: tables of the default kernel and resampling filter.
#pragma once

namespace bccsplat::series {

// What comes back of a wave of amplitude 1: the amplitude of itself, and the energy of what it folds to.
struct WaveResponse {
  double pass = 0, folded = 0;
};

// Returns the response on D4* and BCC, by the wave's place in the dual's cell: gauge is the largest |f_i| +
// |f_j| over sqrt2, f in units of the Nyquist frequency of a grid of the lattice's distance; 1 at the border.
[[nodiscard]] WaveResponse lattice_response(double gauge);
// Along one axis of CC, |f| in the same units.
[[nodiscard]] WaveResponse cartesian_response(double frequency);

// The response of the resampling filter, widened by the lattice's distance; frequency 1: the border of its
// band.
[[nodiscard]] double filter_response(double frequency);

} // namespace bccsplat::series

// SPDX-License-Identifier: Apache-2.0
// The exact mean-square error of a reconstructed plane wave, and its mean over the waves of a ball of
// frequencies. A wave exp(2 pi i xi x) sampled on a lattice, prefiltered (symbol Q) and reconstructed with K
// has, averaged over positions, the error |1 - Q Phi(xi)|^2 + sum over dual vectors k != 0 of |Q Phi(xi +
// k)|^2, Phi the transform of K. Source: Blu & Unser, Quantitative Fourier analysis of approximation
// techniques, 1999 (the error kernel).
#pragma once

#include <array>
#include <span>
#include <vector>

#include "tests/bench/kernels/kernel_spectrum.h"

namespace bccsplat {

// A frequency and all that the error needs of the kernel there.
struct WaveSample {
  NeighbourMeans means;
  double pass = 1;   // Phi(xi)
  double alias2 = 0; // sum of Phi(xi + k)^2 over k != 0
  double symbol = 1; // sum of Phi(xi + k) over all k: what the kernel makes of the wave at the sites
  // The same for the gradient in space: |xi|^2 and the sum of |xi + k|^2 Phi(xi + k)^2 over k != 0, where
  // |.|^2 takes the spatial part.
  double space2 = 0;
  double alias_gradient2 = 0;
};

// xi is in cycles per T; dimensions is 3 for BCC (the last component is then 0), 4 for D4*; so it is below.
[[nodiscard]] WaveSample wave_sample(const KernelSpectrum& kernel, int dimensions,
                                     const std::array<double, 4>& xi);

// Returns frequencies (cycles per T) uniform in the ball |xi| <= rho / 2 (rho 1: the Nyquist sphere of CC),
// deterministic and of low discrepancy.
[[nodiscard]] std::vector<std::array<double, 4>> ball_frequencies(int dimensions, double rho, size_t count);

// Returns the waves of these frequencies.
[[nodiscard]] std::vector<WaveSample> ball_waves(const KernelSpectrum& kernel, int dimensions, double rho,
                                                 size_t count);
// Returns waves uniform over all frequencies of the lattice, its extreme points first.
[[nodiscard]] std::vector<WaveSample> all_waves(const KernelSpectrum& kernel, int dimensions, size_t count);

[[nodiscard]] inline double wave_error(const WaveSample& w, double q) {
  const double miss = 1 - q * w.pass;
  return miss * miss + q * q * w.alias2;
}

// The error of the spatial gradient, in units of (2 pi)^2; the signal is space2.
[[nodiscard]] inline double wave_gradient_error(const WaveSample& w, double q) {
  const double miss = 1 - q * w.pass;
  return w.space2 * miss * miss + q * q * w.alias_gradient2;
}

// Returns the signal-to-error ratio in dB: -10 log10 of the mean error. Without stages there is no prefilter.
[[nodiscard]] double snr_db(std::span<const WaveSample> waves, std::span<const PrefilterStage> stages,
                            int dimensions);
// Returns the SNR of the analytic gradient in space: mean square of the signal's gradient over that of the
// error.
[[nodiscard]] double gradient_snr_db(std::span<const WaveSample> waves,
                                     std::span<const PrefilterStage> stages, int dimensions);
// Returns snr_db() for the prefilter that interpolates exactly, Q = 1 / symbol.
[[nodiscard]] double snr_db_interpolating(std::span<const WaveSample> waves);

} // namespace bccsplat

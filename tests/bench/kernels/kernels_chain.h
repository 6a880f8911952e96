// SPDX-License-Identifier: Apache-2.0
// What reaches a user: the whole way from samples to values, against fields known everywhere.
#pragma once

#include <array>

#include "tests/bench/report.h"

namespace bccsplat::bench {

inline constexpr double wave_margin = 12; // samples from the ends, where a wave is not its own mirror image
inline constexpr std::array<double, 3> wave_rhos{0.5, 0.7, 0.9}; // of the Nyquist frequency

// Plane waves of a ball. Samples taken on D4* and evaluated at random 4D points; Cartesian frames imported,
// and time slices at instants between frames; slices splatted at random points, phase by phase of the
// instant; and constants, to the corners of the domain. Tables and the plot `chain`.
void run_kernel_chain(const Report& report);

// The signal of Marschner & Lobb, and what is left of it inside a ball of frequencies: BCC against CC.
void run_marschner_lobb(const Report& report);

// Gradients in space at random 4D points: analytic, and by differences of values.
void run_kernel_gradients(const Report& report);

// Constants and what varies little around them: as they come back, and divided by the lattice sum of the
// kernel.
void run_kernel_constants(const Report& report);
// The tables of run_kernel_constants that whole files give.
void report_constant_files(const Report& report);

// What the prefilter stages make of waves, noise, one site and a checkerboard, beside exact interpolation by
// conjugate gradients on a periodic lattice.
void run_kernel_interpolation(const Report& report);

// The paper's own pipeline, approximate and accurate slices, on D4* and CC.
void run_paper_kernel(const Report& report);

// Plots `error-frequency-3d`, `-4d`, `error-taps-3d`, `-4d`; nothing without a folder for them.
void plot_kernels(const Report& report);

} // namespace bccsplat::bench

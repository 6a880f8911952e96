// SPDX-License-Identifier: Apache-2.0
// Suite `kernels`: what the kernels and their prefilters do to plane waves, predicted and measured.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "kernel/kernel.h"
#include "tests/bench/kernels/wave_error.h"
#include "tests/bench/report.h"

namespace bccsplat::bench {

// Of the tables: frequencies up to these parts of Nyquist.
inline constexpr std::array<double, 4> table_rhos{0.3, 0.5, 0.7, 0.9};

//   kernels                    every table; or those named:
//           --predicted        from the spectra of kernel and prefilter
//           --measured         random plane waves on periodic lattices
//           --chain            the library from samples to values (kernels_chain.h)
//           --marschner        the signal of Marschner & Lobb
//           --gradients        analytic gradients against differences and against CC (kernels_gradient.cpp)
//           --constants        constants and what varies little around them (kernels_constants.cpp)
//           --interpolation    the stages against exact interpolation (kernels_interpolation.cpp)
//           --paper            the pipeline of Neophytou & Mueller 2002 (kernels_paper.cpp)
// Returns the exit status; throws Error on wrong arguments.
int run_kernels_suite(std::span<const std::string> args, const Report& report);

// A reconstruction on the Cartesian grid, separable: the same kernel on every axis.
enum class CartesianKernel { linear, catmull_rom, cubic_interpolating };
// Waves uniform in the ball |xi| <= rho / 2 with what the error needs of the kernel. cubic_interpolating is
// the cubic B-spline: its prefilter is 1 / symbol; the others have none.
[[nodiscard]] std::vector<WaveSample> cartesian_waves(CartesianKernel kernel, int dimensions, double rho,
                                                      size_t count);

// Signal-to-error in dB of random plane waves of the ball, sampled on a periodic D4* (dimensions 4) or BCC
// (3), prefiltered in float by the stages themselves and summed at random points. Per rho of table_rhos.
// interpolating: the exact interpolation by conjugate gradients takes the place of the stages.
[[nodiscard]] std::array<double, 4> measured_snr(const Kernel& kernel, int dimensions,
                                                 bool interpolating = false);

} // namespace bccsplat::bench

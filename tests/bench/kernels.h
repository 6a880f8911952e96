// Suite `kernels`: what the kernels and their prefilters do to plane waves, predicted and measured.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "kernel/kernel.h"
#include "kernel/wave_error.h"
#include "tests/bench/report.h"

namespace bccsplat::bench {

//   kernels [--predicted] [--measured] [--json]   the tables; both without an option; JSON lines instead of
//   Markdown kernels --design NAME | --design all          designs the prefilters again and prints
//   prefilter_tables.inc kernels --design-cc                           the same for the Cartesian lattice:
//   cc_tables.inc kernels --shape NAME | --shape all            designs phi again (radial16 radial18 radial20
//   radial24)
// Returns the exit status; throws Error on wrong arguments.
int run_kernels_suite(std::span<const std::string> args, const Report& report);

// A reconstruction on the Cartesian grid, separable: the same kernel on every axis.
enum class CartesianKernel { linear, catmull_rom, cubic_interpolating };
// Waves uniform in the ball |xi| <= rho / 2 with what the error needs of the kernel. cubic_interpolating is
// the cubic B-spline: its prefilter is 1 / symbol; the others have none.
[[nodiscard]] std::vector<WaveSample> cartesian_waves(CartesianKernel kernel, int dimensions, double rho,
                                                      size_t count);

// Signal-to-error in dB of random plane waves of the ball, sampled on a periodic D4* (dimensions 4) or BCC
// (3), prefiltered in float by the stages themselves and summed at random points. Per rho of design_rhos.
[[nodiscard]] std::array<double, 4> measured_snr(const Kernel& kernel, int dimensions);

} // namespace bccsplat::bench

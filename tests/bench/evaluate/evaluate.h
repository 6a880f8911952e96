// SPDX-License-Identifier: Apache-2.0
// Suite `evaluate`: time per point of the batch evaluation, beside its error and beside a tensor-product
// cubic on the Cartesian grid in the same run.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "base/vec.h"
#include "tests/bench/report.h"

namespace bccsplat::bench {

//   evaluate [--threads N] [--kernel NAME] [--points NAME]
// One thread unless told; all kernels and sets of points (grid, paths, strides, surface, random) unless
// named. Returns the exit status; throws Error on wrong arguments.
int run_evaluate_suite(std::span<const std::string> args, const Report& report);

// The cubic B-spline on a Cartesian grid in 4D, 256 taps: coefficients in float, x fastest, no bricks, no
// holes, no mirrors: as fast as a plain array allows.
struct Quadricubic {
  std::array<uint32_t, 4> dims{};
  std::vector<float> coefficients;
};

// At points (index units) at least 2 samples from the ends; gradients may be null. For the vector
// instructions of the machine.
void evaluate_quadricubic(const Quadricubic& field, std::span<const Vec4> points, float* values,
                          std::array<float, 4>* gradients);

} // namespace bccsplat::bench

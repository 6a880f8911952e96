// SPDX-License-Identifier: Apache-2.0
// The references of every accuracy table: tensor-product kernels on the Cartesian grid, in double.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "base/vec.h"
#include "tests/bench/kernels/kernels.h"

namespace bccsplat::bench {

// Samples f(i, j, k, l) of a grid of spacing 1, x fastest, with the kernel's prefilter applied; mirrored at
// the first and the last sample of each axis. An axis of one sample is constant.
class CartesianField {
 public:
  CartesianField(const std::array<uint32_t, 4>& dims, std::vector<double> samples, CartesianKernel kernel);
  // At a point of the domain, and its gradient where asked for.
  [[nodiscard]] double operator()(const Vec4& p, Vec4* gradient = nullptr) const;

  [[nodiscard]] const std::array<uint32_t, 4>& dims() const { return dims_; }
  [[nodiscard]] const std::vector<double>& coefficients() const { return values_; }

 private:
  std::array<uint32_t, 4> dims_;
  std::vector<double> values_;
  CartesianKernel kernel_;
};

// The interpolating prefilter of the cubic B-spline along lines of `count` values `stride` apart, mirrored at
// their ends (Unser 1999, Splines: a perfect fit for signal and image processing, box 2).
void prefilter_cubic(double* line, size_t count, size_t stride);

} // namespace bccsplat::bench

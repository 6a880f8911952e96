// SPDX-License-Identifier: Apache-2.0
// What a kernel makes of a constant, and gradients without it.
//
// The sum S(p) of a kernel over all sites of BCC or CC is 1 in the mean and ripples around it (in no kernel
// that divides by it). Where the field less its base is nearly constant it is that times S, and its gradient
// is mostly the ripple's where an object is smooth and fifty voxels thick. The gradient of the field over S
// is without it.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "base/vec.h"
#include "field/slice.h"
#include "kernel/kernel.h"

namespace bccsplat {

struct LatticeSum {
  double value = 1;
  Vec3 gradient{}; // per lattice unit
};
// Of the kernel without its prefilter, at any point, from the sites themselves.
[[nodiscard]] LatticeSum lattice_sum_at(const RadialKernel& kernel, bool bcc, const Vec3& p);

// The same from a table of an eighth of a cell, of which the others are mirror images; the gradient is within
// a sixth of the largest, and for 99 of 100 places within a tenth.
class LatticeSums {
 public:
  LatticeSums(const RadialKernel& kernel, bool bcc);
  [[nodiscard]] LatticeSum at(const Vec3& p) const;
  // Returns the gradient of a field over the sum, given the field less its base and its gradient per lattice
  // unit.
  [[nodiscard]] Vec3 without_ripple(const Vec3& p, double value, const Vec3& gradient) const;

 private:
  static constexpr size_t cells = 32; // along each axis
  double half_;                       // of the cell, lattice units
  std::vector<std::array<float, 4>> table_;
};

// Those of a slice; null where its field has no ripple, or corrections that know of it.
[[nodiscard]] std::shared_ptr<const LatticeSums> lattice_sums(const Slice& slice);

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// What a kernel makes of a constant, and gradients without it.
//
// The sum S(p) of a kernel over all sites of BCC or CC is 1 in the mean and ripples around it (in no kernel
// that divides by it). Where the field less its base is nearly constant it is that times S, and its gradient
// is mostly the ripple's where an object is smooth and fifty voxels thick. The gradient of the field over S
// is without it. This S is that of the sites within the kernel's radius; what normalised kernels divide by,
// lattice_sum() of kernel.h, is in closed form that of a Gaussian without an end.
#pragma once

#include <array>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "base/vec.h"
#include "field/slice.h"
#include "kernel/kernel.h"

namespace bccsplat {

struct LatticeSum {
  double value = 1;
  Vec3 gradient{}; // per lattice unit
};
// Sums the kernel without its prefilter over the sites themselves, at any point.
[[nodiscard]] LatticeSum lattice_sum_at(const RadialKernel& kernel, bool bcc, const Vec3& p);

// The same from a table of an eighth of a cell, of which the others are mirror images; by the fine table the
// gradient is within a sixth of the largest, and for 99 of 100 places within a tenth. The nearest entry of
// the coarse one leaves a quarter, which is for what is lit sample by sample: it takes an eighth of the time
// to make and stays in the cache.
class LatticeSums {
 public:
  static constexpr size_t fine = 32, coarse = 16; // places along each axis, less one
  LatticeSums(const RadialKernel& kernel, bool bcc, size_t cells = fine);
  [[nodiscard]] LatticeSum at(const Vec3& p) const;
  // Returns the gradient at the nearest place of the table; p in cells.
  [[nodiscard]] Vec3 nearest_gradient(const Vec3& p) const;
  // Returns the gradient of a field over the sum, given the field less its base and its gradient per lattice
  // unit.
  [[nodiscard]] Vec3 without_ripple(const Vec3& p, double value, const Vec3& gradient) const;
  // The same for many points, in place.
  void take_ripple_off(std::span<const Vec3> p, std::span<const double> values,
                       std::span<Vec3> gradients) const;

  // Gradients per lattice unit and values: entry (z (cells + 1) + y) (cells + 1) + x.
  [[nodiscard]] const std::vector<std::array<float, 4>>& table() const { return table_; }
  [[nodiscard]] size_t cells() const { return cells_; }
  [[nodiscard]] double cell() const { return 2 * half_; } // lattice units

 private:
  // Between the entry and the next ones along each axis, in the eighth of a cell that the table is of.
  struct Place {
    size_t entry = 0;
    std::array<float, 3> part{};
    Vec3 sign{};
  };
  [[nodiscard]] Place place_of(const Vec3& p) const;
  [[nodiscard]] LatticeSum sum_at(const Place& place) const;

  size_t cells_;
  double half_; // of the cell, lattice units
  std::vector<std::array<float, 4>> table_;
};

// The tables that were made last, one fine and one coarse: a fine one takes as long as a tenth of a small
// picture, and pictures of one series share their kernel. Any thread may ask.
class KeptLatticeSums {
 public:
  [[nodiscard]] std::shared_ptr<const LatticeSums> find(const RadialKernel& kernel, bool bcc, size_t cells);

 private:
  struct Kept {
    RadialKernel kernel;
    bool bcc = false;
    std::shared_ptr<const LatticeSums> sums;
  };
  std::mutex mutex_;
  std::map<size_t, Kept> kept_; // by cells
};

// Returns the fine sums of a slice's kernel; null where its field has no ripple, or corrections that know of
// it. kept: where they are looked for and left; null: they are made anew.
[[nodiscard]] std::shared_ptr<const LatticeSums> lattice_sums(const Slice& slice,
                                                              KeptLatticeSums* kept = nullptr);
// The same, coarse, of the kernel that it is drawn with.
[[nodiscard]] std::shared_ptr<const LatticeSums> lattice_sums(const Slice& slice, const RadialKernel& drawn,
                                                              KeptLatticeSums* kept = nullptr);

} // namespace bccsplat

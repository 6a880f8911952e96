// SPDX-License-Identifier: Apache-2.0
// Kernels and prefilters in the frequency domain. Frequencies are in cycles per T; transforms are 1 at 0. The
// dual of D4* is the set of n / sqrt2 with n in Z^4 of even sum (BCC: Z^3), whose shortest vectors have
// length 1.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "kernel/kernel.h"

namespace bccsplat {

// The neighbour means of a plane wave: the symbols of the three sums of a stage divided by their number of
// neighbours.
struct NeighbourMeans {
  double spatial = 1, temporal = 1, cross = 1;
};
[[nodiscard]] NeighbourMeans neighbour_means4(const std::array<double, 4>& frequency);
[[nodiscard]] NeighbourMeans neighbour_means3(const std::array<double, 3>& frequency);

// Returns the factor by which all stages together multiply a plane wave. cross_neighbours is 16 on D4*, 8 on
// BCC.
[[nodiscard]] double prefilter_symbol(std::span<const PrefilterStage> stages, const NeighbourMeans& means,
                                      int cross_neighbours);
// The symbols of A and B of one stage, c <- A c + B f.
[[nodiscard]] double running_symbol(const PrefilterStage& stage, const NeighbourMeans& means,
                                    int cross_neighbours);
[[nodiscard]] double source_symbol(const PrefilterStage& stage, const NeighbourMeans& means);

// Returns the sum of |taps| of the filter that the stages make: max |coefficient| <= this * max |sample|.
[[nodiscard]] double prefilter_gain4(std::span<const PrefilterStage> stages);
[[nodiscard]] double prefilter_gain3(std::span<const PrefilterStage> stages);

// Fourier transforms of phi (by length of the spatial frequency) and beta, tabulated.
class KernelSpectrum {
 public:
  explicit KernelSpectrum(const Kernel& kernel);
  [[nodiscard]] double space(double k) const;
  [[nodiscard]] double time(double k) const;

  // Returns what summing the kernel over the sites makes of a plane wave: a sum over the dual lattice, but
  // computed at the sites, where it is exact and finite. dimensions is 3 for BCC, 4 for D4*.
  [[nodiscard]] double symbol(const std::array<double, 4>& xi, int dimensions) const;

 private:
  struct Site {
    int coset;
    std::array<double, 3> position;
    double weight; // phi there
  };
  TemporalKernel beta_;
  std::vector<Site> sites_;   // of BCC in the support
  std::vector<double> space_; // at multiples of `step`
  std::vector<double> time_;  // of a cut Gaussian, or of the bends of a spline
};

} // namespace bccsplat

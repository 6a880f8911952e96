// SPDX-License-Identifier: Apache-2.0
// Kernels on Cartesian lattices of pitch 1 (CC), for comparison with BCC and D4*: the same phi and beta,
// scaled so that phi sums to 1 over the sites of CC in the mean, with prefilters of their own.
#pragma once

#include <vector>

#include "kernel/kernel.h"

namespace bccsplat {

struct Lattice4; // lattice/lattice.h

// The stages of a CC prefilter read PrefilterStage like this: S is the sum of the 6 spatial neighbours, T of
// the 2 temporal ones, X the sum of the *samples* (not of the running coefficients) at the 8 corners (+-1,
// +-1, +-1) around a site. `time` follows the spatial stages and takes what they made for its samples: the
// kernel being a product, so is its prefilter. Temporal kernels are given in kernel time, where layers are
// sqrt2 apart on every lattice.
struct CcKernel {
  Kernel kernel; // prefilter3 and prefilter4: the spatial stages
  std::vector<PrefilterStage> time;
};

// Makes the Cartesian form of the kernel that make_kernel gives this name. `exact` has a phi of its own,
// whose values at the distances of neighbours, p0, p1, p2, p3 at 0, 1, sqrt2 and sqrt3, fall by the same
// factor each. What it makes of coefficients at the sites is then a product of filters along the axes, of
// three taps each, and so is the inverse: samples come back to rounding. `paper` is the Gaussian exp(-2 r^2),
// normalised by the lattice sum, and linear weights in time (Neophytou & Mueller 2002, section 4.1). Throws
// unsupported for kernels that reach further than 2 T: radial24 and gauss09.
[[nodiscard]] CcKernel make_cc_kernel(std::string_view name);
// Returns whether the field of a kernel goes through the samples of a Cartesian lattice, but for rounding.
[[nodiscard]] inline bool interpolates_on_cc(const Kernel& kernel) { return kernel.name == "exact"; }
// Returns whether the field goes through the source's samples as far as they are stored: each of them is a
// site, and the kernel interpolates these. Planes and layers outside the samples may stand beside them.
[[nodiscard]] bool goes_through_samples(const Lattice4& lattice, const Kernel& kernel);

// The amplitude of the first wave that the Gaussian's sum along an axis of CC has about its mean, halved.
[[nodiscard]] double cc_first_wave();
// The lattice_sum of a CC kernel, relative to its mean 1, in closed form for the Gaussian.
[[nodiscard]] double cc_lattice_sum(const Kernel& kernel, double x, double y, double z);

// The lattice_sum of the kernel of a slice, on the slice's lattice.
[[nodiscard]] inline double lattice_sum(const Kernel& kernel, bool bcc, double x, double y, double z) {
  return bcc ? lattice_sum(kernel, x, y, z) : cc_lattice_sum(kernel, x, y, z);
}

} // namespace bccsplat

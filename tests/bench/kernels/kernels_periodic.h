// SPDX-License-Identifier: Apache-2.0
// Periodic lattices in memory: the prefilter stages as they are defined, sums at points, and exact
// interpolation by conjugate gradients. Slow and plain: references for measurements.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "kernel/kernel.h"

namespace bccsplat::bench {

// A periodic lattice: two cosets of edge^d sites, x fastest, coset 1 displaced by half a pitch on every axis.
struct PeriodicLattice {
  size_t axes;
  int edge;

  [[nodiscard]] size_t sites() const {
    size_t n = 1;
    for (size_t a = 0; a < axes; ++a) n *= edge;
    return n;
  }
  [[nodiscard]] std::array<int, 4> site(size_t i) const {
    std::array<int, 4> p{};
    for (size_t a = 0; a < axes; ++a, i /= edge) p[a] = static_cast<int>(i) % edge;
    return p;
  }
  [[nodiscard]] size_t index(const std::array<int, 4>& p) const {
    size_t i = 0;
    for (size_t a = axes; a-- > 0;) i = i * edge + (p[a] + edge) % edge;
    return i;
  }
};

using Values = std::array<std::vector<float>, 2>; // by coset

// The stages as they are defined, site by site.
[[nodiscard]] Values apply_stages(const PeriodicLattice& lattice, std::span<const PrefilterStage> stages,
                                  const Values& f);

// What the kernel makes of coefficients at the sites themselves (a normalised kernel is not divided here).
[[nodiscard]] Values values_at_sites(const PeriodicLattice& lattice, const Kernel& kernel, const Values& c);

// Coefficients whose values at the sites are f, by conjugate gradients in double from 0: the operator is
// symmetric, and positive where the kernel's symbol is. Ends when the residual is below `tolerance` times f,
// root mean square.
struct Interpolation {
  Values coefficients;
  int iterations = 0;
};
[[nodiscard]] Interpolation interpolate(const PeriodicLattice& lattice, const Kernel& kernel, const Values& f,
                                        double tolerance);

// The sum over the sites in reach of x (T); divided by the sum of the weights for the paper's kernel.
[[nodiscard]] double reconstruct(const Kernel& kernel, const PeriodicLattice& lattice, const Values& c,
                                 const std::array<double, 4>& x);

} // namespace bccsplat::bench

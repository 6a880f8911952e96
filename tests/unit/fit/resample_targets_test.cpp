// SPDX-License-Identifier: Apache-2.0
// Every instruction set this machine has computes the same resampling.
#include <gtest/gtest.h>

#include "tests/support/targets.h"
#include "tests/unit/fit/fit_series.h"

namespace bccsplat::test {
namespace {

TEST(ResampleTargets, AgreeWithTheReference) {
  const Series s = noise({41, 19, 22, 9}, 6);
  for (const LatticeScales& scales :
       {LatticeScales{1, 1, 1, 1}, {2.5, 2.5, 2.5, 1}, {1, 0.7, 0.85, 2.3}, {2.3, 0.7, 1, 0.8}}) {
    FitOptions o = options_for(s);
    o.scales = scales;
    const Lattice4 lattice = Lattice4::fit(o.lattice, o.dims, o.scales);
    const auto reference = reference_layers(lattice, s);
    int targets = 0;
    for_targets([&] {
      EXPECT_LT(worst_difference(run_fit(o, s), reference), 2e-6);
      ++targets;
    });
    EXPECT_GE(targets, 1);
  }
}

} // namespace
} // namespace bccsplat::test

// Every instruction set this machine has computes the same resampling.
#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "fit_series.h"

namespace bccsplat::test {
namespace {

TEST(ResampleTargets, AgreeWithTheReference) {
  const Series s = noise({41, 19, 22, 9}, 6);
  for (const double scale : {1.0, 2.5}) {
    FitOptions o = options_for(s);
    o.scale = scale;
    const Lattice4 lattice = Lattice4::fit(o.lattice, o.dims, o.scale);
    const auto reference = reference_layers(lattice, s, o.filter);
    int targets = 0;
    const int64_t all = hwy::SupportedTargets();
    for (int64_t left = all; left; left &= left - 1) {
      hwy::SetSupportedTargetsForTest(left & -left);
      hwy::GetChosenTarget().Update(hwy::SupportedTargets());
      EXPECT_LT(worst_difference(run_fit(o, s), reference), 2e-6) << hwy::TargetName(left & -left);
      ++targets;
    }
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    EXPECT_GE(targets, 1);
  }
}

} // namespace
} // namespace bccsplat::test

// SPDX-License-Identifier: Apache-2.0
// A moment that is merged later is the same as one that is merged at once.
#include "field/moment.h"

#include <gtest/gtest.h>

#include <cmath>

#include "slice/time_slice.h"
#include "tests/support/fields.h"
#include "tests/support/larger.h"

namespace bccsplat {
namespace {

using namespace test;

TEST(MomentPlan, IsMergedWhenItIsLookedAt) {
  TestContext context(2);
  const auto lattice = Lattice4::fit(LatticeKind::d4star, {30, 20, 18, 9}, {1, 1, 1, 1});
  const auto samples = sample_field(
      lattice,
      [](const Vec4& p) { return std::max(0.0, 1 - std::hypot(p[0] - 9 - p[3], p[1] - 9, p[2] - 8) / 6); },
      0);
  const Coefficients c(samples, 0, make_kernel("default"), 0, uint64_t{1} << 30);
  for (const double frame : {0.0, 2.3, 8.0}) {
    const auto cut = [&](bool later) {
      return thick_time_slice(c, frame, {0, 0}, ThicknessKind::mean, {}, context.get(), later);
    };
    const Slice now = cut(false), later = cut(true);
    const MomentPlan* const moment = later.coset.moment();
    ASSERT_TRUE(moment);
    EXPECT_FALSE(moment->is_merged());
    EXPECT_EQ(later.points(), now.points());
    EXPECT_FALSE(moment->is_merged());         // to count them makes none
    EXPECT_GE(2 * later.bytes(), now.bytes()); // what they will take
    EXPECT_LE(later.bounds[0], now.bounds[0]);
    EXPECT_GE(later.bounds[1], now.bounds[1]);
    EXPECT_EQ(moment->largest_weight(), 1);
    const Slice copy = later; // shares what is merged
    for (size_t coset = 0; coset < 2; ++coset)
      EXPECT_LT(largest_difference(layer_to_dense(copy.coset[coset]), layer_to_dense(now.coset[coset])), 1e-6)
          << frame; // layers in another order
    EXPECT_TRUE(moment->is_merged());
    EXPECT_EQ(later.bytes(), now.bytes());
    EXPECT_NEAR(evaluate_reference(later, {8, 7, 6}, nullptr), evaluate_reference(now, {8, 7, 6}, nullptr),
                1e-6);
  }
}

// Moments between the same layers have the same bounds, so that what is made for one serves the next.
TEST(MomentPlan, BoundsAreThoseOfItsLayers) {
  TestContext context(2);
  const auto lattice = Lattice4::fit(LatticeKind::d4star, {16, 16, 16, 9}, {1, 1, 1, 1});
  const auto samples = sample_field(
      lattice, [](const Vec4& p) { return 0.1 * p[0] + std::sin(p[3]); }, 0);
  const Coefficients c(samples, 0, make_kernel("default"), 0, uint64_t{1} << 30);
  const auto cut = [&](double frame) {
    return thick_time_slice(c, frame, {0, 0}, ThicknessKind::mean, {}, context.get(), true);
  };
  const Slice a = cut(4.02), b = cut(4.05);
  ASSERT_EQ(a.coset.moment()->parts().size(), b.coset.moment()->parts().size());
  EXPECT_EQ(a.bounds, b.bounds);
  EXPECT_EQ(a.coset.moment()->series(), b.coset.moment()->series());
  const Coefficients other(samples, 0, make_kernel("default"), 0, uint64_t{1} << 30);
  EXPECT_NE(other.number(), c.number());
}

} // namespace
} // namespace bccsplat

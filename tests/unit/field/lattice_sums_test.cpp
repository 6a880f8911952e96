// SPDX-License-Identifier: Apache-2.0
#include "field/lattice_sums.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/support/larger.h"

namespace bccsplat {
namespace {

TEST(LatticeSums, GradientsAreThoseOfTheValues) {
  constexpr double h = 1e-5;
  for (const char* name : {"fast", "default", "fine"})
    for (const bool bcc : {true, false}) {
      const RadialKernel kernel = make_kernel(name).space;
      for (const Vec3& p : {Vec3{0.1, 0.5, 0.3}, Vec3{-3.3, 7.7, 0.9}}) {
        const LatticeSum sum = lattice_sum_at(kernel, bcc, p);
        for (size_t a = 0; a < 3; ++a) {
          Vec3 low = p, high = p;
          low[a] -= h, high[a] += h;
          const double expected =
              (lattice_sum_at(kernel, bcc, high).value - lattice_sum_at(kernel, bcc, low).value) / (2 * h);
          EXPECT_NEAR(sum.gradient[a], expected, 1e-7) << name << bcc;
        }
      }
    }
}

TEST(LatticeSums, TheTableIsOfAnyPlace) {
  for (const char* name : {"fast", "default", "fine"})
    for (const bool bcc : {true, false}) {
      const RadialKernel kernel = make_kernel(name).space;
      const LatticeSums sums(kernel, bcc);
      std::mt19937 random(5);
      std::uniform_real_distribution<double> at(-6, 6);
      double ripple = 0, off = 0, most = 0, slope = 0;
      for (int n = 0; n < 3000; ++n) {
        const Vec3 p{at(random), at(random), at(random)};
        const LatticeSum exact = lattice_sum_at(kernel, bcc, p), table = sums.at(p);
        ripple = larger(ripple, std::fabs(exact.value - 1));
        off = larger(off, std::fabs(table.value - exact.value));
        most = larger(most, length(exact.gradient));
        slope = larger(slope, length(table.gradient - exact.gradient));
      }
      EXPECT_LT(off, 0.05 * ripple) << name << bcc;
      EXPECT_LT(slope, most / 6) << name << bcc;
    }
}

TEST(LatticeSums, TheNearestPlaceHasMostOfTheGradient) {
  for (const bool bcc : {true, false}) {
    const RadialKernel kernel = make_kernel("default").space;
    const LatticeSums sums(kernel, bcc, LatticeSums::coarse);
    std::mt19937 random(5);
    std::uniform_real_distribution<double> at(-6, 6);
    double all = 0, left = 0;
    for (int n = 0; n < 3000; ++n) {
      const Vec3 p{at(random), at(random), at(random)};
      const Vec3 exact = lattice_sum_at(kernel, bcc, p).gradient;
      all += dot(exact, exact);
      const Vec3 off = sums.nearest_gradient((1 / sums.cell()) * p) - exact;
      left += dot(off, off);
    }
    EXPECT_LT(std::sqrt(left), 0.35 * std::sqrt(all)) << bcc;
  }
}

TEST(LatticeSums, ThatOfAConstantIsTakenOff) {
  const RadialKernel kernel = make_kernel("default").space;
  const LatticeSums sums(kernel, true);
  const Vec3 p{4.2, 0.7, -1.9};
  const LatticeSum sum = lattice_sum_at(kernel, true, p);
  const Vec3 ripple = 7 * sum.gradient;
  EXPECT_LT(length(sums.without_ripple(p, 7 * sum.value, ripple)), 0.1 * length(ripple));
}

// Of many points at once what it is of each.
TEST(LatticeSums, ManyPointsAreAsOne) {
  const LatticeSums sums(make_kernel("default").space, true);
  std::vector<Vec3> p, gradients, one;
  std::vector<double> values;
  for (int n = 0; n < 77; ++n) {
    p.push_back({0.31 * n - 9, 0.17 * n, 5 - 0.23 * n});
    values.push_back(0.1 * n - 3);
    gradients.push_back({0.5, -0.01 * n, 0.02 * n});
    one.push_back(sums.without_ripple(p.back(), values.back(), gradients.back()));
    EXPECT_NE(one.back(), gradients.back());
  }
  sums.take_ripple_off(p, values, gradients);
  EXPECT_EQ(gradients, one);
}

TEST(LatticeSums, TablesAreKeptUntilAnotherIsAskedFor) {
  const RadialKernel one = make_kernel("default").space, other = make_kernel("fine").space;
  KeptLatticeSums kept;
  const auto first = kept.find(one, true, LatticeSums::fine);
  EXPECT_EQ(kept.find(one, true, LatticeSums::coarse)->cells(), LatticeSums::coarse);
  EXPECT_EQ(kept.find(one, true, LatticeSums::fine), first);
  EXPECT_EQ(first->table(), LatticeSums(one, true).table());
  const auto second = kept.find(other, true, LatticeSums::fine);
  EXPECT_EQ(second->table(), LatticeSums(other, true).table());
  EXPECT_EQ(kept.find(other, false, LatticeSums::fine)->table(), LatticeSums(other, false).table());
  EXPECT_EQ(kept.find(one, true, LatticeSums::fine)->table(), first->table());
}

} // namespace
} // namespace bccsplat

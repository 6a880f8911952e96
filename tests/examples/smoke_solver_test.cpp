// SPDX-License-Identifier: Apache-2.0
// The solver behind the quickstart's data: pressure against closed form, no divergence, air stays air, any
// thread count.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "smoke/expose.h"
#include "smoke/solver.h"
#include "tests/support/larger.h"

namespace {

using bccsplat::larger;
using smoke::Grid;

// On cell centres cos(pi m (i + 1/2) / n) is an eigenvector of the discrete Laplacian with zero normal
// gradient, with eigenvalue -4 sin^2(pi m / 2n); products of three add their eigenvalues.
double mode(int n, int m, int i) { return std::cos(std::numbers::pi * m * (i + 0.5) / n); }
double eigenvalue(int n, int m) { return -4 * std::pow(std::sin(std::numbers::pi * m / (2.0 * n)), 2); }

TEST(SmokePoisson, SolvesEigenmodes) {
  for (const int n : {16, 24, 26, 48}) {
    smoke::Poisson poisson(n, 2);
    const int a = 1, b = 3, c = n / 3;
    const double lambda = eigenvalue(n, a) + eigenvalue(n, b) + eigenvalue(n, c);
    const auto solution = [&](int i, int j, int k) { return mode(n, a, i) * mode(n, b, j) * mode(n, c, k); };
    Grid& rhs = poisson.rhs();
    for (int k = 0; k < n; ++k)
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) rhs(i, j, k) = static_cast<float>(lambda * solution(i, j, k));
    poisson.solve(20);
    double mean = 0, worst = 0;
    for (const float p : poisson.pressure().samples) mean += p;
    mean /= static_cast<double>(poisson.pressure().samples.size());
    for (int k = 0; k < n; ++k)
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i)
          worst = larger(worst, std::fabs(poisson.pressure()(i, j, k) - mean - solution(i, j, k)));
    EXPECT_LT(worst, 1e-5) << n;
  }
}

constexpr smoke::Source source{{0.4f, 0.3f, 0.5f}, 0.15f, {0.8f, 0.9f, -0.2f}, 1};

TEST(SmokeSolver, ProjectionLeavesLittleDivergence) {
  smoke::Solver solver(32, 2);
  for (int i = 0; i < 10; ++i) solver.step(1 / 48.0f, {&source, 1}, smoke::Physics{});
  // The steps end with advection, which makes divergence anew; a step of no length ends with the projection.
  solver.step(0, {}, smoke::Physics{});
  EXPECT_LT(solver.divergence(), 0.02f * 0.9f); // of the source's speed
}

TEST(SmokeSolver, StillAirStaysStill) {
  smoke::Solver solver(16, 2);
  for (int i = 0; i < 3; ++i) solver.step(1 / 48.0f, {}, smoke::Physics{});
  for (const float d : solver.density().samples) ASSERT_EQ(d, 0);
  EXPECT_EQ(solver.divergence(), 0);
}

TEST(SmokeSolver, SmokeRises) {
  smoke::Solver solver(32, 2);
  const smoke::Source still{{0.5f, 0.3f, 0.5f}, 0.15f, {0, 0, 0}, 1};
  solver.step(1 / 48.0f, {&still, 1}, smoke::Physics{});
  const auto height = [&] {
    double mass = 0, moment = 0;
    for (int k = 0; k < 32; ++k)
      for (int j = 0; j < 32; ++j)
        for (int i = 0; i < 32; ++i) {
          mass += solver.density()(i, j, k);
          moment += j * static_cast<double>(solver.density()(i, j, k));
        }
    return moment / mass;
  };
  const double before = height();
  for (int i = 0; i < 24; ++i) solver.step(1 / 48.0f, {}, smoke::Physics{});
  EXPECT_GT(height(), before + 1);
}

TEST(SmokeSolver, ThreadCountDoesNotMatter) {
  smoke::Solver one(24, 1), five(24, 5);
  for (int i = 0; i < 6; ++i) {
    one.step(1 / 48.0f, {&source, 1}, smoke::Physics{});
    five.step(1 / 48.0f, {&source, 1}, smoke::Physics{});
  }
  EXPECT_EQ(one.density().samples, five.density().samples);
}

TEST(SmokeExpose, AveragesWithBinomialWeightsAndEndsAtZero) {
  constexpr float faint = 1 / 256.0f;
  Grid grid(6, 7, 8);
  grid(2, 3, 4) = 1;
  Grid out = smoke::expose(grid);
  const auto weight = [](int d) { return d == 0 ? 0.5f : d == 1 || d == -1 ? 0.25f : 0.0f; };
  for (int k = 0; k < 8; ++k)
    for (int j = 0; j < 7; ++j)
      for (int i = 0; i < 6; ++i) {
        const float mean = weight(i - 2) * weight(j - 3) * weight(k - 4);
        ASSERT_FLOAT_EQ(out(i, j, k), std::max(0.0f, mean - faint) / (1 - faint));
      }
  std::fill(grid.samples.begin(), grid.samples.end(), 1.0f);
  for (const float value : smoke::expose(grid).samples) ASSERT_EQ(value, 1);
  std::fill(grid.samples.begin(), grid.samples.end(), faint);
  for (const float value : smoke::expose(grid).samples) ASSERT_EQ(value, 0);
}

} // namespace

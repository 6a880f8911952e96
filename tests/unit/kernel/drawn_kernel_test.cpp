// SPDX-License-Identifier: Apache-2.0
#include "kernel/drawn_kernel.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

namespace bccsplat {
namespace {

RadialKernel powers(const std::array<double, 8>& a) {
  RadialKernel phi{1.6, 8, {}};
  for (size_t i = 0; i < a.size(); ++i) phi.a[i] = a[i];
  return phi;
}

// Integral over r of r^2 phi(r) times 1 or a wave, by midpoints.
double integral(const RadialKernel& phi, double wave) {
  constexpr int steps = 20000;
  double sum = 0;
  for (int i = 0; i < steps; ++i) {
    const double r = (i + 0.5) / steps * phi.radius, q = wave * r;
    sum += r * r * phi.value(r * r) * (q != 0 ? std::sin(q) / q : 1);
  }
  return sum * phi.radius / steps;
}

TEST(DrawnKernel, AShortOneFindsItsOwnForm) {
  const auto own = short_kernel(powers({0, 0, 0.3, 0, 0.5, 0.2, 0, 0}));
  ASSERT_TRUE(own);
  EXPECT_NEAR(own->a[2], 0.3, 1e-9);
  EXPECT_NEAR(own->a[4], 0.5, 1e-9);
  EXPECT_NEAR(own->a[5], 0.2, 1e-9);
}

TEST(DrawnKernel, AShortOneRisesInAllItsPowers) {
  EXPECT_FALSE(short_kernel(powers({0, 0, -0.01, 0, 1, 0.2, 0, 0})));
  EXPECT_FALSE(short_kernel(powers({0, 0, 1, 0, -0.01, 0.2, 0, 0})));
  EXPECT_FALSE(short_kernel(powers({0, 0, 1, 0, 0.2, -0.01, 0, 0})));
}

TEST(DrawnKernel, WhatIsFarFromTheFormHasNoShortOne) {
  EXPECT_FALSE(short_kernel(powers({0, 0, 0, 1, 0, 0, 0, 0.5})));
  EXPECT_FALSE(short_kernel(powers({0.1, 0, 0.3, 0, 0.5, 0.2, 0, 0})));
}

TEST(DrawnKernel, FormsOfTheDefaultHaveItsIntegralAndTheFlatOneNoWaveAtTheImages) {
  const RadialKernel phi = make_kernel("radial20+b3").space;
  const auto quick = short_kernel(phi), flat = flat_kernel(phi);
  ASSERT_TRUE(quick && flat);
  EXPECT_NEAR(integral(*quick, 0) / integral(phi, 0), 1, 1e-6);
  EXPECT_NEAR(integral(*flat, 0) / integral(phi, 0), 1, 1e-6);
  EXPECT_NEAR(integral(*flat, 2 * std::numbers::pi) / integral(*flat, 0), 0, 1e-5);
  EXPECT_LT(std::fabs(quick->value(0) / phi.value(0) - 1), 0.002);
}

} // namespace
} // namespace bccsplat

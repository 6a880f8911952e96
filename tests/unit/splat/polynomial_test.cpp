// SPDX-License-Identifier: Apache-2.0
// The kernels as the inner loops take them, and their short forms.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kernel/radial.h"
#include "splat/loop/loops.h"
#include "tests/support/larger.h"
#include "tests/support/splat_scene.h"

namespace bccsplat {
namespace {

using namespace test;

double value(const KernelPolynomial& k, double u) {
  double sum = 0;
  for (int j = k.terms - 1; j >= 0; --j) sum = sum * u + k.a[j];
  return sum;
}

RadialKernel as_radial(const KernelPolynomial& k, double radius) {
  RadialKernel phi;
  phi.radius = radius, phi.terms = k.terms;
  for (size_t j = 0; j < static_cast<size_t>(k.terms); ++j) phi.a[j] = k.a[j];
  return phi;
}

TEST(ShortPolynomial, IsNearTheKernelAndKeepsConstants) {
  const RadialKernel phi = make_kernel("default").space;
  const KernelPolynomial k = kernel_polynomial(phi, KernelForm::short_form);
  ASSERT_EQ(k.form, KernelPolynomial::Form::short_form);
  EXPECT_EQ(k.a[0], 0);
  EXPECT_EQ(k.a[1], 0);
  EXPECT_EQ(k.a[3], 0);
  EXPECT_NEAR(radial_integral(as_radial(k, phi.radius)), radial_integral(phi), 1e-6 * radial_integral(phi));
  double before = 0;
  for (double u = 0; u <= 1; u += 1.0 / 128) {
    EXPECT_NEAR(value(k, u), phi.value((1 - u) * phi.radius * phi.radius), 0.002 * phi.value(0)) << u;
    EXPECT_GE(value(k, u), before);
    before = value(k, u);
  }
}

// Returns by how much the sum of the weights of all lattice points around a place differs from 1 at most.
double largest_ripple(const KernelPolynomial& k, double radius, bool bcc) {
  const double side = bcc ? std::numbers::sqrt2 : 1;
  double most = 0;
  for (int place = 0; place < 64; ++place) {
    const Vec3 p{side * (place & 3) / 8, side * (place >> 2 & 3) / 8, side * (place >> 4) / 8};
    double sum = 0;
    for (int coset = 0; coset < (bcc ? 2 : 1); ++coset)
      for (int z = -4; z <= 4; ++z)
        for (int y = -4; y <= 4; ++y)
          for (int x = -4; x <= 4; ++x) {
            const double h = 0.5 * coset;
            const Vec3 r = p - side * Vec3{x + h, y + h, z + h};
            const double u = 1 - dot(r, r) / (radius * radius);
            if (u > 0) sum += value(k, u);
          }
    most = larger(most, std::fabs(sum * (bcc ? 1 : std::numbers::sqrt2 / 2) - 1)); // made for BCC
  }
  return most;
}

TEST(FlatPolynomial, ConstantsComeOutFlatter) {
  const RadialKernel phi = make_kernel("default").space;
  const KernelPolynomial k = kernel_polynomial(phi, KernelForm::flat_form);
  ASSERT_EQ(k.form, KernelPolynomial::Form::flat_form);
  EXPECT_NEAR(radial_integral(as_radial(k, phi.radius)), radial_integral(phi), 1e-6 * radial_integral(phi));
  EXPECT_LT(largest_ripple(k, phi.radius, true),
            0.6 * largest_ripple(kernel_polynomial(phi), phi.radius, true));
  EXPECT_LT(largest_ripple(k, phi.radius, true), 0.0015);
  EXPECT_LT(largest_ripple(k, phi.radius, false), 0.02);
}

// Culling by coefficients relies on this: no form of a radial kernel ripples by 2 % on BCC.
TEST(KernelPolynomial, RadialKernelsHardlyRipple) {
  for (const char* name : {"radial16+b2", "radial18+b3", "radial20+b3", "radial24+b4"})
    for (const auto form : {KernelForm::exact, KernelForm::short_form, KernelForm::flat_form}) {
      const RadialKernel phi = make_kernel(name).space;
      EXPECT_LT(largest_ripple(kernel_polynomial(phi, form), phi.radius, true), 0.01) << name;
    }
}

TEST(FlatPolynomial, OthersStayAsTheyAre) {
  for (const char* name : {"radial16+b2", "radial18+b3", "fine", "paper", "gauss09"}) {
    const RadialKernel phi = make_kernel(name).space;
    EXPECT_EQ(kernel_polynomial(phi, KernelForm::flat_form).form, kernel_polynomial(phi).form) << name;
    EXPECT_EQ(kernel_polynomial(phi, KernelForm::flat_form).a, kernel_polynomial(phi).a) << name;
  }
}

TEST(ShortPolynomial, OthersStayAsTheyAre) {
  for (const char* name : {"radial16+b2", "radial18+b3", "fine", "paper", "gauss09"}) {
    const RadialKernel phi = make_kernel(name).space;
    const KernelPolynomial full = kernel_polynomial(phi), k = kernel_polynomial(phi, KernelForm::short_form);
    EXPECT_EQ(k.form, full.form) << name;
    EXPECT_EQ(k.terms, full.terms) << name;
    EXPECT_EQ(k.a, full.a) << name;
  }
}

// The short form costs a picture less than the sheet distance that it is used with.
TEST(ShortPolynomial, PicturesAreAsCloseToTheFieldsOwnIntegral) {
  const Slice slice = make_slice({28, 28, 28}, marschner_lobb(28, 4));
  Scene scene = make_scene(slice, ramp_function(0.3, 1, 0.3), fit_camera(slice, false, 20, 30, 96, 96));
  RenderOptions o;
  o.opacity_stop = 1;
  for (const bool shaded : {false, true}) {
    o.shading = shaded;
    ImageStorage reference(96, 96), got(96, 96);
    o.reference = true;
    draw(scene, o, reference);
    o.reference = false;
    for (const auto quality : {Quality::draft, Quality::normal}) {
      o.kernel_form = KernelForm::short_form;
      o.quality = quality;
      o.gradient = GradientMethod::fourth_order;
      draw(scene, o, got);
      const double db = compare(reference, got).db();
      EXPECT_GT(db, shaded ? 36 : quality == Quality::draft ? 52 : 58);
    }
  }
}

} // namespace
} // namespace bccsplat

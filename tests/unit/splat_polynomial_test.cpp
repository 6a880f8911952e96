// The kernels as the inner loops take them, and their short forms.
#include <gtest/gtest.h>

#include <cmath>

#include "kernel/radial.h"
#include "splat/kernels.h"
#include "tests/unit/splat_scene.h"

namespace bccsplat {
namespace {

using namespace test;

double value(const KernelPolynomial& k, double u) {
  double sum = 0;
  for (int j = k.terms - 1; j >= 0; --j) sum = sum * u + static_cast<double>(k.a[static_cast<size_t>(j)]);
  return sum;
}

RadialKernel as_radial(const KernelPolynomial& k, double radius) {
  RadialKernel phi;
  phi.radius = radius, phi.terms = k.terms;
  for (size_t j = 0; j < static_cast<size_t>(k.terms); ++j) phi.a[j] = static_cast<double>(k.a[j]);
  return phi;
}

TEST(ShortPolynomial, IsNearTheKernelAndKeepsConstants) {
  const RadialKernel phi = make_kernel("default").space;
  const KernelPolynomial k = short_polynomial(phi);
  ASSERT_EQ(k.form, KernelPolynomial::Form::short_5);
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

TEST(ShortPolynomial, OthersStayAsTheyAre) {
  for (const char* name : {"radial16+b2", "radial18+b3", "fine", "paper", "gauss09"}) {
    const RadialKernel phi = make_kernel(name).space;
    const KernelPolynomial full = kernel_polynomial(phi), k = short_polynomial(phi);
    EXPECT_EQ(k.form, full.form) << name;
    EXPECT_EQ(k.terms, full.terms) << name;
    EXPECT_EQ(k.a, full.a) << name;
  }
}

// What the short form costs a picture: less than the sheet distance it is used with.
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
      o.short_kernel = true;
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

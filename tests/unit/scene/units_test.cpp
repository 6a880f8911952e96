// SPDX-License-Identifier: Apache-2.0
// Pictures do not depend on the units of values and lengths: densities of plasmas are 1e20 per m3, those of
// gas between the stars 1e-24 g/cm3, and the voxels of galaxies 1e20 cm long.
#include <gtest/gtest.h>

#include "tests/support/splat_scene.h"

namespace bccsplat {
namespace {

using namespace test;

// One field in units of `value`, its voxels `length` long; powers of two, so that nothing else is rounded.
struct Picture {
  ImageStorage out{30, 26};

  Picture(double value, double length, const RenderOptions& options, bool perspective, bool noise = false) {
    const Field3 one = marschner_lobb(14, 2.2);
    Affine3 affine;
    for (size_t a = 0; a < 3; ++a) affine.linear[a][a] = length;
    const Slice slice = make_slice(
        {14, 13, 15}, [&](double x, double y, double z) { return value * one(x, y, z); }, "default", affine);
    Scene scene = make_scene(slice, ramp_function(0.3 * value, value, 0.5),
                             fit_camera(slice, perspective, 25, 40, 30, 26));
    scene.lights.lights.push_back({{1, 2, 3}, {0.5, 0.25, 1}});
    if (noise) scene.lights.noise = {0.02 * value / length, 0.05 / length};
    draw(scene, options, out);
  }
};

double difference(const Picture& a, const Picture& b) { return compare(a.out, b.out).most; }

TEST(RenderUnits, PicturesStayTheSame) {
  for (const bool perspective : {false, true})
    for (const GradientMethod method :
         {GradientMethod::analytic, GradientMethod::central, GradientMethod::fourth_order}) {
      RenderOptions o;
      o.gradient = method;
      const Picture usual(1, 1, o, perspective, true);
      for (const double value : {0x1p-100, 0x1p-66, 1.0, 0x1p66, 0x1p100})
        for (const double length : {0x1p-75, 1.0, 0x1p75})
          EXPECT_LT(difference({value, length, o, perspective, true}, usual), 1e-6)
              << value << ' ' << length << ' ' << perspective << ' ' << static_cast<int>(method);
    }
}

TEST(RenderUnits, ValuesNextToTheSmallestFloatsAreDrawn) {
  const Picture usual(1, 1, {}, false);
  EXPECT_LT(difference({0x1p-120, 1, {}, false}, usual), 0.01); // fewer entries of the table
  EXPECT_LT(difference({0x1p-140, 1, {}, false}, usual), 1);    // none of them: a picture all the same
}

} // namespace
} // namespace bccsplat

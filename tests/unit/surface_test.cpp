#include "splat/surface.h"

#include <gtest/gtest.h>

#include <random>

#include "splat/sheet.h"
#include "tests/unit/splat_scene.h"

namespace bccsplat {
namespace {

using test::compare;

// Marschner & Lobb's signal near the band limit: many rays graze its waves. The reference walks in steps of
// 1/16 T.
TEST(Surface, GrazingRaysHitWhatLiesBetweenTheSheets) {
  constexpr int n = 36, size = 124; // 2 pixels per T
  const Slice s = test::make_slice({n, n, n}, test::marschner_lobb(n, 5));
  const Scene scene =
      test::make_scene(s, test::ramp_function(0, 1, 0.5), fit_camera(s, false, 20, 30, size, size));
  RenderOptions options;
  options.mode = RenderMode::isosurface;
  options.iso_value = 0.5;
  ImageStorage exact(size, size), image(size, size);
  options.reference = true;
  (void)test::draw(scene, options, exact);
  options.reference = false;
  for (const auto& [step, decibel, missed] :
       {std::tuple{1.0, 31.0, 10}, std::tuple{0.5, 41.0, 1}, std::tuple{0.25, 50.0, 0}}) {
    options.sheet_step = step;
    (void)test::draw(scene, options, image);
    EXPECT_GT(compare(image, exact).db(), decibel) << step;
    int holes = 0;
    for (size_t p = 3; p < image.rgba.size(); p += 4) holes += image.rgba[p] == 0 && exact.rgba[p] > 0;
    EXPECT_LE(holes, missed) << step;
  }
}

// A layer thinner than the distance of the sheets, which stand at 6.5 and 7.5.
TEST(Surface, ThinLayersBetweenTheSheets) {
  constexpr int n = 16, size = 32;
  for (const double centre : {6.9, 7.0, 7.1})
    for (const double iso : {0.95, 1.2}) { // .64 T thick; never reached
      const Slice s = test::make_slice(
          {n, n, n}, [&](double, double, double z) { return std::exp(-(z - centre) * (z - centre) / 2); });
      Scene scene =
          test::make_scene(s, test::ramp_function(0, 1, 0.5), fit_camera(s, false, 0, 0, size, size));
      RenderOptions options;
      options.mode = RenderMode::isosurface;
      options.sheet_step = 1;
      options.iso_value = iso;
      ImageStorage image(size, size);
      (void)test::draw(scene, options, image);
      EXPECT_EQ(image.rgba[4 * (size / 2 * size + size / 2) + 3], iso < 1 ? 1.0f : 0.0f) << centre;
    }
}

TEST(Surface, CrossingsAreTheSameInVectors) {
  constexpr int width = 61, height = 7, pitch = 64, plane_pitch = 96;
  std::mt19937 random(3);
  std::uniform_real_distribution<float> uniform(0, 1);
  std::vector<std::vector<float>> sheets(4, std::vector<float>(plane_pitch * height));
  std::vector<float> alpha(pitch * height), enter(pitch * height), leave(pitch * height);
  // Parabolas along the rays, some of which reach the target between the sheets 9 and 10 only.
  for (size_t p = 0; p < sheets[0].size(); ++p) {
    const float top = 0.5f + 0.4f * uniform(random), bend = 0.05f + 0.3f * uniform(random);
    const float at = 8.5f + 2 * uniform(random);
    for (size_t n = 0; n < 4; ++n) {
      const float away = 8 + static_cast<float>(n) - at;
      sheets[n][p] = top - bend * away * away;
    }
  }
  for (float& a : alpha) a = uniform(random) < 0.2f ? 1 : 0;
  for (float& e : enter) e = uniform(random) < 0.1f ? 11 : 0;
  for (float& l : leave) l = 20;
  CrossingArgs c;
  c.k = 10, c.target = 0.7f, c.width = width, c.height = height, c.pitch = pitch, c.plane_pitch = plane_pitch;
  c.before2 = sheets[0].data(), c.before = sheets[1].data();
  c.value = sheets[2].data(), c.after = sheets[3].data();
  c.alpha = alpha.data(), c.enter = enter.data(), c.leave = leave.data();
  std::vector<uint32_t> plain(width * height), vectors(width * height);
  c.found = plain.data();
  plain.resize(scalar_sheet_kernels().crossings(c));
  c.found = vectors.data();
  vectors.resize(simd_sheet_kernels().crossings(c));
  EXPECT_EQ(plain, vectors);
  const auto grazes = std::count_if(plain.begin(), plain.end(), [](uint32_t f) { return f & grazing; });
  EXPECT_GT(grazes, 5);
  EXPECT_GT(static_cast<long>(plain.size()) - grazes, 50);
}

} // namespace
} // namespace bccsplat

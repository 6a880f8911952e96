// SPDX-License-Identifier: Apache-2.0
// Points on surfaces: rays that graze, layers thinner than the sheets' distance, how near roots are, and the
// loops that look for crossings.
#include "shade/surface.h"

#include <gtest/gtest.h>

#include <random>

#include "splat/sheet/sheet.h"
#include "tests/support/larger.h"
#include "tests/support/splat_scene.h"

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

// A layer is thinner than the distance of the sheets, which are at 6.5 and 7.5.
TEST(Surface, ThinLayersBetweenTheSheets) {
  constexpr int n = 16, size = 32;
  for (const double centre : {6.9, 7.0, 7.1})
    for (const double iso : {0.95, 1.2}) { // 0.64 T thick; never reached
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

// Roots end near the field's own, whether the slopes at the sheets are known or not, and as near as asked
// for.
TEST(Surface, RootsAreAsNearAsAskedFor) {
  constexpr int n = 36, size = 90;
  const Slice s = test::make_slice({n, n, n}, test::marschner_lobb(n, 5));
  const double iso = 0.5, nan = std::numeric_limits<double>::quiet_NaN();
  const SheetView view =
      make_view(s, resolve_camera(fit_camera(s, false, 20, 30, size, size)), size, size, 0.5);
  const SurfaceField field(s);
  std::vector<Crossing> crossings;
  for (int j = 20; j < 70; j += 3)
    for (int i = 20; i < 70; i += 3) {
      const auto [low, high] = ray_interval(s, view, i, j);
      std::vector<Vec3> p;
      for (double k = std::ceil(low); k <= high; ++k) p.push_back(view.sample(i, j, k));
      std::vector<float> value(p.size());
      std::vector<Vec3> gradient(p.size());
      field_at(field, p, value, gradient);
      for (size_t m = 1; m < p.size(); ++m) {
        if ((value[m - 1] < iso) == (value[m] < iso)) continue;
        const double k = std::ceil(low) + static_cast<double>(m);
        const auto slope = [&](size_t at) { return dot(gradient[at], view.ray(i, j)); };
        crossings.push_back({1.0 * i, 1.0 * j, k - 1, k, value[m - 1], value[m], slope(m - 1), slope(m)});
      }
    }
  ASSERT_GT(crossings.size(), 100u);
  std::vector<Crossing> blind = crossings;
  for (Crossing& c : blind) c.slope_low = c.slope_high = nan;
  // Where the field turns between two sheets three steps do not always do.
  for (const auto& start : {crossings, blind})
    for (const auto& [tolerance, off, turned] :
         {std::tuple{0.0, 1e-4, 0.02}, std::tuple{0.01, 1e-3, 0.06}, std::tuple{0.1, 0.03, 0.5}}) {
      const auto found = refine_crossings(field, view, iso, start, tolerance);
      std::vector<Vec3> p, gradient(found.size());
      std::vector<float> value(found.size());
      for (const SurfacePoint& hit : found) p.push_back(hit.position);
      field_at(field, p, value, gradient);
      size_t far = 0;
      for (size_t m = 0; m < found.size(); ++m) {
        const Vec3 normal = normalized(view.lattice_to_world.inverse().transposed(gradient[m]));
        far +=
            std::fabs(value[m] - iso) > off * std::fabs(dot(gradient[m], view.ray(start[m].i, start[m].j))) ||
            length(normalized(found[m].gradient) - normal) > turned;
      }
      EXPECT_LE(far, found.size() / 40) << tolerance;
    }
}

// Points are taken on either lattice, beyond the ends, too, where the mirror images of sites count.
TEST(Surface, FieldsAreThoseOfTheReference) {
  for (const LatticeKind kind : {LatticeKind::bcc, LatticeKind::cc})
    for (const char* kernel : {"default", "fast", "paper"}) {
      const Slice s = test::make_slice({18, 16, 17}, test::marschner_lobb(18, 2), kernel, {}, 0.2, kind);
      std::mt19937 random(5);
      std::vector<Vec3> p(700);
      for (Vec3& at : p)
        for (size_t a = 0; a < 3; ++a)
          at[a] = std::uniform_real_distribution(-1.5, s.domain_end[a] + 1.5)(random);
      std::vector<float> value(p.size());
      std::vector<Vec3> gradient(p.size());
      field_at(SurfaceField(s), p, value, gradient);
      double off = 0, turned = 0;
      for (size_t n = 0; n < p.size(); ++n) {
        Vec3 exact;
        const double v = evaluate_reference(s, p[n], &exact) - s.base;
        off = larger(off, std::fabs(value[n] - v));
        turned = larger(turned, length(gradient[n] - exact));
      }
      EXPECT_LT(off, 2e-6) << kernel << static_cast<int>(kind);
      EXPECT_LT(turned, 2e-5) << kernel << static_cast<int>(kind);
    }
}

TEST(Surface, CrossingsAreTheSameInVectors) {
  constexpr int width = 61, height = 7, pitch = 64, plane_pitch = 96;
  std::mt19937 random(3);
  std::uniform_real_distribution<float> uniform(0, 1);
  for (const int count : {1, 3, CrossingArgs::most}) {
    std::vector<std::vector<float>> sheets(static_cast<size_t>(count) + 3,
                                           std::vector<float>(plane_pitch * height));
    std::vector<float> alpha(pitch * height), enter(pitch * height), leave(pitch * height);
    // Parabolas along the rays, some of which reach the target between the sheets 9 and 9 + count only.
    for (size_t p = 0; p < sheets[0].size(); ++p) {
      const float top = 0.5f + 0.4f * uniform(random), bend = 0.05f + 0.3f * uniform(random);
      const float at = 8.5f + static_cast<float>(count + 1) * uniform(random);
      for (size_t n = 0; n < sheets.size(); ++n) {
        const float away = 8 + static_cast<float>(n) - at;
        sheets[n][p] = top - bend * away * away;
      }
    }
    for (float& a : alpha) a = uniform(random) < 0.6f ? 0 : uniform(random);
    for (float& e : enter) e = uniform(random) < 0.1f ? 11 : 0;
    for (float& l : leave) l = 20;
    CrossingArgs c;
    c.count = count;
    c.k = 10, c.target = 0.7f, c.stop = 0.6f, c.width = width, c.height = height, c.pitch = pitch,
    c.plane_pitch = plane_pitch;
    for (size_t n = 0; n < sheets.size(); ++n) c.plane[n] = sheets[n].data();
    c.alpha = alpha.data(), c.enter = enter.data(), c.leave = leave.data();
    std::vector<SheetCrossing> reference(static_cast<size_t>(width * height * count)),
        vectors(reference.size());
    c.found = reference.data();
    reference.resize(reference_sheet_loops().crossings(c));
    c.found = vectors.data();
    vectors.resize(simd_sheet_loops().crossings(c));
    EXPECT_TRUE(reference == vectors) << count;
    const auto grazes =
        std::count_if(reference.begin(), reference.end(), [](const SheetCrossing& f) { return f.grazes; });
    EXPECT_GT(grazes, 5);
    EXPECT_GT(static_cast<long>(reference.size()) - grazes, 50);
    for (int n = 0; n < count; ++n)
      EXPECT_GT(
          std::count_if(reference.begin(), reference.end(), [n](const auto& f) { return f.interval == n; }),
          10);
  }
}

} // namespace
} // namespace bccsplat

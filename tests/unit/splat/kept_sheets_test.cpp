// SPDX-License-Identifier: Apache-2.0
// Sheets kept from picture to picture: pictures are the same with them, they are dropped when the view
// changes, and they stay within the memory budget.
#include "splat/tile/kept_sheets.h"

#include <gtest/gtest.h>

#include <cstring>

#include "tests/support/splat_scene.h"

namespace bccsplat {
namespace {

using test::make_scene;
using test::make_slice;
using test::ramp_function;

constexpr int size = 150; // 3 pixels per T

// The budget ends with this function.
SplatPoints unbudgeted(const Slice& slice) {
  test::TestContext context;
  SplatPoints points = make_points(slice, context.get());
  points.memory = {};
  return points;
}

struct Volume {
  Slice slice = make_slice({30, 30, 30}, test::marschner_lobb(30, 4));
  KeptPoints points{unbudgeted(slice)};
  [[nodiscard]] Scene scene(bool perspective = false) const {
    Scene s =
        make_scene(slice, ramp_function(0.3, 1, 0.3), fit_camera(slice, perspective, 20, 30, size, size));
    s.points = &points;
    return s;
  }
};

// The budget of all pictures outlives the sheets.
RenderStats draw_kept(test::TestContext& context, const Scene& scene, const RenderOptions& options,
                      ImageStorage& out) {
  return render(scene, options, context.get(), out.image);
}

bool same(const ImageStorage& a, const ImageStorage& b) {
  return std::memcmp(a.rgba.data(), b.rgba.data(), a.rgba.size() * sizeof(float)) == 0 &&
         std::memcmp(a.depth.data(), b.depth.data(), a.depth.size() * sizeof(float)) == 0;
}

struct Way {
  const char* name;
  RenderMode mode = RenderMode::composite;
  Quality quality = Quality::normal;
  bool shading = true, perspective = false;
  std::optional<GradientMethod> gradient{};
  Preintegrate preintegrate = Preintegrate::off;
};

class KeptSheetsOf : public testing::TestWithParam<Way> {};
INSTANTIATE_TEST_SUITE_P(
    KeptSheets, KeptSheetsOf,
    testing::Values(
        Way{"raised"}, Way{"at_the_pixels", RenderMode::composite, Quality::normal, false},
        Way{"raised_in_depth", RenderMode::composite, Quality::best},
        Way{"gradients", RenderMode::composite, Quality::draft, true, false, GradientMethod::analytic},
        Way{"perspective", RenderMode::composite, Quality::draft, true, true},
        Way{"isosurface", RenderMode::isosurface},
        Way{"isosurface_perspective", RenderMode::isosurface, Quality::draft, true, true},
        Way{"preintegrated", RenderMode::composite, Quality::draft, true, false, {}, Preintegrate::on},
        Way{"preintegrated_unshaded",
            RenderMode::composite,
            Quality::fine,
            false,
            false,
            {},
            Preintegrate::on},
        Way{"xray", RenderMode::xray, Quality::normal, false}, Way{"maximum", RenderMode::maximum}),
    [](const auto& way) { return std::string(way.param.name); });

// The third picture of a view takes the sheets that the second one kept; all are what they would be without.
TEST_P(KeptSheetsOf, PicturesAreTheSame) {
  const Way& way = GetParam();
  const Volume volume;
  Scene scene = volume.scene(way.perspective);
  RenderOptions options;
  options.rays = false;
  options.mode = way.mode, options.quality = way.quality, options.shading = way.shading;
  options.gradient = way.gradient, options.preintegrate = way.preintegrate;
  test::TestContext context(2);
  Drawers kept;
  for (int n = 0; n < 5; ++n) {
    scene.function = ramp_function(0.3 + 0.05 * n, 1 - 0.05 * n, 0.2 + 0.15 * n);
    scene.lights.ambient = 0.1 * n;
    options.iso_value = 0.4 + 0.05 * n;
    ImageStorage fresh(size, size, true), image(size, size, true);
    scene.drawers = nullptr;
    const RenderStats all = draw_kept(context, scene, options, fresh);
    scene.drawers = &kept;
    const RenderStats stats = draw_kept(context, scene, options, image);
    EXPECT_TRUE(same(fresh, image)) << n;
    EXPECT_EQ(stats.drawn.sheets_taken > 0, n >= 2) << n;
    EXPECT_EQ(stats.drawn.points_splatted > 0, n < 2) << n;
    EXPECT_GT(all.drawn.points_splatted, 0u);
    if (n == 1) {
      EXPECT_EQ(stats.drawn.points_occluded, 0u); // whole
    }
  }
}

TEST(KeptSheets, EveryChangeOfTheViewDrawsAnew) {
  const Volume volume, other;
  Scene scene = volume.scene();
  test::TestContext context(2);
  Drawers kept;
  scene.drawers = &kept;
  RenderOptions options;
  options.rays = false;
  ImageStorage image(size, size), smaller(size - 20, size);
  const auto taken = [&](ImageStorage& out) {
    return draw_kept(context, scene, options, out).drawn.sheets_taken > 0;
  };
  const auto settle = [&] {
    for (int n = 0; n < 2; ++n) EXPECT_FALSE(taken(image));
    EXPECT_TRUE(taken(image));
  };
  settle();
  EXPECT_FALSE(taken(smaller));
  EXPECT_TRUE(taken(image)); // two views are remembered
  scene.camera.position = scene.camera.position + Vec3{1e-6, 0, 0};
  settle();
  options.quality = Quality::draft;
  settle();
  options.quality = Quality::normal;
  EXPECT_TRUE(taken(image));
  options.sheet_step = 0.6;
  settle();
  options.preintegrate = Preintegrate::on; // its segments look no farther than the differences
  EXPECT_TRUE(taken(image));
  options.shading = false;
  settle();
  options.preintegrate = Preintegrate::off;
  settle();
  options.mode = RenderMode::isosurface, options.iso_value = 0.5;
  settle();
  scene.slice = &other.slice, scene.points = &other.points;
  settle();
  kept.forget();
  settle();
  options.disable_skips = skip_unchanged;
  EXPECT_FALSE(taken(image));
}

// Sheets take at most their part of the budget and give it back; pictures that find none are drawn.
TEST(KeptSheets, StayWithinTheBudget) {
  const Volume volume;
  Scene scene = volume.scene();
  RenderOptions options;
  options.rays = false;
  options.tile_size = 30; // else smaller where there is little memory
  ImageStorage fresh(size, size, true), image(size, size, true);
  test::TestContext context(2);
  (void)draw_kept(context, scene, options, fresh);
  Tasks tasks(2);
  Progress progress;
  uint64_t needed = 0;
  for (const uint64_t limit : {uint64_t{1} << 40, uint64_t{0}, uint64_t{1}}) {
    const uint64_t part = 2 * KeptSheets::most_of_budget;
    MemoryBudget memory(limit > 1 ? limit : limit ? part * needed + part : part * needed - part);
    Drawers kept;
    scene.drawers = &kept;
    for (int n = 0; n < 4; ++n) {
      const RenderStats stats = render(scene, options, {tasks, memory, progress}, image.image);
      EXPECT_TRUE(same(fresh, image));
      EXPECT_EQ(stats.drawn.sheets_taken > 0, n > 1 && limit > 0) << limit;
    }
    EXPECT_EQ(memory.used() > 0, limit > 0);
    if (needed == 0) needed = memory.used();
    EXPECT_EQ(memory.used(), limit > 0 ? needed : 0);
    kept.forget();
    EXPECT_EQ(memory.used(), 0u);
  }
}

// A picture that ends early leaves nothing half kept.
TEST(KeptSheets, CancelledPicturesKeepNothing) {
  const Volume volume;
  Scene scene = volume.scene();
  RenderOptions options;
  options.rays = false;
  options.tile_size = 30;
  ImageStorage fresh(size, size, true), image(size, size, true);
  test::TestContext context(2);
  (void)draw_kept(context, scene, options, fresh);
  Tasks tasks(2);
  MemoryBudget memory;
  Drawers kept;
  scene.drawers = &kept;
  const auto picture = [&](bool cancelled) {
    Progress progress;
    if (cancelled) progress.cancel();
    return render(scene, options, {tasks, memory, progress}, image.image);
  };
  (void)picture(false);
  EXPECT_THROW((void)picture(true), Error);
  EXPECT_EQ(picture(false).drawn.sheets_taken, 0u); // keeps
  EXPECT_TRUE(same(fresh, image));
  EXPECT_THROW((void)picture(true), Error); // while it takes
  EXPECT_GT(picture(false).drawn.sheets_taken, 0u);
  EXPECT_TRUE(same(fresh, image));
}

} // namespace
} // namespace bccsplat

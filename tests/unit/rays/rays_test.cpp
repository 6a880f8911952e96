// SPDX-License-Identifier: Apache-2.0
// Isosurfaces by rays: passing over cells changes no pixel, pictures are those of the reference and of
// sheets, and whatever rays do not cover is left to sheets.
#include "rays/rays.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "base/error.h"
#include "draw/deep.h"
#include "tests/support/emulated.h"
#include "tests/support/splat_scene.h"

namespace bccsplat {
namespace {

using namespace test;

RenderOptions surface_options(double iso, double step = 0) {
  RenderOptions o;
  o.mode = RenderMode::isosurface, o.iso_value = iso, o.sheet_step = step;
  return o;
}

size_t covered(const ImageStorage& image) {
  size_t count = 0;
  for (size_t p = 3; p < image.rgba.size(); p += 4) count += image.rgba[p] > 0 ? 1 : 0;
  return count;
}

Field3 two_balls() {
  return [](double x, double y, double z) {
    return std::max(0.0, 1 - std::hypot(x - 30, y - 22, z - 9) / 11) +
           std::max(0.0, 1 - std::hypot(x - 8, y - 9, z - 28) / 9);
  };
}

// From all sides, near and far, parallel and not, with and without air, by one thread and by three.
TEST(Rays, PassingOverCellsChangesNoPixel) {
  for (const char* kernel : {"radial16+b2", "radial18+b3", "radial20+b3"}) {
    const Slice dense = make_slice({30, 26, 33}, marschner_lobb(30, 5), kernel);
    const Slice sparse = make_slice({44, 40, 36}, two_balls(), kernel);
    for (const Slice* s : {&dense, &sparse})
      for (const auto& [x, y] : {std::pair{20.0, 30.0}, std::pair{0.0, 0.0}, std::pair{90.0, 0.0},
                                 std::pair{200.0, 75.0}, std::pair{-80.0, 140.0}})
        for (const auto& [size, perspective] :
             {std::pair{37, false}, std::pair{37, true}, std::pair{110, false}, std::pair{110, true}}) {
          const Scene scene =
              make_scene(*s, ramp_function(0, 1, 0.5), fit_camera(*s, perspective, x, y, size, size));
          for (const double step : {3.0, 1.0, 0.3}) {
            RenderOptions o = surface_options(0.4, step);
            ImageStorage some(size, size, true, true, true), all(size, size, true, true, true);
            const RenderStats stats = draw(scene, o, some, 1);
            o.disable_skips = skip_transfer_function;
            (void)draw(scene, o, all, 3);
            EXPECT_TRUE(same_bits(some, all))
                << kernel << ' ' << x << ' ' << y << ' ' << step << ' ' << size << ' ' << perspective;
            EXPECT_GT(covered(all), 20u);
            EXPECT_EQ(stats.drawn.bricks_total, 0u); // of sheets
          }
        }
  }
}

// Nor does a finer look at the cells.
TEST(Rays, RefinedCellsChangeNoPixel) {
  TestContext context(2);
  for (const char* kernel : test::some<const char*>({"radial16+b2", "radial18+b3", "radial20+b3"}, 3)) {
    const Slice dense = make_slice({30, 26, 33}, marschner_lobb(30, 5), kernel);
    const Slice sparse = make_slice({44, 40, 36}, two_balls(), kernel);
    for (const Slice* s : {&dense, &sparse})
      for (const double iso : {0.4, 0.55}) {
        Drawers kept;
        const double target = iso - s->base;
        const uint64_t marks = kept.surface_cells().find(*s, target, context.get(), 1 << 20)->count();
        EXPECT_LT(kept.surface_cells().find(*s, target, context.get())->count(), marks);
        for (const double turn : {0.0, 30.0, 200.0})
          for (const double step : {3.0, 1.0, 0.3}) {
            constexpr int size = 110;
            Scene scene = make_scene(*s, ramp_function(0, 1, 0.5),
                                     fit_camera(*s, false, 20 + turn / 5, turn, size, size));
            RenderOptions o = surface_options(iso, step);
            ImageStorage all(size, size, true, true, true), some(size, size, true, true, true);
            scene.drawers = &kept;
            (void)render(scene, o, context.get(), some.image);
            o.disable_skips = skip_transfer_function;
            (void)draw(scene, o, all, 3);
            EXPECT_TRUE(same_bits(some, all)) << kernel << ' ' << turn << ' ' << step;
            EXPECT_GT(covered(all), 20u);
          }
      }
  }
}

// Rays that spread widely pass more than two blocks of a slab, and from within the field those behind the eye
// are none of theirs.
TEST(Rays, WideViewsFromWithinAreThoseOfASearch) {
  const Slice s = make_slice({40, 36, 44}, marschner_lobb(40, 5));
  for (const double fovy : {40.0, 60.0, 90.0})
    for (const auto& [x, y] : {std::pair{0.0, 0.0}, std::pair{0.0, 40.0}, std::pair{31.0, 20.0},
                               std::pair{-60.0, 100.0}, std::pair{10.0, 215.0}})
      for (const double way : {0.0, 0.4, 0.7}) { // from the fitted place to the middle of the field
        constexpr int width = 240, height = 180;
        Camera camera = fit_camera(s, true, x, y, width, height);
        camera.fovy_degrees = fovy;
        const Vec3 middle{19.5, 17.5, 21.5};
        camera.position = camera.position + way * (middle - camera.position);
        const Scene scene = make_scene(s, ramp_function(0, 1, 0.5), camera);
        for (const double step : {2.0, 0.4}) {
          RenderOptions o = surface_options(0.5, step);
          ImageStorage some(width, height, true, true, true), all(width, height, true, true, true),
              sheets(width, height, true, true, true);
          const RenderStats stats = draw(scene, o, some, 1);
          EXPECT_EQ(stats.drawn.bricks_total, 0u) << fovy << ' ' << x << ' ' << y; // of sheets
          o.disable_skips = skip_transfer_function;
          (void)draw(scene, o, all, 3);
          EXPECT_TRUE(same_bits(some, all)) << fovy << ' ' << x << ' ' << y << ' ' << way << ' ' << step;
          EXPECT_GT(covered(all), 20u);
          if (step > 1) continue;
          o = surface_options(0.5, step), o.rays = false;
          (void)draw(scene, o, sheets);
          EXPECT_GT(compare(some, sheets).db(), 34) << fovy << ' ' << x << ' ' << y << ' ' << way;
        }
      }
}

// A strip of sixteen tiles, for the thread sanitizer: threads mark cells that the others read.
TEST(Rays, ThreadsMarkCells) {
  const Slice s = make_slice({54, 50, 46}, [](double x, double y, double z) {
    return 0.6 + 0.15 * (std::sin(0.8 * x) + std::sin(0.7 * y) + std::sin(0.75 * z));
  });
  constexpr int width = 1024, height = 2;
  static_assert(width >= 16 * ray_tile_edge);
  for (const bool perspective : {false, true}) {
    Camera camera = fit_camera(s, perspective, 20, 30, width, height);
    constexpr double nearer = 0.5 * height / width;
    camera.ortho_height *= nearer, camera.fovy_degrees *= nearer;
    Scene scene = make_scene(s, ramp_function(0, 1, 0.5), camera);
    RenderOptions o = surface_options(0.4, 0.5);
    o.disable_skips = skip_transfer_function;
    ImageStorage all(width, height, true, true, true);
    (void)draw(scene, o, all, 1);
    for (const int i : {width / 4, width / 2, width * 3 / 4}) // in other tiles
      EXPECT_TRUE(std::isfinite(all.depth[i])) << perspective << ' ' << i;
    o.disable_skips = 0;
    for (int turn = 0; turn < 2; ++turn) { // threads meet by chance
      Drawers kept;
      scene.drawers = &kept;
      ImageStorage with(width, height, true, true, true);
      TestContext context(4);
      (void)render(scene, o, context.get(), with.image);
      const auto cells = kept.surface_cells().find(s, 0.4 - s.base, context.get());
      EXPECT_TRUE(std::count(cells->state.begin(), cells->state.end(), SurfaceCells::waiting) > 0);
      EXPECT_TRUE(same_bits(with, all)) << perspective;
    }
  }
}

// Small pictures of larger fields: cells are marked when rays come to them, and only these.
TEST(Rays, CellsMarkedOnTheWayChangeNoPixel) {
  const Slice dense = make_slice({100, 70, 60}, [](double x, double y, double z) {
    return 0.6 + 0.15 * (std::sin(0.8 * x) + std::sin(0.7 * y) + std::sin(0.75 * z));
  });
  const Slice sparse = make_slice({90, 60, 64}, [](double x, double y, double z) {
    return std::max(0.0, 1 - std::hypot(x - 60, y - 30, z - 32) / 27);
  });
  TestContext context(3);
  constexpr int size = 32;
  for (const Slice* s : {&dense, &sparse}) {
    Drawers kept;
    const double target = 0.4 - s->base;
    const auto waiting = [&] {
      const auto cells = kept.surface_cells().find(*s, target, context.get());
      return std::count(cells->state.begin(), cells->state.end(), SurfaceCells::waiting);
    };
    std::vector<std::ptrdiff_t> left; // after each picture
    for (const bool perspective : {false, true})
      for (const auto& [x, y, way] :
           {std::tuple{20.0, 30.0, 0.0}, std::tuple{20.0, 32.0, 0.0}, std::tuple{0.0, 0.0, 0.6},
            std::tuple{90.0, 0.0, 0.0}, std::tuple{-30.0, 100.0, 0.8}, std::tuple{200.0, 75.0, 0.3}}) {
        Camera camera = fit_camera(*s, perspective, x, y, size, size);
        camera.position = camera.position + way * (camera.target - camera.position);
        if (way > 0) camera.fovy_degrees = 70;
        Scene scene = make_scene(*s, ramp_function(0, 1, 0.5), camera);
        RenderOptions o = surface_options(0.4, 0.5);
        ImageStorage anew(size, size, true, true, true), with(size, size, true, true, true),
            all(size, size, true, true, true);
        (void)draw(scene, o, anew, 3);
        scene.drawers = &kept;
        (void)render(scene, o, context.get(), with.image);
        o.disable_skips = skip_transfer_function;
        (void)draw(scene, o, all, 3);
        EXPECT_TRUE(same_bits(anew, all)) << perspective << ' ' << x << ' ' << y;
        EXPECT_TRUE(same_bits(with, all)) << perspective << ' ' << x << ' ' << y;
        EXPECT_GT(covered(all), 10u);
        left.push_back(waiting());
      }
    EXPECT_TRUE(std::is_sorted(left.rbegin(), left.rend()));
    EXPECT_TRUE(left.front() > 0 || s == &sparse);
  }
}

// Near enough that a cell is larger than a tile of pixels.
TEST(Rays, CloseUpsAreThoseOfASearch) {
  const Slice s = make_slice({30, 26, 33}, marschner_lobb(30, 5));
  for (const auto& [zoom, perspective] :
       {std::pair{20.0, false}, std::pair{3000.0, false}, std::pair{20.0, true}, std::pair{3000.0, true}}) {
    Camera camera = fit_camera(s, perspective, 35, 20, 130, 90);
    camera.ortho_height /= zoom, camera.fovy_degrees /= zoom;
    const Scene scene = make_scene(s, ramp_function(0, 1, 0.5), camera);
    RenderOptions o = surface_options(0.5, 0.5);
    ImageStorage some(130, 90), all(130, 90);
    (void)draw(scene, o, some);
    o.disable_skips = skip_transfer_function;
    (void)draw(scene, o, all);
    EXPECT_TRUE(same_bits(some, all)) << zoom << ' ' << perspective;
    EXPECT_GT(covered(all), 100u);
  }
}

// A speck that fills no block: the squares of pixels that its block's picture touches are all looked at.
TEST(Rays, SpecksAreSeenWhole) {
  for (int n = 0; n < 12; ++n) {
    const Slice s = make_slice({24, 24, 24}, [&](double x, double y, double z) {
      return std::max(0.0, 1 - std::hypot(x - 9 - 0.4 * n, y - 12, z - 13 + 0.3 * n) / 2);
    });
    Camera camera = fit_camera(s, n % 2 != 0, 20 + 25 * n, 30 * n, 120, 120);
    camera.ortho_height /= 5, camera.fovy_degrees /= 5;
    const Scene scene = make_scene(s, ramp_function(0, 1, 0.5), camera);
    RenderOptions o = surface_options(0.05, 0.5);
    ImageStorage some(120, 120), all(120, 120);
    (void)draw(scene, o, some);
    o.disable_skips = skip_transfer_function;
    (void)draw(scene, o, all);
    EXPECT_TRUE(same_bits(some, all)) << n;
    EXPECT_GT(covered(all), 100u) << n;
  }
}

TEST(Rays, LookAtFewSamples) {
  const Slice s = make_slice({44, 40, 36}, two_balls());
  const Scene scene = make_scene(s, ramp_function(0, 1, 0.5), fit_camera(s, false, 20, 30, 90, 90));
  const SheetView view = make_view(s, resolve_camera(scene.camera), 90, 90, 1);
  const ClassTable table = make_class_table(scene.function, 0, 1, 0, 1, 256);
  ShotOptions o;
  o.mode = RenderMode::isosurface, o.surfaces = {{0.5, 1, {}}};
  ASSERT_TRUE(rays_cover(s, view, o));
  Shot shot;
  shot.slice = &s, shot.view = &view, shot.table = &table, shot.lights = &scene.lights, shot.options = o;
  TestContext context(2);
  RayCounts some, all;
  const auto nowhere = [](const TilePixels&) {};
  (void)draw_rays(shot, context.get(), nowhere, nullptr, &some);
  shot.options.disable_skips = skip_transfer_function;
  (void)draw_rays(shot, context.get(), nowhere, nullptr, &all);
  EXPECT_EQ(some.hits, all.hits);
  EXPECT_GT(some.hits, 100u);
  EXPECT_LT(some.samples, all.samples / 4);
  EXPECT_LT(some.samples, 8 * some.hits);
}

// What the reference and sheets draw, but where rays graze.
TEST(Rays, PicturesAreThoseOfTheReference) {
  constexpr int n = 36, size = 124;
  const Slice s = make_slice({n, n, n}, marschner_lobb(n, 5));
  for (const bool perspective : {false, true}) {
    const Scene scene =
        make_scene(s, ramp_function(0, 1, 0.5), fit_camera(s, perspective, 20, 30, size, size));
    RenderOptions o = surface_options(0.5);
    ImageStorage exact(size, size), rays(size, size), sheets(size, size);
    (void)draw(scene, o, rays);
    o.rays = false;
    const RenderStats by_sheets = draw(scene, o, sheets);
    EXPECT_GT(by_sheets.drawn.points_after_cull, 0u);
    o.reference = true;
    (void)draw(scene, o, exact);
    EXPECT_GT(compare(rays, exact).db(), 41) << perspective;
    EXPECT_GT(compare(rays, sheets).db(), 38) << perspective;
  }
}

// Voxels that are no cubes, and axes that are not perpendicular, too: rays are aslant to the sheets.
TEST(Rays, VoxelsMayHaveAnyShape) {
  constexpr int size = 110;
  Affine3 flat, slanted;
  flat.linear[2] = {0, 0, 1.7};
  slanted.linear = {Vec3{1, 0.4, 0}, Vec3{0, 0.8, 0.3}, Vec3{0, 0, 1.3}};
  for (const Affine3& affine : {Affine3(), flat, slanted}) {
    const Slice s = make_slice({44, 40, 36}, two_balls(), "default", affine);
    for (const auto& [x, y, perspective] :
         {std::tuple{20.0, 30.0, false}, std::tuple{-50.0, 70.0, false}, std::tuple{35.0, 200.0, false},
          std::tuple{20.0, 30.0, true}, std::tuple{-50.0, 70.0, true}, std::tuple{35.0, 200.0, true}}) {
      const Scene scene =
          make_scene(s, ramp_function(0, 1, 0.5), fit_camera(s, perspective, x, y, size, size));
      RenderOptions o = surface_options(0.4);
      ImageStorage rays(size, size), sheets(size, size);
      EXPECT_EQ(draw(scene, o, rays).drawn.bricks_total, 0u);
      o.rays = false;
      (void)draw(scene, o, sheets);
      EXPECT_GT(compare(rays, sheets).db(), 29) << x << ' ' << y << ' ' << perspective;
      EXPECT_NEAR(static_cast<double>(covered(rays)), static_cast<double>(covered(sheets)), 20.0);
    }
  }
}

// Every plane holds what that of sheets does: of a smooth surface, shaded and not, with a colour of its own.
TEST(Rays, PlanesMeanWhatThoseOfSheetsDo) {
  constexpr int size = 100;
  const Slice s = make_slice({44, 40, 36}, two_balls());
  Scene scene = make_scene(s, ramp_function(0, 1, 0.5), fit_camera(s, false, 20, 30, size, size));
  scene.lights.lights = {{{0.3, 1, -0.4}, {1, 0.8, 0.5}}, Light()};
  for (const bool shading : {true, false})
    for (const bool own_color : {false, true})
      for (const auto& [smooth, perspective] :
           {std::pair{false, false}, std::pair{true, false}, std::pair{false, true}, std::pair{true, true}}) {
        scene.camera = fit_camera(s, perspective, 20, 30, size, size);
        RenderOptions o = surface_options(0.5, 0.25);
        o.shading = shading, o.smooth_edges = smooth;
        if (own_color) o.surfaces = {{0.5, 1, Vec3{0.1, 0.7, 0.4}}};
        ImageStorage rays(size, size, true, true, true), sheets(size, size, true, true, true);
        const RenderStats by_rays = draw(scene, o, rays);
        o.rays = false;
        const RenderStats by_sheets = draw(scene, o, sheets);
        EXPECT_GT(compare(rays, sheets).db(), 45);
        EXPECT_EQ(by_rays.edge_pixels > 0, smooth);
        EXPECT_EQ(by_rays.drawn.sheets, by_sheets.drawn.sheets);
        EXPECT_EQ(by_rays.drawn.points_total, static_cast<uint64_t>(s.points()));
        EXPECT_EQ(by_rays.drawn.points_after_cull, 0u);
        size_t seen = 0, other = 0;
        for (size_t p = 0; p < rays.depth.size(); ++p) {
          if (std::isfinite(rays.depth[p]) != std::isfinite(sheets.depth[p])) {
            ++other;
            continue;
          }
          EXPECT_EQ(std::isnan(rays.value[p]), std::isnan(sheets.value[p]));
          EXPECT_EQ(std::isnan(rays.time[p]), std::isnan(sheets.time[p]));
          if (!std::isfinite(rays.depth[p])) {
            EXPECT_EQ(rays.depth[p], sheets.depth[p]);
            continue;
          }
          ++seen;
          EXPECT_NEAR(rays.depth[p], sheets.depth[p], 0.02);
          EXPECT_EQ(rays.value[p], sheets.value[p]);
          EXPECT_EQ(rays.time[p], sheets.time[p]);
        }
        EXPECT_GT(seen, 200u);
        EXPECT_LT(other, seen / 50);
      }
}

// A scene that rays cover, and one change after the other that they do not.
TEST(Rays, LeaveTheRestToSheets) {
  constexpr int size = 24;
  Slice s = make_slice({12, 12, 12}, marschner_lobb(12, 1));
  const Slice cartesian = make_slice({12, 12, 12}, marschner_lobb(12, 1), "default", {}, 0, LatticeKind::cc);
  const Slice wide = make_slice({12, 12, 12}, marschner_lobb(12, 1), "fine");
  const Slice paper = make_slice({12, 12, 12}, marschner_lobb(12, 1), "paper");
  ShotOptions o;
  o.mode = RenderMode::isosurface, o.surfaces = {{0.5, 1, {}}};
  const auto covers = [&](const Slice& slice, double fovy = 0, double step = 0.5) {
    Camera camera = fit_camera(slice, fovy > 0, 20, 30, size, size);
    if (fovy > 0) camera.fovy_degrees = fovy;
    return rays_cover(slice, make_view(slice, resolve_camera(camera), size, size, step), o);
  };
  ASSERT_TRUE(covers(s));
  const SheetView view =
      make_view(s, resolve_camera(fit_camera(s, false, 20, 30, size, size)), size, size, 0.5);
  Shot shot;
  shot.slice = &s, shot.view = &view, shot.options = o;
  const std::array<const Shot*, 2> shots{&shot, &shot};
  EXPECT_TRUE(RayDrawer().covers(Shots(shots).first(1)));
  EXPECT_FALSE(RayDrawer().covers(shots)); // sheets draw several
  EXPECT_TRUE(covers(s, 30));
  EXPECT_FALSE(covers(s, 150));
  EXPECT_FALSE(covers(s, 0, 5e-7));
  EXPECT_FALSE(covers(cartesian));
  EXPECT_FALSE(covers(wide));
  EXPECT_FALSE(covers(paper));
  const auto without = [&](const char* what, auto change) {
    const auto options = std::make_unique<ShotOptions>(o);
    Slice changed = s;
    change(changed, o);
    EXPECT_FALSE(covers(changed)) << what;
    o = *options;
    EXPECT_TRUE(covers(s)) << what;
  };
  without("composite", [](Slice&, ShotOptions& p) { p.mode = RenderMode::composite; });
  without("deep", [](Slice&, ShotOptions& p) { p.with_deep = true; });
  without("no surface", [](Slice&, ShotOptions& p) { p.surfaces.clear(); });
  without("two surfaces", [](Slice&, ShotOptions& p) { p.surfaces.push_back({0.7, 1, {}}); });
  without("transparent", [](Slice&, ShotOptions& p) { p.surfaces[0].opacity = 0.5; });
  without("another hyperplane", [](Slice& c, ShotOptions&) { c.hyperplane = Hyperplane{1, 0, 0, 0, 0}; });
  without("periodic", [](Slice& c, ShotOptions&) { c.lattice.periodic[1] = true; });
  without("normalised", [](Slice& c, ShotOptions&) { c.kernel.normalised = true; });
  without("holes", [](Slice& c, ShotOptions&) { c.has_holes = true; });
  without("a mask", [](Slice& c, ShotOptions&) {
    c.mask = std::shared_ptr<const SliceMask>(std::shared_ptr<int>(), reinterpret_cast<const SliceMask*>(&c));
  });
  without("corrections", [](Slice& c, ShotOptions&) {
    c.corrections = std::shared_ptr<const SliceCorrections>(std::shared_ptr<int>(),
                                                            reinterpret_cast<const SliceCorrections*>(&c));
  });
  without("a clip", [](Slice& c, ShotOptions&) { c.clip.push_back({{1, 0, 0}, -1}); });
  without("a plane without thickness", [](Slice& c, ShotOptions&) { c.domain_begin[2] = c.domain_end[2]; });
  without("nothing", [](Slice& c, ShotOptions&) { c.domain_end = {-1, -1, -1}; });
}

TEST(Rays, DrawNoTrailAndNothingDeep) {
  constexpr int size = 24;
  const Slice s = make_slice({12, 12, 12}, marschner_lobb(12, 1));
  const Scene scene = make_scene(s, ramp_function(0, 1, 0.5), fit_camera(s, false, 20, 30, size, size));
  TestContext context(2);
  RenderOptions o = surface_options(0.5);
  ImageStorage image(size, size);
  const auto drawer = [&](const Scene& of) {
    return std::string(Picture(of, o, context.get(), image.image).drawer());
  };
  EXPECT_EQ(drawer(scene), "rays");
  Scene with_trail = scene;
  const Trail trail;
  with_trail.trail = &trail, with_trail.trail_functions = {scene.function};
  EXPECT_EQ(drawer(with_trail), "sheets");
  DeepImage deep;
  image.image.deep = &deep;
  EXPECT_EQ(drawer(scene), "sheets");
  image.image.deep = nullptr;
  o.rays = false;
  EXPECT_EQ(drawer(scene), "sheets");
  o.rays = true, o.reference = true;
  EXPECT_EQ(drawer(scene), "reference");
}

// A camera that moves looks at the same cells; pictures are those without any that are kept.
TEST(Rays, KeepCellsAcrossViews) {
  constexpr int size = 60;
  const Slice s = make_slice({30, 26, 33}, marschner_lobb(30, 5));
  Drawers kept;
  TestContext context(2);
  for (const double turn : {0.0, 50.0, 100.0, 230.0})
    for (const double iso : {0.5, 0.3}) {
      Scene scene = make_scene(s, ramp_function(0, 1, 0.5), fit_camera(s, false, 20, turn, size, size));
      const RenderOptions o = surface_options(iso);
      ImageStorage anew(size, size), with(size, size);
      (void)draw(scene, o, anew);
      scene.drawers = &kept;
      (void)render(scene, o, context.get(), with.image);
      EXPECT_TRUE(same_bits(anew, with)) << turn << ' ' << iso;
    }
  const auto cells = kept.surface_cells().find(s, 0.5 - s.base, context.get());
  EXPECT_EQ(cells.use_count(), 2); // it had been kept
  const uint64_t used = context.memory.used();
  Scene scene = make_scene(s, ramp_function(0, 1, 0.5), fit_camera(s, false, 20, 77, size, size));
  scene.drawers = &kept;
  ImageStorage out(size, size);
  (void)render(scene, surface_options(0.5), context.get(), out.image);
  EXPECT_EQ(kept.surface_cells().find(s, 0.5 - s.base, context.get()), cells);
  EXPECT_EQ(context.memory.used(), used);
}

TEST(Rays, HearCancelsAndTakeMemory) {
  const Slice s = make_slice({40, 40, 40}, marschner_lobb(40, 5));
  const Scene scene = make_scene(s, ramp_function(0, 1, 0.5), fit_camera(s, false, 20, 30, 200, 200));
  ImageStorage out(200, 200);
  const auto code = [&](const Context& context) {
    try {
      (void)render(scene, surface_options(0.5), context, out.image);
    } catch (const Error& e) {
      return e.code();
    }
    return Code::internal;
  };
  // After some tiles; how often it is asked before depends on the machine.
  int told = 0;
  Progress stops([&](double fraction) {
    told += fraction > 0;
    return fraction > 0 ? 1 : 0;
  });
  TestContext context(1), small(2, 2000);
  EXPECT_EQ(code(context.get().with(stops)), Code::cancelled);
  EXPECT_EQ(told, 1);
  EXPECT_EQ(context.memory.used(), 0u);
  // What tiles are searched in is asked for, too: a budget for the cells and their way alone is none.
  TestContext marks(1);
  const uint64_t cells = mark_cells(s, 0.5, marks.get()).memory.bytes();
  TestContext few(1, 400000), enough(1, 2000000);
  EXPECT_LT(cells, 100000u);
  EXPECT_EQ(code(few.get()), Code::memory_budget);
  EXPECT_EQ(few.memory.used(), 0u);
  EXPECT_EQ(code(enough.get()), Code::internal); // none
  EXPECT_EQ(code(small.get()), Code::memory_budget);
  EXPECT_EQ(small.memory.used(), 0u);
}

} // namespace
} // namespace bccsplat

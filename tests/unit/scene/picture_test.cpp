// SPDX-License-Identifier: Apache-2.0
// The renderer against closed forms and against the slow reference.
#include "scene/picture.h"

#include <map>

#include <gtest/gtest.h>

#include "tests/support/dense_layer.h"
#include "tests/support/splat_scene.h"

namespace bccsplat {
namespace {

using namespace test;

Affine3 anisotropic() {
  Affine3 a;
  a.linear = {Vec3{1, 0, 0}, Vec3{0, 1.3, 0.2}, Vec3{0, 0, 2}};
  a.offset = {3, -50, 8};
  return a;
}

RenderOptions unshaded(double step) {
  RenderOptions o;
  o.shading = false;
  o.sheet_step = step;
  o.opacity_stop = 1;
  return o;
}

TEST(Render, ConstantFieldHasTheOpacityOfItsPath) {
  for (const bool perspective : {false, true})
    for (const double step : {1.0, 0.37, 0.125}) {
      const Slice slice = make_slice(
          {12, 9, 11}, [](double, double, double) { return 5; }, "default", anisotropic());
      TransferFunction f;
      f.colors = {{0, {0.5, 0.25, 1}}};
      f.opacities = {{0, 0}, {1, 0.08}, {10, 0.08}};
      f.unit_distance = 1.7;
      const int width = 33, height = 21;
      const Scene scene = make_scene(slice, f, fit_camera(slice, perspective, 20, 30, width, height));
      ImageStorage out(width, height, true, true, true);
      draw(scene, unshaded(step), out);
      const SheetView view = make_view(slice, resolve_camera(scene.camera), width, height, step);
      for (int j = 0; j < height; ++j)
        for (int i = 0; i < width; ++i) {
          const auto [k0, k1] = ray_interval(slice, view, i, j);
          const double path = k0 < k1 ? (k1 - k0) * length(view.lattice_to_world.vector(view.ray(i, j))) : 0;
          const double alpha = 1 - std::pow(1 - 0.08, path / 1.7);
          const float* p = out.image.rgba.at(i, j);
          ASSERT_NEAR(p[3], alpha, 2e-6) << i << ' ' << j << " step " << step;
          ASSERT_NEAR(p[0], 0.5 * alpha, 2e-6);
          ASSERT_NEAR(p[2], alpha, 2e-6);
          if (alpha > 1e-4) {
            ASSERT_NEAR(*out.image.value.at(i, j), 5, 5 * 0.003); // the kernel's ripple
          } else if (alpha == 0) {
            ASSERT_TRUE(std::isnan(*out.image.value.at(i, j)));
          }
          if (alpha > 0.51) {
            // Half the light is gone after this much of the path.
            const double k = k0 + (k1 - k0) * std::log(0.5) / std::log(1 - alpha);
            ASSERT_NEAR(*out.image.depth.at(i, j), (k + view.depth) * view.step_world, 2e-3);
          } else if (alpha < 0.49) {
            ASSERT_TRUE(std::isinf(*out.image.depth.at(i, j)));
          }
        }
    }
}

TEST(Render, APlaneOfOneSampleIsAsThickAsASample) {
  const Affine3 world = anisotropic(); // samples of 1 x 1.3 x 2
  for (const size_t axis : {size_t{0}, size_t{2}})
    for (const bool perspective : {false, true})
      for (const double step : {1.0, 0.25}) {
        std::array<uint32_t, 3> dims{12, 12, 12};
        dims[axis] = 1;
        Slice slice = make_slice(dims, [](double, double, double) { return 5; }, "default", {});
        slice.slice_to_world.linear = {Vec3{1, 0, 0}, Vec3{0, 1.3, 0}, Vec3{0, 0, 2}};
        slice.slice_to_world.offset = world.offset;
        TransferFunction f;
        f.colors = {{0, {0.5, 0.25, 1}}};
        f.opacities = {{0, 0}, {1, 0.3}, {10, 0.3}};
        f.unit_distance = 1.7;
        const Scene scene =
            make_scene(slice, f, fit_camera(slice, perspective, 0, axis == 0 ? 90 : 0, 33, 33));
        ImageStorage out(33, 33, true, true, true);
        draw(scene, unshaded(step), out);
        const double thickness = axis == 0 ? 1 : 2;
        EXPECT_NEAR(out.image.rgba.at(16, 16)[3], 1 - std::pow(1 - 0.3, thickness / 1.7), 1e-5)
            << axis << ' ' << perspective << " step " << step;
        EXPECT_NEAR(*out.image.value.at(16, 16), 5, 5 * 0.02);
        // Edges and inside must be those of the slow integration.
        ImageStorage slow(33, 33, true, true, true);
        TestContext context;
        (void)render_reference(scene, unshaded(step), slice_field(slice), {}, context.get(), slow.image);
        for (int j = 0; j < 33; ++j)
          for (int i = 0; i < 33; ++i)
            EXPECT_NEAR(out.image.rgba.at(i, j)[3], slow.image.rgba.at(i, j)[3], 2e-3) << i << ' ' << j;
      }
}

TEST(Render, XrayOfASingleSiteIsTheKernelsLineIntegral) {
  // One coefficient in the middle of an empty domain.
  Slice slice = make_slice({15, 15, 15}, [](double, double, double) { return 0; });
  const Int3 site{5, 5, 5};
  const Int3 n = slice.coset[0].dims();
  std::vector<float> dense(static_cast<size_t>(n[0]) * n[1] * n[2]);
  dense[(site[2] * n[1] + site[1]) * n[0] + site[0]] = 3;
  slice.coset[0] = test::layer_from_dense(slice.lattice, 0, dense);
  slice.bounds = {0, 3 * slice.kernel.space.value(0)};
  for (const bool perspective : {false, true}) {
    const int size = 41;
    Scene scene =
        make_scene(slice, ramp_function(0, 1, 0.5), fit_camera(slice, perspective, 25, -40, size, size));
    RenderOptions o = unshaded(0.25);
    o.mode = RenderMode::xray;
    ImageStorage out(size, size);
    draw(scene, o, out);
    const SheetView view = make_view(slice, resolve_camera(scene.camera), size, size, 1);
    const Vec3 centre = slice.site(0, site);
    double most = 0;
    for (int j = 0; j < size; ++j)
      for (int i = 0; i < size; ++i) {
        const Vec3 ray = view.ray(i, j);
        const double per_step = length(view.lattice_to_world.vector(ray));
        double integral = 0;
        const double h = 1e-3;
        const auto [k0, k1] = ray_interval(slice, view, i, j);
        for (double k = k0 + h / 2; k < k1; k += h) {
          const Vec3 d = view.sample(i, j, k) - centre;
          integral += 3 * slice.kernel.space.value(dot(d, d)) * h * per_step;
        }
        // Sheets 0.25 T apart integrate this smooth kernel all but exactly.
        ASSERT_NEAR(out.image.rgba.at(i, j)[0], integral, 2e-4) << i << ' ' << j;
        most = std::max(most, integral);
      }
    EXPECT_GT(most, 1);
  }
}

struct Geometry {
  const char* name;
  bool perspective;
  bool anisotropic;
  int width, height;
  LatticeScales scales{1, 1, 1, 1};
};

class AgainstReference : public testing::TestWithParam<Geometry> {
 protected:
  Slice slice_ =
      make_slice({20, 17, 22}, marschner_lobb(20, 2.2), "default",
                 GetParam().anisotropic ? anisotropic() : Affine3{}, 0, LatticeKind::bcc, GetParam().scales);
  Scene scene_ =
      make_scene(slice_, ramp_function(0.3, 1, 0.35),
                 fit_camera(slice_, GetParam().perspective, 20, 30, GetParam().width, GetParam().height));

  void SetUp() override {
    // Pictures of one row or column show the whole volume along their length.
    const int width = GetParam().width, height = GetParam().height;
    scene_.camera.ortho_height *= static_cast<double>(std::min(width, height)) / std::max(width, height);
    if (width == 1) scene_.camera.position = fit_camera(slice_, true, 20, 30, 1, 1).position;
  }

  double db(RenderOptions o, double scale = 1) const {
    ImageStorage reference(GetParam().width, GetParam().height, true, true, true),
        got(GetParam().width, GetParam().height, true, true, true);
    o.reference = true;
    draw(scene_, o, reference);
    o.reference = false;
    draw(scene_, o, got);
    return compare(reference, got).db() + 20 * std::log10(scale);
  }
};
INSTANTIATE_TEST_SUITE_P(
    Render, AgainstReference,
    testing::Values(Geometry{"orthographic", false, false, 37, 41},
                    Geometry{"perspective", true, false, 37, 41},
                    Geometry{"anisotropic", false, true, 41, 37},
                    Geometry{"anisotropic_perspective", true, true, 41, 37},
                    Geometry{"distances", false, false, 37, 41, {0.7, 0.85, 2.3, 1}},
                    Geometry{"distances_perspective", true, true, 37, 41, {2.3, 0.7, 1, 1}},
                    Geometry{"row", false, false, 53, 1}, Geometry{"column", true, false, 1, 53}),
    [](const auto& instance) { return instance.param.name; });

TEST_P(AgainstReference, ClassifiesAndCompositesToSecondOrder) {
  // The limits are what was measured less about 6 dB, for better kernels change the field.
  const double coarse = db(unshaded(1)), middle = db(unshaded(0.5)), fine = db(unshaded(0.25));
  EXPECT_GT(coarse, 43);
  EXPECT_GT(middle, 56);
  EXPECT_GT(fine, 68);
  EXPECT_GT(fine - coarse, 2 * 9.0); // two halvings, 12 dB each when second order
}

TEST_P(AgainstReference, ShadesWithTheKernelsGradient) {
  RenderOptions o;
  o.opacity_stop = 1;
  o.gradient = GradientMethod::analytic;
  o.without_ripple = false; // of the reference: the kernel's gradient has it
  o.sheet_step = 0.5;
  const double middle = db(o);
  o.sheet_step = 0.125;
  const double fine = db(o);
  EXPECT_GT(middle, 34);
  EXPECT_GT(fine, 44);
}

TEST_P(AgainstReference, IntegratesXrays) {
  RenderOptions o = unshaded(0.5);
  o.mode = RenderMode::xray;
  const double longest = length(slice_.slice_to_world.vector({19, 16, 21}));
  EXPECT_GT(db(o, longest), 75);
}

TEST_P(AgainstReference, FindsMaxima) {
  RenderOptions o = unshaded(0.25);
  o.mode = RenderMode::maximum;
  EXPECT_GT(db(o), 50);
}

TEST_P(AgainstReference, FindsSurfaces) {
  RenderOptions o;
  o.mode = RenderMode::isosurface;
  o.iso_value = 0.55;
  o.sheet_step = 0.25;
  const int width = GetParam().width, height = GetParam().height;
  ImageStorage reference(width, height, true, true, true), got(width, height, true, true, true);
  o.reference = true;
  draw(scene_, o, reference);
  o.reference = false;
  draw(scene_, o, got);
  // A ray that grazes the surface or the domain may miss on one side: a few pixels. All others agree closely.
  size_t hits = 0, differ = 0;
  for (int j = 0; j < height; ++j)
    for (int i = 0; i < width; ++i) {
      const float *a = reference.image.rgba.at(i, j), *b = got.image.rgba.at(i, j);
      const float da = *reference.image.depth.at(i, j), db = *got.image.depth.at(i, j);
      if (a[3] == 0 && b[3] == 0) continue;
      ++hits;
      if (a[3] != b[3] || std::fabs(da - db) > 2e-3f || std::fabs(a[0] - b[0]) > 5e-3f) ++differ;
    }
  EXPECT_GT(hits, static_cast<size_t>(width * height) / 12);
  EXPECT_LT(differ, 3 + hits / 50);
}

TEST(Render, DifferencesApproachTheKernelsGradient) {
  // Many pixels per T: differences over two neighbours are closer to the truth than over one, and cost
  // sheets, not points.
  const Slice slice = make_slice({16, 16, 16}, marschner_lobb(16, 1.5));
  for (const bool perspective : {false, true}) {
    Scene scene =
        make_scene(slice, ramp_function(0.3, 1, 0.3), fit_camera(slice, perspective, 20, 30, 80, 80));
    RenderOptions o;
    o.opacity_stop = 1;
    o.sheet_step = 0.25;
    ImageStorage reference(80, 80), got(80, 80);
    o.reference = true;
    draw(scene, o, reference);
    o.reference = false;
    const auto db = [&](GradientMethod method) {
      o.gradient = method;
      draw(scene, o, got);
      return compare(reference, got).db();
    };
    const double analytic = db(GradientMethod::analytic), central = db(GradientMethod::central);
    const double fourth = db(GradientMethod::fourth_order);
    EXPECT_GT(analytic, 44);
    EXPECT_GT(central, 36);
    EXPECT_GT(fourth, central + 1);
  }
}

TEST(Render, CameraInsideTheVolume) {
  const Slice slice = make_slice({20, 20, 20}, marschner_lobb(20, 2));
  Camera c;
  c.perspective = true;
  c.position = {9.3, 10.1, 6.2}, c.target = {15, 12, 18}, c.up = {0, 1, 0}, c.fovy_degrees = 70;
  const Scene scene = make_scene(slice, ramp_function(0.2, 1, 0.3), c);
  RenderOptions o = unshaded(0.25);
  ImageStorage reference(40, 30), got(40, 30);
  o.reference = true;
  draw(scene, o, reference);
  o.reference = false;
  draw(scene, o, got);
  EXPECT_GT(compare(reference, got).db(), 65);
  o.shading = true;
  o.gradient = GradientMethod::analytic;
  o.without_ripple = false;
  o.reference = true;
  draw(scene, o, reference);
  o.reference = false;
  draw(scene, o, got);
  EXPECT_GT(compare(reference, got).db(), 45);
}

TEST(Render, NothingOutsideTheView) {
  const Slice slice = make_slice({10, 10, 10}, [](double, double, double) { return 1; });
  Camera c;
  c.position = {4.5, 4.5, 30}, c.target = {4.5, 4.5, 60}, c.up = {0, 1, 0},
  c.perspective = true; // looks away
  const Scene scene = make_scene(slice, ramp_function(0, 1, 0.5), c);
  ImageStorage out(16, 16);
  draw(scene, {}, out);
  for (const float v : out.rgba) EXPECT_EQ(v, 0);
}

TEST(Render, NeitherThreadsNorTilesChangeABit) {
  for (const bool perspective : {false, true})
    for (const auto gradient :
         {GradientMethod::analytic, GradientMethod::central, GradientMethod::fourth_order}) {
      const Slice slice = make_slice({30, 24, 28}, marschner_lobb(28, 3));
      const Scene scene =
          make_scene(slice, ramp_function(0.3, 1, 0.9), fit_camera(slice, perspective, 20, 30, 75, 67));
      RenderOptions o;
      o.gradient = gradient;
      o.tile_size = 64;
      ImageStorage first(75, 67, true, true, true);
      draw(scene, o, first, 1);
      for (const auto& [tile, threads] : {std::pair{64, 3}, {7, 1}, {23, 2}, {200, 2}, {0, 4}}) {
        o.tile_size = tile;
        ImageStorage other(75, 67, true, true, true);
        draw(scene, o, other, threads);
        EXPECT_TRUE(same_bits(first, other)) << "tile " << tile << " threads " << threads;
      }
    }
}

TEST(Render, SkipsChangeNothing) {
  // A ball in an empty domain, partly outside the picture, opaque inside: every skip has something to skip.
  const Slice slice = make_slice({64, 64, 64}, [](double x, double y, double z) {
    return 1 / (1 + std::exp(2 * (std::hypot(x - 31, y - 31, z - 31) - 14)));
  });
  TransferFunction f = ramp_function(0, 1, 0.95);
  f.opacities = {{0.5, 0}, {0.6, 0.95}};
  Scene scene = make_scene(slice, f, fit_camera(slice, false, 20, 30, 80, 80));
  scene.camera.ortho_height *= 0.5;
  for (const auto mode : {RenderMode::composite, RenderMode::isosurface}) {
    RenderOptions o;
    o.mode = mode;
    o.iso_value = 0.5;
    o.rays = false;
    o.gradient = GradientMethod::analytic;
    o.tile_size = 16;
    ImageStorage all(80, 80, true, true, true);
    const RenderStats skipped = draw(scene, o, all);
    EXPECT_GT(skipped.drawn.bricks_invisible, 0u);
    EXPECT_GT(skipped.drawn.points_occluded, 0u);
    EXPECT_GT(skipped.drawn.sheets_skipped, 0u);
    EXPECT_GT(skipped.drawn.points_invisible, 0u);
    std::map<uint32_t, uint64_t> left; // points after culling
    for (const uint32_t bit : {1u, 2u, 3u, 4u, 8u, 64u, 79u}) {
      o.disable_skips = bit;
      ImageStorage other(80, 80, true, true, true);
      const RenderStats full = draw(scene, o, other);
      left[bit] = full.drawn.points_after_cull;
      EXPECT_TRUE(same_bits(all, other)) << "skip " << bit << " mode " << static_cast<int>(mode);
      if (bit & 1) {
        EXPECT_EQ(full.drawn.bricks_invisible, 0u);
        EXPECT_GT(full.drawn.bricks_outside, 0u);
      }
      if (bit & 65) {
        EXPECT_EQ(full.drawn.points_invisible, 0u);
      }
      if (bit & 4) {
        EXPECT_EQ(full.drawn.points_occluded, 0u);
      }
      if (bit & 8) {
        EXPECT_EQ(full.drawn.sheets_skipped, 0u);
      }
    }
    EXPECT_GT(left[3], left[1]); // bricks beside the picture
  }
}

TEST(Render, PointsBeyondASurfaceAreLeftOut) {
  // Rays that start beyond the surface, and rays that reach it from air: nothing is seen of the points left
  // out.
  const Slice slice = make_slice({48, 44, 52}, marschner_lobb(48, 1.5));
  for (const bool perspective : {false, true})
    for (const double turn : {20.0, 200.0})
      for (const double iso : {0.35, 0.6})
        for (const double step : {0.5, 1.0}) {
          const Scene scene =
              make_scene(slice, ramp_function(0, 1, 1), fit_camera(slice, perspective, 20, turn, 72, 60));
          RenderOptions o;
          o.mode = RenderMode::isosurface, o.rays = false;
          o.iso_value = iso, o.sheet_step = step;
          ImageStorage all(72, 60, true, true, true), other(72, 60, true, true, true);
          o.disable_skips = 79;
          const RenderStats full = draw(scene, o, all);
          o.disable_skips = 0;
          const RenderStats skipped = draw(scene, o, other);
          EXPECT_TRUE(same_bits(all, other)) << perspective << ' ' << turn << ' ' << iso << ' ' << step;
          EXPECT_EQ(full.drawn.points_invisible, 0u);
          EXPECT_GT(skipped.drawn.points_invisible, 0u);
        }
}

TEST(Render, AirThatAbsorbsIsDrawnWhereNoPointIs) {
  // All sites equal air: nothing is stored, but the function shows air.
  const Slice slice = make_slice(
      {12, 12, 12}, [](double, double, double) { return 2; }, "default", {}, 2);
  ASSERT_EQ(slice.points(), 0);
  TransferFunction f;
  f.colors = {{0, {1, 1, 1}}};
  f.opacities = {{0, 0}, {2, 0.1}};
  const Scene scene = make_scene(slice, f, fit_camera(slice, false, 0, 0, 16, 16));
  ImageStorage out(16, 16);
  draw(scene, unshaded(0.5), out);
  EXPECT_NEAR(out.image.rgba.at(8, 8)[3], 1 - std::pow(0.9, 11), 1e-5);
}

TEST(Render, OpacityStopEndsAPixelAndNoSooner) {
  const Slice slice = make_slice({24, 24, 24}, marschner_lobb(24, 2));
  const Scene scene = make_scene(slice, ramp_function(0.1, 1, 0.5), fit_camera(slice, false, 20, 30, 48, 48));
  RenderOptions o;
  o.opacity_stop = 1;
  ImageStorage full(48, 48), stopped(48, 48);
  draw(scene, o, full);
  o.opacity_stop = 0.9;
  draw(scene, o, stopped);
  for (size_t p = 3; p < full.rgba.size(); p += 4) {
    EXPECT_LE(stopped.rgba[p], full.rgba[p]);
    if (full.rgba[p] < 0.9f) {
      EXPECT_EQ(stopped.rgba[p], full.rgba[p]);
    } else {
      EXPECT_GE(stopped.rgba[p], 0.9f);
    }
  }
}

TEST(Render, LightsTheSideThatFacesThem) {
  const Slice slice = make_slice({24, 24, 24}, [](double x, double y, double z) {
    return 12 - std::hypot(x - 11.5, y - 11.5, z - 11.5);
  });
  Scene scene = make_scene(slice, ramp_function(0, 12, 1), fit_camera(slice, false, 0, 0, 49, 49));
  RenderOptions o;
  o.mode = RenderMode::isosurface;
  o.iso_value = 4;
  ImageStorage out(49, 49);
  draw(scene, o, out);
  // The headlight: bright in the middle, dark at the rim, the same all around.
  EXPECT_GT(out.image.rgba.at(24, 24)[0], 1.5f * out.image.rgba.at(24, 16)[0] - 0.2f);
  EXPECT_NEAR(out.image.rgba.at(24, 17)[0], out.image.rgba.at(24, 31)[0], 1e-3);
  EXPECT_NEAR(out.image.rgba.at(17, 24)[0], out.image.rgba.at(24, 31)[0], 1e-3);
  // From above and in front: the highlight and the brightest side are in the upper half.
  scene.lights.lights = {{{0, 1, -1}, {1, 1, 1}}};
  draw(scene, o, out);
  EXPECT_GT(out.image.rgba.at(24, 17)[0], out.image.rgba.at(24, 31)[0] + 0.1f);
}

TEST(Render, HolesAreNotDrawn) {
  Slice slice = make_slice({16, 16, 16}, [](double, double, double) { return 1; });
  // The lower half of x is missing.
  for (auto& layer : slice.coset)
    for (size_t s = 0; s < layer.brick_slots(); ++s) {
      auto brick = std::make_shared<Brick>();
      brick->value = layer.brick(s)->value;
      brick->kept = layer.brick(s)->kept;
      brick->hole = std::make_unique<BrickMask>();
      brick->hole->fill(0x001f); // sites 0 to 4 of each row
      layer.set(s, std::move(brick));
    }
  slice.has_holes = true;
  const Scene scene = make_scene(slice, ramp_function(0, 1, 0.3), fit_camera(slice, false, 0, 0, 32, 32));
  ImageStorage out(32, 32);
  draw(scene, unshaded(0.5), out);
  const double pixel = scene.camera.ortho_height / 32;
  for (int i = 0; i < 32; ++i) {
    const double x = 7.5 - (i - 15.5) * pixel; // +x points left
    const float alpha = out.image.rgba.at(i, 16)[3];
    if (x > 0.1 && x < 5.5) {
      EXPECT_EQ(alpha, 0) << x;
    } else if (x > 8 && x < 14.9) {
      EXPECT_GT(alpha, 0.9f) << x;
    }
  }
}

TEST(Render, ReportsAndCancels) {
  const Slice slice = make_slice({24, 24, 24}, marschner_lobb(24, 2));
  const Scene scene = make_scene(slice, ramp_function(0.1, 1, 0.5), fit_camera(slice, false, 20, 30, 48, 48));
  ImageStorage out(48, 48);
  const RenderStats stats = draw(scene, {}, out);
  EXPECT_GT(stats.drawn.points_total, static_cast<uint64_t>(slice.points())); // with mirror images
  EXPECT_LE(stats.drawn.points_after_cull, stats.drawn.points_total);
  EXPECT_GT(stats.drawn.points_splatted, 0u);
  EXPECT_EQ(stats.sheet_step, 0.5);
  TestContext context;
  context.progress.cancel();
  try {
    render(scene, {}, context.get(), out.image);
    ADD_FAILURE() << "not cancelled";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), Code::cancelled);
  }
  TestContext poor(1, 1000);
  EXPECT_THROW(render(scene, {}, poor.get(), out.image), Error);
}

} // namespace
} // namespace bccsplat

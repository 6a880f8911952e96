// SPDX-License-Identifier: Apache-2.0
// Pictures by the GPU's two entries against those of the CPU: 45 dB at least, in every mode. Where pixels are
// so large that the CPU's gradients, by differences of pixels, are the coarser ones, the truth decides.
#include "tests/unit/gpu/both_pictures.h"

namespace bccsplat {
namespace {

using namespace test;

class GpuPictures : public BothPictures {};

TEST_P(GpuPictures, CompositesFromAllSides) {
  const Slice lobb = make_slice({31, 31, 31}, marschner_lobb(31, 4.5));
  const Slice round = make_slice({36, 30, 33}, ball());
  const Slice cloud = make_slice({60, 48, 40}, smoke());
  for (const Slice* s : {&lobb, &round, &cloud})
    for (const bool perspective : {false, true}) {
      const int size = s == &lobb ? 2 * pixels : pixels; // whose gradients by differences need close pixels
      const Scene scene =
          make_scene(*s, ramp_function(0.1, 1, 0.3), fit_camera(*s, perspective, 25, 40, size, size));
      RenderOptions o;
      o.shading = s != &cloud || perspective;
      EXPECT_GT(differ(scene, o, size, size).db(), *o.shading ? least_db : 100)
          << (s == &lobb) << perspective;
      EXPECT_GT(alike(cpu->value, gpu->value, 0.01), 0.98);
      EXPECT_GT(alike(cpu->depth, gpu->depth, 0.1), 0.98);
      EXPECT_GT(alike(cpu->time, gpu->time, 1e-4), 0.999);
    }
}

TEST_P(GpuPictures, QualitiesAndKernels) {
  for (const auto& [kernel, quality] :
       {std::pair{"fast", Quality::normal}, std::pair{"fine", Quality::draft},
        std::pair{"paper", Quality::normal}, std::pair{"gauss09", Quality::draft},
        std::pair{"default", Quality::fine}}) {
    const Slice s = make_slice({33, 30, 28}, ball(), kernel);
    const Scene scene =
        make_scene(s, ramp_function(0.1, 1, 0.3), fit_camera(s, true, 20, 30, pixels, pixels));
    RenderOptions o;
    o.quality = quality;
    EXPECT_GT(differ(scene, o).db(), least_db) << kernel;
  }
}

// A narrow peak and a step, which are classified by integrals.
TEST_P(GpuPictures, NarrowFunctionsByIntegrals) {
  const Slice s = make_slice({36, 30, 33}, ball());
  TransferFunction f = ramp_function(0, 1, 0);
  f.opacities = {{0.4, 0}, {0.41, 0.9}, {0.42, 0}, {0.8, 0}, {0.8, 0.4}};
  const Scene scene = make_scene(s, f, fit_camera(s, false, 25, 40, pixels, pixels));
  for (const Preintegrate how : {Preintegrate::automatic, Preintegrate::off}) {
    RenderOptions o;
    o.preintegrate = how;
    EXPECT_GT(differ(scene, o).db(), least_db);
  }
}

TEST_P(GpuPictures, Isosurfaces) {
  const Slice lobb = make_slice({41, 41, 41}, marschner_lobb(41, 4));
  const Slice cloud = make_slice({60, 48, 40}, smoke());
  for (const Slice* s : {&lobb, &cloud}) {
    const bool perspective = s == &cloud;
    const Scene scene =
        make_scene(*s, ramp_function(0.1, 1, 0.3), fit_camera(*s, perspective, 25, 40, pixels, pixels));
    RenderOptions o;
    o.mode = RenderMode::isosurface, o.iso_value = 0.5;
    (void)differ(scene, o);
    EXPECT_GT(db_but_grazes(*cpu, *gpu), least_db);
    EXPECT_GT(alike(cpu->depth, gpu->depth, 0.01), 0.98);
    o.surfaces = {{0.3, 0.4, Vec3{1, 0.2, 0.1}}, {0.5, 0.5, {}}, {0.7, 1, {}}};
    (void)differ(scene, o);
    EXPECT_GT(db_but_grazes(*cpu, *gpu), least_db);
    EXPECT_GT(alike(cpu->value, gpu->value, 0.01), 0.98);
    o.surfaces.clear(), o.smooth_edges = true;
    (void)differ(scene, o);
    EXPECT_GT(db_but_grazes(*cpu, *gpu), least_db);
  }
}

// Pixels of 0.7 T, across which the CPU takes differences.
TEST_P(GpuPictures, NearerToTheTruth) {
  constexpr int size = 58;
  const Slice s = make_slice({25, 25, 25}, marschner_lobb(25, 3.6));
  const Scene scene = make_scene(s, ramp_function(0.1, 1, 0.3), fit_camera(s, false, 25, 40, size, size));
  RenderOptions o;
  (void)differ(scene, o, size, size);
  ImageStorage truth(size, size);
  o.reference = true;
  (void)draw(scene, o, truth);
  EXPECT_GT(compare(*gpu, truth).db(), 43);
  EXPECT_GT(compare(*gpu, truth).db(), compare(*cpu, truth).db());
}

TEST_P(GpuPictures, XraysAndMaxima) {
  const Slice cloud = make_slice({60, 48, 40}, smoke());
  for (const RenderMode mode : {RenderMode::xray, RenderMode::maximum})
    for (const bool perspective : {false, true}) {
      Scene scene = make_scene(cloud, ramp_function(0.1, 1, 0.6),
                               fit_camera(cloud, perspective, 25, 40, pixels, pixels));
      RenderOptions o;
      o.mode = mode;
      ImageError e = differ(scene, o);
      if (mode == RenderMode::xray) {
        const float most = *std::max_element(cpu->value.begin(), cpu->value.end(),
                                             [](float a, float b) { return !(b <= a); });
        e.rmse /= std::isfinite(most) ? most : 20;
      }
      EXPECT_GT(e.db(), least_db) << static_cast<int>(mode);
      if (mode == RenderMode::maximum) {
        o.shading = true;
        EXPECT_GT(differ(scene, o).db(), least_db);
      }
    }
}

// Clips, a host's depths, eyes within the field and pictures off their axis.
TEST_P(GpuPictures, ViewsThatAreCut) {
  const Slice s = make_slice({41, 41, 41}, marschner_lobb(41, 4));
  std::vector<float> depths(size_t{pixels} * pixels);
  for (const bool perspective : {false, true}) {
    const Camera camera = fit_camera(s, perspective, 25, 40, 2 * pixels, 2 * pixels);
    Scene scene = make_scene(s, ramp_function(0.1, 1, 0.3), camera);
    Sight sight = make_sight(camera, 2 * pixels, 2 * pixels).region(pixels / 3, pixels / 2);
    sight.clip = {{{0.6, 0, 0.8}, -14}, {{0, -1, 0}, 33}};
    const double middle = dot(sight.forward, Vec3{20, 20, 20} - sight.position);
    for (size_t p = 0; p < depths.size(); ++p)
      depths[p] = static_cast<float>(middle + 10 * std::sin(0.05 * static_cast<double>(p % pixels)));
    sight.ends = {depths.data(), pixels};
    scene.sight = sight;
    RenderOptions o;
    EXPECT_GT(differ(scene, o).db(), least_db) << perspective;
    o.mode = RenderMode::isosurface, o.iso_value = 0.5;
    (void)differ(scene, o);
    EXPECT_GT(db_but_grazes(*cpu, *gpu), least_db) << perspective;
  }
  Camera within = fit_camera(s, true, 0, 0, pixels, pixels);
  within.position = {20, 20, 15}, within.fovy_degrees = 70;
  const Scene scene = make_scene(s, ramp_function(0.3, 1, 0.3), within);
  EXPECT_GT(differ(scene, {}).db(), least_db);
}

// Lattices with skew axes in the world, values of an unusual unit, lights and noise.
TEST_P(GpuPictures, WorldsUnitsAndLights) {
  Affine3 affine;
  affine.linear = {Vec3{2, 0.3, 0}, Vec3{0, 1.5, 0.2}, Vec3{0.1, 0, -3}};
  affine.offset = {100, -50, 7};
  constexpr double unit = 3e-12;
  const Field3 field = smoke();
  const Slice s = make_slice(
      {60, 48, 40}, [&](double x, double y, double z) { return unit * field(x, y, z); }, "default", affine);
  Scene scene =
      make_scene(s, ramp_function(0.1 * unit, unit, 0.3), fit_camera(s, true, 25, 40, pixels, pixels));
  scene.lights.lights = {{{1, -1, -2}, {1, 0.8, 0.6}}, {{-1, 0.2, 0.3}, {0.2, 0.3, 0.6}}};
  scene.lights.noise.constant = 0.01 * unit;
  scene.noise_of_ripple = true;
  EXPECT_GT(differ(scene, {}).db(), least_db);
}

// Passing over what is not seen changes nothing.
TEST_P(GpuPictures, SkippingChangesNothing) {
  const Slice s = make_slice({60, 48, 40}, smoke());
  for (const RenderMode mode :
       {RenderMode::composite, RenderMode::isosurface, RenderMode::xray, RenderMode::maximum}) {
    const Scene scene =
        make_scene(s, ramp_function(0.3, 1, 0.3), fit_camera(s, true, 25, 40, pixels, pixels));
    RenderOptions o;
    o.mode = mode, o.iso_value = 0.4, o.backend = Backend::gpu, o.gpu = gpu_;
    ImageStorage some(pixels, pixels, true, true, true), all(pixels, pixels, true, true, true);
    (void)draw(scene, o, some);
    o.disable_skips = skip_transfer_function;
    (void)draw(scene, o, all);
    EXPECT_GT(compare(some, all).db(), 100) << static_cast<int>(mode);
  }
}

INSTANTIATE_TEST_SUITE_P(Entries, GpuPictures, testing::Values(GpuEntry::compute, GpuEntry::fragment),
                         entry_name);

} // namespace
} // namespace bccsplat

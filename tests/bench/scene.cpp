// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/scene.h"

#include "field/coefficients/coefficients.h"
#include "slice/time_slice.h"
#include "tests/support/fields.h"

namespace bccsplat::bench {
namespace {

TransferFunction ramp(double from, double to, double opacity) {
  TransferFunction f;
  f.colors = {{from, {0.2, 0.3, 0.9}}, {0.5 * (from + to), {0.3, 0.8, 0.3}}, {to, {0.9, 0.3, 0.1}}};
  f.opacities = {{from, 0}, {to, opacity}};
  return f;
}

} // namespace

FieldScene marschner_lobb_scene(int samples) {
  return {"Marschner-Lobb", samples, marschner_lobb(samples), ramp(0.3, 1, 0.1), 0.5};
}

FieldScene bessel_scene(int samples) {
  return {"band-limited rings", samples, bessel_rings(samples, 0.8), ramp(0.3, 1, 0.1), 0.5};
}

FieldScene smoke_scene(int samples) {
  return {"smoke", samples, puffs(samples, 0), ramp(0.05, 0.8, 0.3), 0.35};
}

FieldScene waves_scene(int samples) { return {"waves", samples, waves(), ramp(0.3, 1, 0.3), 0.6}; }

SampledScene sample_scene(const FieldScene& scene, LatticeKind kind, const std::string& kernel) {
  BenchContext context(2);
  const uint32_t n = scene.samples;
  const Lattice4 lattice = Lattice4::fit(kind, {n, n, n, 1});
  const MemorySamples samples = test::sample_field(lattice, [&](const Vec4& p) {
    return scene.field({p[0], p[1], p[2]}, nullptr);
  });
  const Coefficients coefficients(samples, 0, make_kernel(kernel), 0, uint64_t{1} << 32);
  SampledScene out;
  out.slice = time_slice(coefficients, 0, {0, 0}, {}, context.get());
  SplatPoints points = make_points(out.slice, context.get());
  points.memory = {}; // the budget ends with this function
  out.points = std::make_shared<const KeptPoints>(std::move(points));
  return out;
}

Camera scene_camera(const FieldScene& scene, int size, double pixels_per_t, bool perspective) {
  MarchGrid grid;
  grid.dims = {scene.samples, scene.samples, scene.samples};
  grid.low = {0}, grid.high = {1};
  const uint32_t pixels = size;
  Camera camera = fit_camera(grid_domain(grid), perspective, 20, 30, pixels, pixels);
  if (pixels_per_t > 0 && !perspective) camera.ortho_height = size / pixels_per_t;
  return camera;
}

Scene splat_scene(const FieldScene& scene, const SampledScene& sampled, const Camera& camera) {
  Scene s;
  s.slice = &sampled.slice, s.points = sampled.points.get();
  s.camera = camera, s.function = scene.function;
  return s;
}

Camera strided_camera(const Camera& camera, int size, int stride) {
  if (stride % 2 != 0) return camera; // the middle of a block is that of a pixel
  const WorldCamera world = resolve_camera(camera);
  const Vec3 shift = 0.5 * camera.ortho_height / size * (world.right - world.up);
  Camera out = camera;
  out.position = camera.position + shift, out.target = camera.target + shift;
  return out;
}

std::unique_ptr<ImageStorage> true_image(const FieldScene& scene, const SampledScene& sampled,
                                         const Camera& camera, const RenderOptions& options, int size,
                                         int stride, bool own, double step) {
  BenchContext context(2);
  Scene s = splat_scene(scene, sampled, camera);
  s.camera = strided_camera(camera, size, stride);
  const Affine3& to_index = sampled.slice.lattice_to_slice;
  const bccsplat::FieldAt field = [&](const Vec3& p, Vec3* gradient) {
    const double value = scene.field(to_index.point(p), gradient);
    if (gradient) *gradient = to_index.transposed(*gradient);
    return value;
  };
  auto out = std::make_unique<ImageStorage>(size / stride, size / stride);
  const auto sums =
      options.without_ripple && shaded(options, sampled.slice) ? lattice_sums(sampled.slice) : nullptr;
  render_reference(s, options, own ? slice_field(sampled.slice, sums) : field, {step}, context.get(),
                   out->image);
  return out;
}

} // namespace bccsplat::bench

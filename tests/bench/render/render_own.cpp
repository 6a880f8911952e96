// SPDX-License-Identifier: Apache-2.0
// The renderer against the exact integration of the field that its own samples stand for: what sheets and
// gradients cost, kernel and lattice apart.
#include <cmath>

#include "tests/bench/render/render.h"

namespace bccsplat::bench {
namespace {

constexpr int own_stride = 8;

int picture_size(int samples, double pixels_per_t) {
  return static_cast<int>(std::ceil(samples * 1.75 * pixels_per_t / 16)) * 16;
}

void unshaded(const Report& report, const FieldScene& scene, const SampledScene& sampled) {
  BenchContext one(1);
  const int size = picture_size(scene.samples, 2);
  const Camera camera = scene_camera(scene, size, 2);
  const Scene s = splat_scene(scene, sampled, camera);
  RenderOptions o;
  o.shading = false, o.opacity_stop = 1;
  const auto exact = true_image(scene, sampled, camera, o, size, own_stride, true);
  std::vector<Row> rows;
  double before = 0;
  for (const double step : {2.0, 1.0, 0.5, 0.25, 0.125}) {
    o.sheet_step = step;
    const ImageError e = method_error(splat_method("splat", s, o, one), size, exact->image, own_stride);
    rows.push_back({figure("step T", step, 3), figure("RMSE", e.rmse, 6), figure("PSNR dB", e.psnr(), 1),
                    figure("max", e.most, 4),
                    figure("order", before > 0 ? std::log2(before / e.rmse) : NAN, 2)});
    before = e.rmse;
  }
  report.table(
      concat(scene.name, ' ', scene.samples,
             "^3, semi-transparent, unshaded, 2 px per T: error of the sheets against the own field"),
      rows);
}

void gradients(const Report& report, const FieldScene& scene, const SampledScene& sampled) {
  BenchContext one(1);
  std::vector<Row> rows;
  for (const double pixels : {1.0, 1.5, 2.0, 3.0, 4.0}) {
    const int size = picture_size(scene.samples, pixels);
    const Camera camera = scene_camera(scene, size, pixels);
    const Scene s = splat_scene(scene, sampled, camera);
    const RenderOptions plain;
    const auto exact = true_image(scene, sampled, camera, plain, size, own_stride, true);
    const auto truth = true_image(scene, sampled, camera, plain, size, own_stride);
    for (const GradientMethod g :
         {GradientMethod::central, GradientMethod::fourth_order, GradientMethod::analytic}) {
      std::vector<Method> methods;
      for (const double step : {1.0, 0.5, 0.25}) {
        RenderOptions o;
        o.sheet_step = step, o.gradient = g;
        methods.push_back(splat_method("splat", s, o, one));
      }
      const std::vector<double> ms = least_ms(methods, size, report.quick ? 1 : 3);
      Row row{figure("px per T", pixels, 1), word("gradient", gradient_name(g))};
      for (size_t i = 0; i < methods.size(); ++i) {
        const std::string step = concat(methods[i].step, " T");
        row.push_back(figure("ms " + step, ms[i], 1));
        row.push_back(
            figure("own dB " + step, method_error(methods[i], size, exact->image, own_stride).psnr(), 1));
        row.push_back(
            figure("truth dB " + step, method_error(methods[i], size, truth->image, own_stride).psnr(), 1));
      }
      rows.push_back(row);
    }
  }
  report.table(
      concat(scene.name, ' ', scene.samples,
             "^3, semi-transparent, shaded: PSNR against the own field and against the analytic one"),
      rows);
}

// What the quality settings promise.
void settings(const Report& report, const FieldScene& scene, const SampledScene& sampled) {
  BenchContext one(1);
  std::vector<Row> rows;
  for (const double pixels : {1.0, 2.0, 4.0}) {
    const int size = picture_size(scene.samples, pixels);
    const Camera camera = scene_camera(scene, size, pixels);
    const Scene s = splat_scene(scene, sampled, camera);
    RenderOptions flat, shaded;
    flat.shading = false;
    const auto exact = true_image(scene, sampled, camera, shaded, size, own_stride, true);
    const auto exact_flat = true_image(scene, sampled, camera, flat, size, own_stride, true);
    const auto truth = true_image(scene, sampled, camera, shaded, size, own_stride);
    std::vector<Method> plain, lit;
    for (const Quality q : {Quality::draft, Quality::normal, Quality::fine, Quality::best}) {
      flat.quality = shaded.quality = q;
      plain.push_back(splat_method(quality_name(q), s, flat, one));
      lit.push_back(splat_method(quality_name(q), s, shaded, one));
    }
    const std::vector<double> ms = least_ms(lit, size, report.quick ? 1 : 3);
    for (size_t i = 0; i < lit.size(); ++i)
      rows.push_back(
          {figure("px per T", pixels, 0), word("quality", lit[i].name), figure("ms", ms[i], 1),
           figure("unshaded, own dB", method_error(plain[i], size, exact_flat->image, own_stride).psnr(), 1),
           figure("shaded, own dB", method_error(lit[i], size, exact->image, own_stride).psnr(), 1),
           figure("shaded, truth dB", method_error(lit[i], size, truth->image, own_stride).psnr(), 1)});
  }
  report.table(
      concat(scene.name, ' ', scene.samples,
             "^3, semi-transparent: the quality settings against the own field and the analytic one"),
      rows);
}

void surfaces(const Report& report, const FieldScene& scene, const SampledScene& sampled) {
  BenchContext one(1);
  std::vector<Row> rows;
  for (const double pixels : {1.0, 2.0, 4.0}) {
    const int size = picture_size(scene.samples, pixels);
    const Camera camera = scene_camera(scene, size, pixels);
    const Scene s = splat_scene(scene, sampled, camera);
    RenderOptions o;
    o.mode = RenderMode::isosurface, o.iso_value = scene.iso_value;
    const auto exact = true_image(scene, sampled, camera, o, size, own_stride, true);
    for (const double step : {1.0, 0.5, 0.25}) {
      o.sheet_step = step;
      const ImageError e = method_error(splat_method("splat", s, o, one), size, exact->image, own_stride);
      rows.push_back({figure("px per T", pixels, 0), figure("step T", step, 2),
                      figure("PSNR dB", e.psnr(), 1), figure("RMSE", e.rmse, 5), figure("max", e.most, 3)});
    }
  }
  report.table(concat(scene.name, ' ', scene.samples, "^3, isosurface, shaded: against the own field"), rows);
}

} // namespace

void render_own(const Report& report) {
  const FieldScene scene = marschner_lobb_scene(report.quick ? 20 : 41);
  const SampledScene sampled = sample_scene(scene, LatticeKind::bcc, "default");
  unshaded(report, scene, sampled);
  settings(report, scene, sampled);
  gradients(report, scene, sampled);
  surfaces(report, scene, sampled);
  if (report.quick) return;
  const FieldScene rings = bessel_scene(41);
  gradients(report, rings, sample_scene(rings, LatticeKind::bcc, "default"));
}

} // namespace bccsplat::bench

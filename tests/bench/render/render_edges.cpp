// SPDX-License-Identifier: Apache-2.0
// Isosurfaces with smooth edges: what they cost, and how much nearer they are to the area average of the
// picture at eight times the size.
#include <algorithm>
#include <cmath>

#include "tests/bench/render/render.h"

namespace bccsplat::bench {
namespace {

constexpr int factor = 8;

// The error over the pixels that the smoothing drew, in dB.
double edge_psnr(const Image& picture, const Image& truth, const Image& plain, const Image& smooth) {
  double sum = 0;
  uint64_t count = 0;
  for (int j = 0; j < truth.height; ++j)
    for (int i = 0; i < truth.width; ++i) {
      if (std::equal(plain.rgba.at(i, j), plain.rgba.at(i, j) + 4, smooth.rgba.at(i, j))) continue;
      for (int c = 0; c < 4; ++c)
        sum += std::pow(static_cast<double>(picture.rgba.at(i, j)[c] - truth.rgba.at(i, j)[c]), 2);
      count += 4;
    }
  return -10 * std::log10(sum / static_cast<double>(count));
}

// With the truth where `size` is small enough for it.
Row measure_edges(const FieldScene& scene, const SampledScene& sampled, Quality quality, int size,
                  bool perspective, int rounds) {
  BenchContext one(1), two(2);
  const Camera camera = scene_camera(scene, size, 0, perspective);
  const Scene s = splat_scene(scene, sampled, camera);
  RenderOptions o;
  o.mode = RenderMode::isosurface, o.iso_value = scene.iso_value, o.quality = quality;
  ImageStorage plain(size, size), smooth(size, size);
  const auto before = splat_method("plain", s, o, one);
  (void)render(s, o, one.get(), plain.image);
  o.smooth_edges = true;
  const auto after = splat_method("smooth", s, o, one);
  const RenderStats stats = render(s, o, one.get(), smooth.image);
  const std::vector<double> ms = least_ms(std::array{before, after}, size, rounds);
  o.smooth_edges = false;
  ImageStorage large(factor * size, factor * size);
  (void)render(s, o, two.get(), large.image);
  const auto truth = area_average(large.image, factor);
  const double pixels = static_cast<double>(size) * size;
  return {word("scene", scene.name),
          figure("n", scene.samples, 0),
          word("view", perspective ? "perspective" : "orthographic"),
          word("quality", quality_name(quality)),
          figure("size", size, 0),
          figure("edge pixels %", 100 * static_cast<double>(stats.edge_pixels) / pixels, 2),
          figure("ms", ms[0], 1),
          figure("ms smooth", ms[1], 1),
          figure("us per pixel", 1e3 * (ms[1] - ms[0]) / static_cast<double>(stats.edge_pixels), 2),
          figure("dB", image_error(plain.image, truth->image).psnr(), 1),
          figure("dB smooth", image_error(smooth.image, truth->image).psnr(), 1),
          figure("edges dB", edge_psnr(plain.image, truth->image, plain.image, smooth.image), 1),
          figure("edges dB smooth", edge_psnr(smooth.image, truth->image, plain.image, smooth.image), 1)};
}

} // namespace

void render_edges(const Report& report) {
  const int rounds = report.quick ? 1 : 5, size = report.quick ? 96 : 512;
  std::vector<Row> rows;
  for (const int n : report.quick ? std::vector{32} : std::vector{128, 256}) {
    for (const FieldScene& scene : {marschner_lobb_scene(n), bessel_scene(n), smoke_scene(n)}) {
      const SampledScene sampled = sample_scene(scene, LatticeKind::bcc, "default");
      for (const Quality q : {Quality::draft, Quality::normal, Quality::fine})
        rows.push_back(measure_edges(scene, sampled, q, size, false, rounds));
      rows.push_back(measure_edges(scene, sampled, Quality::normal, size, true, rounds));
    }
  }
  report.table(concat("Smooth edges of isosurfaces: CPU ms of one thread, least of ", rounds,
                      "; error against the area average of ", factor, " x ", factor, " pixels"),
               rows);
}

} // namespace bccsplat::bench

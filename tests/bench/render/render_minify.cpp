// SPDX-License-Identifier: Apache-2.0
// Pictures smaller than the data: each level of a slice against the area average of the picture in full size.
#include <algorithm>
#include <cmath>
#include <utility>

#include "scene/minify.h"
#include "tests/bench/render/render.h"
#include "tests/support/fields.h"

namespace bccsplat::bench {
namespace {

// Waves up to the band limit around a bright ball.
FieldScene noisy_scene(int samples) {
  FieldScene scene = marschner_lobb_scene(samples);
  const test::PlaneWaves waves(24, 0.95, 3, 3);
  const double centre = (samples - 1) / 2.0;
  scene.name = "ball of noise";
  scene.field = [=](const Vec3& p, Vec3*) {
    const double r = std::hypot(p[0] - centre, p[1] - centre, p[2] - centre) / centre;
    return std::exp(-4 * r * r) * (0.7 + 0.15 * waves({p[0], p[1], p[2], 0}));
  };
  return scene;
}

} // namespace

void render_minify(const Report& report) {
  const int n = report.quick ? 32 : 96;
  constexpr int factor = 8;
  BenchContext one(1), two(2);
  std::vector<Row> rows;
  for (const auto& [scene, mode] : {std::pair{noisy_scene(n), RenderMode::composite},
                                    {noisy_scene(n), RenderMode::isosurface},
                                    {noisy_scene(n), RenderMode::xray},
                                    {marschner_lobb_scene(n), RenderMode::composite}}) {
    const SampledScene sampled = sample_scene(scene, LatticeKind::bcc, "default");
    const CoarseLevels levels;
    for (const double pixels : {0.75, 0.5, 0.25, 0.125}) {
      // A size whose eightfold picture is drawn in full.
      const int size = static_cast<int>(std::ceil(n * 1.75 * pixels));
      const Camera camera = scene_camera(scene, size, pixels);
      const Scene scene_0 = splat_scene(scene, sampled, camera);
      RenderOptions o;
      o.mode = mode, o.iso_value = scene.iso_value;
      ImageStorage large(factor * size, factor * size), out(size, size);
      (void)render(scene_0, o, two.get(), large.image);
      const auto truth = area_average(large.image, factor);
      const double most = *std::max_element(truth->rgba.begin(), truth->rgba.end());
      const int chosen = minification_level(sampled.slice, camera, size, size);
      for (int level = 0; level <= (pixels < 0.5 ? 3 : 1); ++level) {
        Scene s = scene_0;
        if (level > 0) {
          const CoarseLevels::Level& coarse = levels.level(sampled.slice, level, two.get());
          s.slice = &coarse.slice, s.points = &coarse.points;
        }
        const RenderStats stats = render(s, o, one.get(), out.image);
        const ImageError e = image_error(out.image, truth->image);
        const std::vector<double> ms = least_ms(std::array{splat_method("splat", s, o, one)}, size, 3);
        rows.push_back(
            {word("scene", scene.name), word("mode", mode_name(mode)), figure("px per T", pixels, 2),
             figure("level", level, 0), word("chosen", level == chosen ? "yes" : ""),
             figure("points", static_cast<double>(stats.drawn.points_total), 0), figure("ms", ms[0], 2),
             figure("RMSE / largest", e.rmse / most, 4), figure("max / largest", e.most / most, 3)});
      }
    }
  }
  report.table(concat("Minification: ", n, "^3, normal, against the area average of ", factor, " x ", factor,
                      " pixels"),
               rows);
}

} // namespace bccsplat::bench

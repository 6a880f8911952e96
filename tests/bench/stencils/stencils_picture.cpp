// SPDX-License-Identifier: Apache-2.0
// Pictures from sheets by stencils and by splatting, in turn: orthographic, shaded, semi-transparent.
#include <algorithm>
#include <memory>
#include <span>

#include "tests/bench/render/render.h"
#include "tests/bench/stencils/stencil_picture.h"
#include "tests/bench/stencils/stencils.h"

namespace bccsplat::bench {
namespace {

struct Direction {
  const char* name;
  double rotate_x, rotate_y; // degrees, as fit_camera()
};
constexpr std::array directions{Direction{"20 / 30 (default)", 20, 30}, Direction{"4 / 5", 4, 5},
                                Direction{"35 / 45", 35, 45}, Direction{"60 / 40", 60, 40}};

void least(StencilTimes& to, const StencilTimes& from) {
  to.plan = std::min(to.plan, from.plan), to.fill = std::min(to.fill, from.fill);
  to.raise = std::min(to.raise, from.raise), to.shade = std::min(to.shade, from.shade);
  to.write = std::min(to.write, from.write);
}

struct Setup {
  int size, stride, rounds;
};

// Prints time and error of both ways, and where the time of the stencils goes.
void pictures(const Report& report, const FieldScene& field, std::span<const Direction> from,
              const Setup& setup) {
  const int size = setup.size;
  const uint32_t pixels = size;
  BenchContext one(1);
  const SampledScene sampled = sample_scene(field, LatticeKind::bcc, "default");
  const double points_ms =
      1e3 * cpu_seconds([&] { [[maybe_unused]] const auto points = make_points(sampled.slice, one.get()); });
  std::vector<Row> rows, stages;
  for (const Direction& direction : from) {
    const Camera camera =
        fit_camera(sampled.slice, false, direction.rotate_x, direction.rotate_y, pixels, pixels);
    const Scene scene = splat_scene(field, sampled, camera);
    const auto truth = true_image(field, sampled, camera, {}, size, setup.stride);
    for (const Quality quality : {Quality::draft, Quality::normal}) {
      RenderOptions options;
      options.quality = quality;
      StencilPicture picture(scene, {});
      StencilTimes best{1e300, 1e300, 1e300, 1e300, 1e300};
      Method stencils;
      stencils.draw = [&](Image& image) {
        picture.draw(quality, image);
        least(best, picture.times());
      };
      const Method splat = splat_method("splatter", scene, options, one);
      StencilPicture tiles(scene, {.whole_sheets = false});
      Method by_tiles;
      by_tiles.draw = [&](Image& image) { tiles.draw(quality, image); };
      const auto ms = least_ms(std::array{splat, stencils, by_tiles}, size, setup.rounds);
      const auto error = [&](const Method& m) { return method_error(m, size, truth->image, setup.stride); };
      const ImageError now = error(splat), then = error(stencils);
      const double cold = (ms[1] + picture.prepare_ms()) / (ms[0] + points_ms);
      rows.push_back({word("view", direction.name), word("quality", quality_name(quality)),
                      figure("splatter ms", ms[0], 1), figure("stencils ms", ms[1], 1),
                      figure("stencils / splatter", ms[1] / ms[0], 2), figure("filled by tiles ms", ms[2], 1),
                      figure("with sites and points made, stencils / splatter", cold, 2),
                      figure("splatter dB", now.psnr(), 1), figure("stencils dB", then.psnr(), 1),
                      figure("splatter max", now.most, 3), figure("stencils max", then.most, 3)});
      stages.push_back(
          {word("view", direction.name), word("quality", quality_name(quality)),
           figure("sheets", static_cast<double>(picture.sheets().all().size()), 0),
           figure("Msamples", 1e-6 * static_cast<double>(picture.sheets().samples()), 2),
           figure("taps", picture.sheets().taps_per_sample(), 1), figure("plan ms", best.plan, 1),
           figure("fill ms", best.fill, 1), figure("raise ms", best.raise, 1),
           figure("shade ms", best.shade, 1), figure("write ms", best.write, 1),
           figure("sites MiB", static_cast<double>(picture.site_bytes()) / 1048576, 1),
           figure("sheets MiB", static_cast<double>(picture.sample_bytes()) / 1048576, 1),
           figure("samples of a tile MiB", static_cast<double>(tiles.sample_bytes()) / 1048576, 2),
           figure("sites made, once an axis, ms", picture.prepare_ms(), 1),
           figure("points made, ms", points_ms, 1)});
    }
  }
  report.table(concat(field.name, ' ', field.samples, "^3, ", size,
                      "^2, CPU ms of one thread, in turn, least of ", setup.rounds,
                      "; PSNR against the analytic field"),
               rows);
  report.table("the same: where the time goes (each the least), what is held", stages);
}

} // namespace

void stencils_picture(const Report& report) {
  const Setup setup = report.quick ? Setup{160, 8, 1} : Setup{512, 8, 9};
  pictures(report, marschner_lobb_scene(report.quick ? 40 : 128), directions, setup);
}

void stencils_scenes(const Report& report) {
  const Setup setup = report.quick ? Setup{160, 8, 1} : Setup{512, 8, 5};
  const std::array some{directions[0], directions[2]};
  const int small = report.quick ? 24 : 128, large = report.quick ? 40 : 256;
  pictures(report, smoke_scene(small), some, setup);
  pictures(report, bessel_scene(small), some, setup);
  pictures(report, smoke_scene(large), some, setup);
  pictures(report, marschner_lobb_scene(large), some, setup);
}

} // namespace bccsplat::bench

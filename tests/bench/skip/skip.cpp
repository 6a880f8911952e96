// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/skip/skip.h"

#include "base/error.h"
#include "tests/bench/render/render.h"

namespace bccsplat::bench {
namespace {

struct Skip {
  const char* name;
  uint32_t bits;
  const char* counted;
  uint64_t (*count)(const RenderStats&);
};

constexpr Skip skips[] = {{"transfer function", skip_transfer_function, "bricks invisible",
                           [](const RenderStats& s) { return s.drawn.bricks_invisible; }},
                          {"view frustum", skip_frustum, "bricks outside",
                           [](const RenderStats& s) { return s.drawn.bricks_outside; }},
                          {"occlusion", skip_occlusion, "point visits",
                           [](const RenderStats& s) { return s.drawn.points_occluded; }},
                          {"empty sheets", skip_empty_sheets, "sheets of tiles",
                           [](const RenderStats& s) { return s.drawn.sheets_skipped; }},
                          {"all of them", 15, "points never looked at", [](const RenderStats& s) {
                             return s.drawn.points_total - s.drawn.points_after_cull;
                           }}};

void one_scene(const std::string& name, const Scene& scene, RenderOptions options, int size, int rounds,
               std::vector<Row>& rows) {
  BenchContext one(1);
  for (const Skip& skip : skips) {
    options.disable_skips = 0;
    const Method with = splat_method("with", scene, options, one);
    ImageStorage a(size, size), b(size, size);
    const RenderStats on = render(scene, options, one.get(), a.image);
    options.disable_skips = skip.bits;
    const Method without = splat_method("without", scene, options, one);
    const RenderStats off = render(scene, options, one.get(), b.image);
    const std::vector<double> ms = least_ms(std::array{with, without}, size, rounds);
    rows.push_back({word("scene", name), word("skip", skip.name), word("counted", skip.counted),
                    figure("skipped", static_cast<double>(skip.count(on)), 0),
                    figure("visits with", static_cast<double>(on.drawn.points_splatted), 0),
                    figure("visits without", static_cast<double>(off.drawn.points_splatted), 0),
                    figure("ms with", ms[0], 1), figure("ms without", ms[1], 1),
                    figure("with / without", ms[0] / ms[1], 2),
                    figure("largest change", image_error(a.image, b.image).most, 7)});
  }
}

} // namespace

int run_skip_suite(std::span<const std::string> args, const Report& report) {
  if (!args.empty()) fail(Code::invalid_argument, "skip: unknown option ", args[0]);
  const int n = report.quick ? 40 : 128, size = report.quick ? 160 : 512, rounds = report.quick ? 1 : 3;
  std::vector<Row> rows;
  const FieldScene field = marschner_lobb_scene(n), smooth = bessel_scene(n), smoke = smoke_scene(n);
  const SampledScene dense = sample_scene(field, LatticeKind::bcc, "default"),
                     rings = sample_scene(smooth, LatticeKind::bcc, "default"),
                     sparse = sample_scene(smoke, LatticeKind::bcc, "default");
  const Camera all = scene_camera(field, size, 0), near = scene_camera(field, size, report.quick ? 8 : 6);
  RenderOptions semi, iso;
  iso.rays = false; // they count no points
  iso.mode = RenderMode::isosurface, iso.iso_value = field.iso_value;
  one_scene("Marschner-Lobb, semi-transparent", splat_scene(field, dense, all), semi, size, rounds, rows);
  one_scene("Marschner-Lobb, isosurface", splat_scene(field, dense, all), iso, size, rounds, rows);
  one_scene("Marschner-Lobb, isosurface, near", splat_scene(field, dense, near), iso, size, rounds, rows);
  iso.iso_value = smooth.iso_value;
  one_scene("rings, isosurface", splat_scene(smooth, rings, all), iso, size, rounds, rows);
  one_scene("smoke, semi-transparent", splat_scene(smoke, sparse, all), semi, size, rounds, rows);
  iso.iso_value = smoke.iso_value;
  one_scene("smoke, isosurface", splat_scene(smoke, sparse, all), iso, size, rounds, rows);
  report.table(concat("What skipping saves: ", n, "^3 on BCC, normal, shaded, ", size,
                      "^2; CPU ms of one thread, least of ", rounds, ", in turn"),
               rows);
  return 0;
}

} // namespace bccsplat::bench

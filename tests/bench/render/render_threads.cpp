// SPDX-License-Identifier: Apache-2.0
// What a frame costs on more threads than the machine has cores: the sum of their CPU times tells what the
// division of the work adds, and the largest tile's share of it how long the last thread may run alone.
#include "tests/bench/render/render.h"

namespace bccsplat::bench {
namespace {

void measure(const Report& report, const FieldScene& scene, RenderMode mode, int size,
             std::vector<Row>& rows) {
  const SampledScene sampled = sample_scene(scene, LatticeKind::bcc, "default");
  Scene s = splat_scene(scene, sampled, scene_camera(scene, size, 0));
  for (const Quality q : {Quality::draft, Quality::normal}) {
    RenderOptions o;
    o.quality = q, o.mode = mode, o.iso_value = scene.iso_value;
    BenchContext one(1), two(2), four(4), eight(8);
    std::vector<Method> methods;
    for (BenchContext* c : {&one, &two, &four, &eight}) methods.push_back(splat_method("splat", s, o, *c));
    const std::vector<double> ms = least_ms(methods, size, report.quick ? 1 : 9);
    ImageStorage out(size, size);
    const RenderStats alone = render(s, o, one.get(), out.image),
                      stats = render(s, o, eight.get(), out.image);
    rows.push_back(
        {word("scene", scene.name), word("mode", mode == RenderMode::composite ? "composite" : "isosurface"),
         word("quality", quality_name(q)), figure("pixels", size, 0), figure("ms, 1 thread", ms[0], 1),
         figure("2", ms[1] / ms[0], 3), figure("4", ms[2] / ms[0], 3), figure("8", ms[3] / ms[0], 3),
         figure("tiles of 1", static_cast<double>(alone.drawn.tiles), 0),
         figure("tiles of 8", static_cast<double>(stats.drawn.tiles), 0)});
  }
}

} // namespace

void render_threads(const Report& report) {
  std::vector<Row> rows;
  const FieldScene dense = marschner_lobb_scene(report.quick ? 24 : 128);
  measure(report, dense, RenderMode::composite, report.quick ? 64 : 512, rows);
  measure(report, dense, RenderMode::isosurface, report.quick ? 64 : 512, rows);
  if (!report.quick) {
    measure(report, smoke_scene(256), RenderMode::composite, 512, rows);
    measure(report, dense, RenderMode::composite, 1024, rows);
  }
  report.table("Sum of the threads' CPU times, relative to one thread", rows);
}

} // namespace bccsplat::bench

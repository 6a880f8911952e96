// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/rays/rays.h"

#include <algorithm>
#include <cstring>

#include "base/error.h"
#include "tests/bench/rays/ray_picture.h"
#include "tests/bench/render/render.h"

namespace bccsplat::bench {
namespace {

uint64_t pixels_off(const ImageStorage& a, const ImageStorage& b) {
  uint64_t off = 0;
  for (size_t p = 0; p < a.rgba.size(); p += 4) off += std::memcmp(&a.rgba[p], &b.rgba[p], 16) != 0;
  return off;
}

void add_scene(const FieldScene& field, int size, int rounds, std::vector<Row>& rows) {
  constexpr int stride = 8;
  BenchContext one(1);
  const Camera camera = scene_camera(field, size, 0);
  const SampledScene sampled = sample_scene(field, LatticeKind::bcc, "default");
  const Scene scene = splat_scene(field, sampled, camera);
  const MarchGrid grid =
      make_march_grid({field.samples, field.samples, field.samples}, [&](double x, double y, double z) {
        return field.field({x, y, z}, nullptr);
      });
  MarchOptions m;
  m.mode = RenderMode::isosurface, m.iso_value = field.iso_value;
  const auto distance = march_distances(grid, field.function, m);
  MarchScene march;
  march.grid = &grid, march.distance = &distance, march.camera = camera, march.function = field.function;
  RenderOptions o;
  o.mode = RenderMode::isosurface, o.iso_value = field.iso_value;
  const auto truth = true_image(field, sampled, camera, o, size, stride);
  for (const int parts : {1, 2}) {
    const CellBound bound = cell_bound(sampled.slice.kernel.space, parts);
    CellRanges ranges;
    const double prepare = cpu_seconds([&] { ranges = make_cell_ranges(sampled.slice, parts, bound); });
    RayPicture rays(scene, ranges, field.iso_value), everywhere(scene, ranges, field.iso_value, true);
    for (const Quality quality : {Quality::draft, Quality::normal}) {
      o.quality = quality;
      const double step = quality_settings(quality).sheet_step;
      m.step = step;
      Method anew, kept;
      anew.draw = [&](Image& image) { rays.draw(step, false, image); };
      kept.draw = [&](Image& image) { rays.draw(step, true, image); };
      const Method sheets = splat_method("sheets", scene, o, one), marcher = march_method(march, m, one);
      const auto ms = least_ms(std::array{sheets, kept, anew, marcher}, size, rounds);
      ImageStorage out(size, size), reference(size, size);
      everywhere.draw(step, false, reference.image);
      rays.draw(step, false, out.image);
      const auto hits = static_cast<double>(std::max(rays.counts().hits, uint64_t{1}));
      rows.push_back(
          {word("scene", field.name), figure("parts", parts, 0), word("quality", quality_name(quality)),
           figure("marcher ms", ms[3], 1), figure("sheets ms", ms[0], 1), figure("rays ms", ms[1], 1),
           figure("rays, bits made anew ms", ms[2], 1), figure("marcher / sheets", ms[3] / ms[0], 2),
           figure("marcher / rays", ms[3] / ms[1], 2), figure("marcher / rays, anew", ms[3] / ms[2], 2),
           figure("sheets / rays", ms[0] / ms[1], 2),
           figure("samples per hit", static_cast<double>(rays.counts().samples) / hits, 2),
           figure("hits", hits, 0), figure("pixels off", static_cast<double>(pixels_off(out, reference)), 0),
           figure("marcher dB", method_error(marcher, size, truth->image, stride).psnr(), 1),
           figure("sheets dB", method_error(sheets, size, truth->image, stride).psnr(), 1),
           figure("rays dB", method_error(kept, size, truth->image, stride).psnr(), 1),
           figure("ranges made, once a slice, ms", 1e3 * prepare, 1),
           figure("MiB", static_cast<double>(ranges.bytes()) / 1048576, 1)});
    }
  }
}

} // namespace

int run_rays_suite(std::span<const std::string> args, const Report& report) {
  if (!args.empty()) fail(Code::invalid_argument, "rays: unknown option ", args.front());
  std::vector<Row> bounds, rows;
  for (const char* name : {"radial16+b2", "radial18+b3", "radial20+b3", "radial24+b4"})
    for (const int parts : {1, 2, 4}) {
      const CellBound b = cell_bound(make_kernel(name).space, parts);
      bounds.push_back({word("kernel", name), figure("parts", parts, 0),
                        figure("of half the range", b.of_range, 4), figure("of the middle", b.of_middle, 5)});
    }
  report.table("bounds of a field between the corners of a cell, 0.71 T, or of its parts", bounds);
  const int n = report.quick ? 40 : 128, size = report.quick ? 160 : 512, rounds = report.quick ? 1 : 7;
  for (const FieldScene& field : {marschner_lobb_scene(n), bessel_scene(n), smoke_scene(2 * n)})
    add_scene(field, size, rounds, rows);
  report.table(concat("isosurfaces, shaded, ", size, "^2, CPU ms of one thread, in turn, least of ", rounds),
               rows);
  return 0;
}

} // namespace bccsplat::bench

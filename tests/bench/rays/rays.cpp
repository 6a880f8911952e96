// SPDX-License-Identifier: Apache-2.0
// First pictures make what a slice needs: points and sheets, or the cells that rays look at. Later ones are
// of another view: points and cells are kept. A new value asks for other cells of the same slice.
#include "tests/bench/rays/rays.h"

#include <algorithm>
#include <cstring>

#include "base/error.h"
#include "rays/rays.h"
#include "tests/bench/render/render.h"
#include "tests/support/cell_bound_proof.h"

namespace bccsplat::bench {
namespace {

uint64_t pixels_off(const ImageStorage& a, const ImageStorage& b) {
  uint64_t off = 0;
  for (size_t p = 0; p < a.rgba.size(); p += 4) off += std::memcmp(&a.rgba[p], &b.rgba[p], 16) != 0;
  return off;
}

// What one scene is drawn from.
struct Drawn {
  BenchContext one{1};
  const FieldScene& field;
  int stride, size; // errors are sampled at pixels a stride apart
  SampledScene sampled;
  MarchGrid grid;
  std::vector<uint8_t> distance;
  Scene scene; // keeps what a renderer keeps
  MarchScene march;
  MarchOptions march_options;
  Drawers drawers;
  std::unique_ptr<ImageStorage> truth;

  Drawn(const FieldScene& of, int edge, bool perspective)
      : field(of), stride(perspective ? 9 : 8), size((edge + stride - 1) / stride * stride) {
    const Camera camera = scene_camera(field, size, 0, perspective);
    sampled = sample_scene(field, LatticeKind::bcc, "default");
    scene = splat_scene(field, sampled, camera);
    scene.drawers = &drawers;
    grid = make_march_grid({field.samples, field.samples, field.samples}, [&](double x, double y, double z) {
      return field.field({x, y, z}, nullptr);
    });
    march_options.mode = RenderMode::isosurface, march_options.iso_value = field.iso_value;
    distance = march_distances(grid, field.function, march_options);
    march.grid = &grid, march.distance = &distance, march.camera = camera, march.function = field.function;
    truth = true_image(field, sampled, camera, options(Quality::draft, true), size, stride);
  }
  [[nodiscard]] RenderOptions options(Quality quality, bool rays) const {
    RenderOptions o;
    o.mode = RenderMode::isosurface, o.iso_value = field.iso_value, o.quality = quality, o.rays = rays;
    return o;
  }
  [[nodiscard]] double db(const Method& method) const {
    return method_error(method, size, truth->image, stride).psnr();
  }
};

// The first picture of a slice: nothing is there but its coefficients.
Method first_picture(Drawn& d, const RenderOptions& options) {
  Method m;
  m.draw = [&d, options](Image& image) {
    Scene s = d.scene;
    s.points = nullptr, s.drawers = nullptr;
    (void)render(s, options, d.one.get(), image);
  };
  return m;
}

RayCounts count_samples(Drawn& d, const RenderOptions& options) {
  const SheetView view = make_view(*d.scene.slice, resolve_camera(d.scene.camera), d.size, d.size,
                                   quality_settings(options.quality).sheet_step);
  const ClassTable table = make_class_table(d.scene.function, 0, 1, 0, 1, 16);
  Shot shot;
  shot.slice = d.scene.slice, shot.view = &view, shot.table = &table, shot.lights = &d.scene.lights;
  shot.sums = &d.drawers.sums;
  shot.options.mode = options.mode, shot.options.surfaces = drawn_surfaces(options);
  RayCounts counts;
  (void)draw_rays(
      shot, d.one.get(), [](const TilePixels&) {}, &d.drawers.surface_cells(), &counts);
  return counts;
}

void add_scene(const FieldScene& field, bool perspective, int edge, int rounds, std::vector<Row>& times,
               std::vector<Row>& others) {
  Drawn d(field, edge, perspective);
  const int size = d.size;
  const Field view = word("view", perspective ? "perspective" : "orthographic");
  for (const Quality quality : {Quality::draft, Quality::normal}) {
    RenderOptions by_rays = d.options(quality, true), by_sheets = d.options(quality, false);
    MarchOptions m = d.march_options;
    m.step = quality_settings(quality).sheet_step;
    const std::array methods{march_method(d.march, m, d.one),
                             splat_method("sheets", d.scene, by_sheets, d.one),
                             splat_method("rays", d.scene, by_rays, d.one), first_picture(d, by_sheets),
                             first_picture(d, by_rays)};
    settle(methods[2], size);
    const auto ms = least_ms(methods, size, rounds);
    times.push_back({word("scene", field.name), view, word("quality", quality_name(quality)),
                     figure("marcher ms", ms[0], 1), figure("sheets ms", ms[1], 1),
                     figure("rays ms", ms[2], 1), figure("sheets / rays", ms[1] / ms[2], 2),
                     figure("marcher / rays", ms[0] / ms[2], 2),
                     figure("first, points and sheets ms", ms[3], 1), figure("first, rays ms", ms[4], 1),
                     figure("first, sheets / rays", ms[3] / ms[4], 2)});

    ImageStorage some(size, size), all(size, size), sheets(size, size);
    methods[2].draw(some.image), methods[1].draw(sheets.image);
    by_rays.disable_skips = skip_transfer_function;
    (void)render(d.scene, by_rays, d.one.get(), all.image);
    const RayCounts counts = count_samples(d, by_rays);
    const auto cells =
        d.drawers.surface_cells().find(*d.scene.slice, field.iso_value - d.scene.slice->base, d.one.get());
    others.push_back(
        {word("scene", field.name), view, word("quality", quality_name(quality)),
         figure("marcher dB", d.db(methods[0]), 1), figure("sheets dB", d.db(methods[1]), 1),
         figure("rays dB", d.db(methods[2]), 1),
         figure("rays against sheets dB", image_error(some.image, sheets.image).psnr(), 1),
         figure("pixels off", static_cast<double>(pixels_off(some, all)), 0),
         figure("hits", static_cast<double>(counts.hits), 0),
         figure("samples per hit",
                static_cast<double>(counts.samples) / static_cast<double>(std::max(counts.hits, uint64_t{1})),
                2),
         figure("cells MiB", static_cast<double>(cells->bits.size()) * sizeof(uint64_t) / 1048576, 2)});
  }
}

} // namespace

int run_rays_suite(std::span<const std::string> args, const Report& report) {
  if (!args.empty()) fail(Code::invalid_argument, "rays: unknown option ", args.front());
  std::vector<Row> bounds, times, others;
  for (const char* name : {"radial16+b2", "radial18+b3", "radial20+b3", "radial24+b4"})
    for (const int parts : {1, 2, 4}) {
      const CellBound b = test::prove_cell_bound(make_kernel(name).space, parts);
      bounds.push_back({word("kernel", name), figure("parts", parts, 0),
                        figure("of half the range", b.of_range, 4), figure("of the middle", b.of_middle, 5)});
    }
  report.table("bounds of a field between the corners of a cell, 0.71 T, or of its parts", bounds);
  const int n = report.quick ? 40 : 128, size = report.quick ? 160 : 512, rounds = report.quick ? 1 : 7;
  for (const FieldScene& field :
       {marschner_lobb_scene(n), bessel_scene(n), smoke_scene(2 * n), waves_scene(2 * n)})
    for (const bool perspective : {false, true}) add_scene(field, perspective, size, rounds, times, others);
  report.table(concat("isosurfaces, shaded, ", size,
                      "^2, in perspective a pixel or two more, CPU ms of one thread, in turn, least of ",
                      rounds),
               times);
  report.table("the same: errors, pixels that differ from a search of all cells, memory", others);
  return 0;
}

} // namespace bccsplat::bench

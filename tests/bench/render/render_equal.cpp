// SPDX-License-Identifier: Apache-2.0
// Time at equal error and error at equal time of the splatter and of rays that interpolate trilinearly and by
// cubic B-splines: the same analytic fields, sampled for each of them.
#include "tests/bench/render/equal_error.h"

#include <array>
#include <deque>
#include <optional>
#include <span>

namespace bccsplat::bench {
namespace {

struct Sizes {
  int size, stride, rounds;
};

// T
constexpr std::array all_steps{5.6, 4.0, 2.8, 2.0, 1.4, 1.0, 0.7, 0.5, 0.35, 0.25};

void equal(const Report& report, const FieldScene& field, RenderMode mode, const Sizes& sizes,
           std::vector<Row>& summary, std::vector<Row>& ratios) {
  const bool iso = mode == RenderMode::isosurface;
  BenchContext one(1);
  const Camera camera = scene_camera(field, sizes.size, 0);
  std::deque<SampledScene> sampled; // stay where they are
  std::deque<Scene> scenes;
  Drawers drawers;
  RenderOptions options;
  options.mode = mode, options.iso_value = field.iso_value;
  const auto settings = [&](const std::string& name) {
    Way way{.name = name, .methods = {}, .at_any_step = false, .ms = {}, .psnr = {}};
    for (const Quality q : {Quality::draft, Quality::normal, Quality::fine, Quality::best}) {
      RenderOptions o = options;
      o.quality = q;
      way.methods.push_back(splat_method(quality_name(q), scenes.back(), o, one));
    }
    return way;
  };
  const auto splatter = [&](const std::string& name, std::span<const double> steps,
                            std::optional<GradientMethod> gradient = std::nullopt) {
    Way way{.name = name, .methods = {}, .ms = {}, .psnr = {}};
    for (const double step : steps) {
      RenderOptions o = options_at(step);
      o.mode = mode, o.iso_value = field.iso_value, o.gradient = gradient;
      way.methods.push_back(splat_method("splat", scenes.back(), o, one));
    }
    return way;
  };
  const auto sample = [&](const std::string& kernel) {
    sampled.push_back(sample_scene(field, LatticeKind::bcc, kernel));
    scenes.push_back(splat_scene(field, sampled.back(), camera));
  };
  std::vector<Way> ways;
  sample("default");
  ways.push_back(settings("splatter, settings"));
  ways.push_back(splatter("splatter", all_steps));
  if (iso) { // whose cells a renderer keeps from picture to picture of a value
    scenes.push_back(scenes.back());
    scenes.back().drawers = &drawers;
    ways.push_back(settings("splatter, settings, again"));
    settle(ways.back().methods.back(), sizes.size);
  } else { // isosurfaces have the kernel's own gradients anyway
    ways.push_back(splatter("splatter, kernel's gradient", std::array{5.6, 4.0, 2.8, 2.0, 1.4, 1.0, 0.7},
                            GradientMethod::analytic));
  }
  sample("fine");
  ways.push_back(splatter("splatter, wider kernel", std::array{1.4, 1.0, 0.7, 0.5}));

  std::deque<MarchGrid> grids;
  std::deque<std::vector<uint8_t>> distances;
  std::deque<MarchScene> marches;
  MarchOptions m;
  m.mode = mode, m.iso_value = field.iso_value;
  for (const Interpolation interpolation : {Interpolation::trilinear, Interpolation::tricubic}) {
    const int n = field.samples;
    grids.push_back(make_march_grid(
        {n, n, n},
        [&](double x, double y, double z) {
          return field.field({x, y, z}, nullptr);
        },
        interpolation));
    distances.push_back(march_distances(grids.back(), field.function, m));
    MarchScene& march = marches.emplace_back();
    march.grid = &grids.back(), march.distance = &distances.back();
    march.camera = camera, march.function = field.function;
    const bool cubic = interpolation == Interpolation::tricubic;
    Way way{.name = cubic ? "rays, tricubic" : "rays, trilinear",
            .methods = {},
            .rays = true,
            .ms = {},
            .psnr = {}};
    for (const double step : all_steps) {
      m.step = step;
      way.methods.push_back(march_method(march, m, one));
    }
    ways.push_back(std::move(way));
  }
  const auto truth = true_image(field, sampled.front(), camera, options, sizes.size, sizes.stride);
  measure_ways(ways, sizes.size, sizes.rounds, truth->image, sizes.stride);
  const std::string scene =
      concat(field.name, ' ', field.samples, "^3, ", iso ? "isosurface" : "semi-transparent");
  report_ways(report, concat(scene, ", shaded, ", sizes.size, "^2"),
              concat(", against the analytic field; CPU ms of one thread, least of ", sizes.rounds),
              concat(field.name.substr(0, field.name.find(' ')), iso ? "-iso" : "-semi"), ways);
  ratios.push_back(ratio_row(scene, ways));
  for (Row& row : equal_rows(scene, ways, ways[0].ms[0], ways[0].ms[1])) summary.push_back(std::move(row));
}

} // namespace

void render_equal(const Report& report) {
  const int n = report.quick ? 24 : 128;
  const Sizes sizes = report.quick ? Sizes{96, 8, 1} : Sizes{512, 8, 3};
  std::vector<Row> summary, ratios;
  for (const FieldScene& field :
       {marschner_lobb_scene(n), bessel_scene(n), smoke_scene(report.quick ? 40 : 256)})
    for (const RenderMode mode : {RenderMode::composite, RenderMode::isosurface})
      equal(report, field, mode, sizes, summary, ratios);
  report.table(concat("Equal error and equal time, one thread, ", machine_facts()), summary);
  report.table("Time of rays over time of the splatter at equal error", ratios);
}

} // namespace bccsplat::bench

// SPDX-License-Identifier: Apache-2.0
// Time against error: every way of drawing on the same picture, and the plot. "again": isosurfaces with the
// cells that earlier pictures of the value left, as a renderer keeps them; the others are first pictures.
#include <algorithm>
#include <cmath>
#include <deque>
#include <initializer_list>
#include <optional>

#include "field/lattice_sums.h"
#include "rays/surface_cells.h"
#include "tests/bench/render/render.h"

namespace bccsplat::bench {
namespace {

struct Setup {
  int size, stride, rounds;
  bool few = false; // lattices and kernels: for large scenes
};

Row row_of(const Method& m, double ms, const ImageError& e) {
  return {word("method", m.name),         word("lattice", m.lattice),  word("kernel", m.kernel),
          word("gradient", m.gradient),   figure("step T", m.step, 3), figure("ms", ms, 1),
          figure("PSNR dB", e.psnr(), 1), figure("RMSE", e.rmse, 5),   figure("max", e.most, 3)};
}

// What a plot shows together.
std::string series_of(const Method& m) {
  if (m.name == "ray-marcher") return "ray-marcher, trilinear";
  if (m.name.find("again") != std::string::npos) return "quality settings, later pictures";
  if (m.name.find("quality") != std::string::npos) return "quality settings (draft, normal, fine, best)";
  return m.kernel + " on " + m.lattice + (m.gradient == "by quality" ? "" : ", " + m.gradient);
}

void front(const Report& report, const FieldScene& scene, RenderMode mode, const Setup& setup) {
  const bool iso = mode == RenderMode::isosurface;
  BenchContext one(1);
  const Camera camera = scene_camera(scene, setup.size, 0);
  std::deque<SampledScene> sampled; // stay where they are
  std::deque<Scene> scenes;
  std::vector<Method> methods;
  const auto add_lattice = [&](LatticeKind kind, const std::string& kernel) {
    sampled.push_back(sample_scene(scene, kind, kernel));
    scenes.push_back(splat_scene(scene, sampled.back(), camera));
  };
  const auto add = [&](const std::string& name, RenderOptions o) {
    o.mode = mode, o.iso_value = scene.iso_value;
    methods.push_back(splat_method(name, scenes.back(), o, one));
  };
  add_lattice(LatticeKind::bcc, "default");
  const auto settings = [&](const char* which) {
    for (const Quality q : {Quality::draft, Quality::normal, Quality::fine, Quality::best}) {
      RenderOptions o;
      o.quality = q;
      add(concat("quality ", quality_name(q), which), o);
    }
  };
  settings("");
  Drawers drawers;
  if (iso) {
    scenes.push_back(scenes.back());
    scenes.back().drawers = &drawers;
    settings(", again");
    settle(methods.back(), setup.size);
  }
  const auto steps = [&](std::initializer_list<double> all, std::optional<GradientMethod> gradient) {
    for (const double step : all) {
      RenderOptions o;
      o.sheet_step = step, o.gradient = gradient;
      add("splat", o);
    }
  };
  if (!iso) {
    steps({2, 1, 0.7, 0.5, 0.25}, GradientMethod::fourth_order);
    steps({1, 0.5}, GradientMethod::central);
    steps({1, 0.5}, GradientMethod::analytic);
  }
  struct Lattice {
    LatticeKind kind;
    const char* kernel;
  };
  constexpr LatticeKind bcc = LatticeKind::bcc, cc = LatticeKind::cc;
  for (const Lattice& l :
       {Lattice{bcc, "fast"}, {bcc, "fine"}, {bcc, "paper"}, {cc, "default"}, {cc, "fast"}}) {
    if (setup.few && (std::string(l.kernel) == "fine" || std::string(l.kernel) == "paper")) continue;
    add_lattice(l.kind, l.kernel);
    steps({1}, std::nullopt);
    if (std::string(l.kernel) != "paper") steps({0.5}, std::nullopt); // its error is not the step's
  }

  const int n = scene.samples;
  const MarchGrid grid = make_march_grid({n, n, n}, [&](double x, double y, double z) {
    return scene.field({x, y, z}, nullptr);
  });
  MarchOptions m;
  m.mode = mode, m.iso_value = scene.iso_value;
  const std::vector<uint8_t> distance = march_distances(grid, scene.function, m);
  MarchScene march;
  march.grid = &grid, march.distance = &distance, march.camera = camera, march.function = scene.function;
  for (const double step : {2.0, 1.0, 0.5, 0.25}) {
    m.step = step;
    methods.push_back(march_method(march, m, one));
  }

  RenderOptions exact;
  exact.mode = mode, exact.iso_value = scene.iso_value;
  const auto truth = true_image(scene, sampled.front(), camera, exact, setup.size, setup.stride);
  const std::vector<double> ms = least_ms(methods, setup.size, setup.rounds);
  std::vector<Row> rows;
  Plot plot;
  plot.title = concat(scene.name, ' ', n, "^3, ", iso ? "isosurface" : "semi-transparent", ", shaded, ",
                      setup.size, "^2: error against the analytic field");
  plot.x_label = "CPU time of a frame, ms", plot.y_label = "PSNR, dB", plot.log_x = true;
  for (size_t i = 0; i < methods.size(); ++i) {
    const ImageError e = method_error(methods[i], setup.size, truth->image, setup.stride);
    rows.push_back(row_of(methods[i], ms[i], e));
    const std::string title = series_of(methods[i]);
    auto series = std::find_if(plot.series.begin(), plot.series.end(),
                               [&](const Series& s) { return s.title == title; });
    if (series == plot.series.end()) {
      plot.series.push_back({title, {}, true, {}});
      series = plot.series.end() - 1;
    }
    series->points.push_back({ms[i], e.psnr()});
  }
  report.table(concat(scene.name, ' ', n, "^3, ", iso ? "isosurface" : "semi-transparent", ", shaded, ",
                      setup.size, "^2, against the analytic field; CPU ms of one thread, least of ",
                      setup.rounds),
               rows);
  report.plot(concat("front-", scene.name.substr(0, scene.name.find(' ')), iso ? "-iso" : "-semi"), plot);
}

} // namespace

void render_front(const Report& report) {
  const int n = report.quick ? 24 : 128;
  const Setup setup = report.quick ? Setup{96, 8, 1} : Setup{512, 8, 2};
  front(report, marschner_lobb_scene(n), RenderMode::composite, setup);
  front(report, marschner_lobb_scene(n), RenderMode::isosurface, setup);
  front(report, bessel_scene(n), RenderMode::composite, setup);
  Setup large = setup;
  large.few = true;
  front(report, smoke_scene(report.quick ? 40 : 256), RenderMode::composite, large);
}

} // namespace bccsplat::bench

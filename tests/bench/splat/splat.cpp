// SPDX-License-Identifier: Apache-2.0
// Runs the splat loop on random points of a tile, for each instruction set, and pictures with all their
// stages, beside the peak of one core (splat_floor.h); compares pictures of the short kernels with the
// field's integral.
#include "tests/bench/splat/splat.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <hwy/targets.h>

#include "base/error.h"
#include "splat/plan/plan.h"
#include "splat/tile/tile_memory.h"
#include "tests/bench/report.h"
#include "tests/bench/splat/splat_floor.h"
#include "tests/support/splat_scene.h"

namespace bccsplat::bench {
namespace {

using namespace test;

// An orthographic or perspective picture of `slice` whose middle has `zoom` pixels per T.
Camera zoomed_camera(const Slice& slice, bool perspective, double zoom, uint32_t pixels) {
  Camera camera = fit_camera(slice, perspective, 20, 30, pixels, pixels);
  if (perspective) {
    const double distance = length(camera.target - camera.position);
    const double height = 2 * distance * std::tan(camera.fovy_degrees * std::numbers::pi / 360);
    const Vec3 back = (pixels / zoom / height) * (camera.position - camera.target);
    camera.position = camera.target + back;
  } else {
    camera.ortho_height = pixels / zoom;
  }
  return camera;
}

struct LoopRate {
  double window = 0;    // window samples per second
  double ball = 0;      // samples within the kernel's radius per second
  double per_point = 0; // ns
  int columns = 0, rows = 0, sheets = 0;
};

// Points at random places of a 60 x 60 tile, in the middle gap of the plan.
LoopRate splat_loop(const Slice& slice, bool perspective, double zoom, double step, bool gradient,
                    bool quick) {
  const int tile = 60;
  const SheetView view =
      make_view(slice, resolve_camera(zoomed_camera(slice, perspective, zoom, tile)), tile, tile, step);
  const SplatPoints none;
  const ClassTable table = make_class_table(ramp_function(0.3, 1, 0.3), 0, 1, 0, 1, 256);
  const Lights lights;
  const SplatScene scene{&slice, &none, &view, &table, &lights};
  SplatOptions options;
  options.shading = gradient, options.gradient = GradientMethod::analytic;
  options.tile_size = tile;
  DrawStats stats;
  Tasks tasks(1);
  MemoryBudget memory_budget(UINT64_MAX);
  Progress progress;
  const SplatPlan plan = make_plan(scene, options, {tasks, memory_budget, progress}, stats);
  SheetMemory memory;
  memory.prepare(plan, plan_tile(plan, 0, 0, tile, tile), gradient);
  const KernelPolynomial kernel = kernel_polynomial(slice.kernel.space, KernelForm::flat_form);
  const int64_t gap = (plan.gaps.first + plan.gaps.last) / 2;
  const size_t n = gap - plan.gaps.first;
  const GapLanes lanes = plan.gaps.lanes(gap, plan.ring);
  SplatArgs a;
  a.lanes = &lanes, a.kernel = &kernel, a.depth2 = static_cast<float>(plan.gaps.depth2);
  a.isotropic = plan.gaps.isotropic, a.spare = plan.ring.whole_windows;
  a.columns = plan.gaps.columns[n], a.rows = plan.gaps.rows[n], a.half = plan.gaps.half_x[n];
  for (size_t q = 0; q < (gradient ? 4u : 1u); ++q) a.ring[q] = memory.ring_origin(q);
  a.groups = plan.ring.groups, a.group_floats = memory.group_floats;
  a.pitch = memory.ring_pitch, a.width = memory.ring_width, a.height = memory.ring_height;

  std::mt19937 random(5);
  const auto uniform = [&](double low, double high) {
    return static_cast<float>(std::uniform_real_distribution<double>(low, high)(random));
  };
  std::vector<SplatRecord> records(quick ? 256 : 1024);
  for (SplatRecord& r : records) {
    const float whole_x = plan.gaps.half_x[n], whole_y = plan.gaps.half_y[n];
    r.fx = whole_x - uniform(0, 1), r.fy = whole_y - uniform(0, 1), r.z = uniform(0, 1), r.c = uniform(0, 1);
    r.x = static_cast<int32_t>(uniform(0, std::max(1, tile - a.columns)));
    r.y = static_cast<int32_t>(uniform(0, std::max(1, tile - a.rows)));
    const auto lateral = [&](int start, float foot, const Vec3& g) {
      return perspective ? static_cast<float>((start + static_cast<double>(foot) + dot(g, view.ez)) /
                                              plan.gaps.lateral[n])
                         : 0;
    };
    r.lateral_x = lateral(r.x, r.fx, view.gx), r.lateral_y = lateral(r.y, r.fy, view.gy);
  }
  a.record = records.data(), a.count = records.size();
  const int rounds = std::max(1, static_cast<int>((quick ? 2e6 : 6e7) / static_cast<double>(records.size()) /
                                                  (a.columns * a.rows * plan.ring.sheets)));
  double best = 1e30;
  for (int repeat = 0; repeat < (quick ? 2 : 7); ++repeat)
    best = std::min(best, cpu_seconds([&] {
                      for (int i = 0; i < rounds; ++i) splat_points(a);
                    }));
  const double points = rounds * static_cast<double>(records.size()) / best;
  const double radius = slice.kernel.space.radius * zoom;
  return {points * a.columns * a.rows * plan.ring.sheets,
          points * 4 * std::numbers::pi / 3 * radius * radius * slice.kernel.space.radius / step,
          1e9 / points,
          a.columns,
          a.rows,
          plan.ring.sheets};
}

void floors_table(const Report& report, double peak) {
  std::vector<Row> rows{{word("loop", "multiply-adds in registers"), figure("G floats/s", peak / 1e9, 1),
                         figure("of peak", 1, 3)}};
  for (const int width : {4, 8, 16}) {
    const double rate = update_peak(width);
    rows.push_back({word("loop", concat("memory update, ", width, " x ", width, " pixels x 4 sheets")),
                    figure("G floats/s", rate / 1e9, 1), figure("of peak", rate / peak, 3)});
  }
  report.table("What one core can do", rows);
}

void loop_table(const Report& report, const Slice& slice, double peak) {
  std::vector<Row> rows;
  for (const bool perspective : {false, true})
    for (const bool gradient : {false, true})
      for (const double step : {1.0, 0.5})
        for (const double zoom : {1.0, 2.0, 4.0, 8.0}) {
          if (gradient && zoom > 2) continue; // differences take over there
          const LoopRate r = splat_loop(slice, perspective, zoom, step, gradient, report.quick);
          rows.push_back({word("view", perspective ? "perspective" : "orthographic"),
                          word("sums", gradient ? "value and gradient" : "value"), figure("step", step, 2),
                          figure("pixels per T", zoom, 0),
                          word("window", concat(r.columns, " x ", r.rows, " x ", r.sheets)),
                          figure("ns per point", r.per_point, 1),
                          figure("window samples, of peak", r.window / peak, 3),
                          figure("samples in reach, of peak", r.ball / peak, 3)});
        }
  report.table("The splat loop: points at random places of a tile", rows);
}

void target_table(const Report& report, const Slice& slice) {
  std::vector<Row> rows;
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    Row row{word("target", hwy::TargetName(target))};
    for (const double zoom : {1.0, 2.0, 4.0})
      row.push_back(figure(concat("ns per point, ", zoom, " px/T"),
                           splat_loop(slice, false, zoom, 1, false, report.quick).per_point, 1));
    row.push_back(
        figure("perspective, 2 px/T", splat_loop(slice, true, 2, 1, false, report.quick).per_point, 1));
    rows.push_back(std::move(row));
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  report.table("The same per vector target, step 1", rows);
}

struct FrameCase {
  const char* name;
  RenderMode mode;
  Quality quality;
  bool perspective;
  uint32_t pixels;
};

void frame_table(const Report& report, const Slice& slice, const KeptPoints& kept, uint64_t points,
                 double peak) {
  const FrameCase cases[] = {
      {"semi draft", RenderMode::composite, Quality::draft, false, 256},
      {"semi draft", RenderMode::composite, Quality::draft, false, 512},
      {"semi normal", RenderMode::composite, Quality::normal, false, 512},
      {"semi normal, perspective", RenderMode::composite, Quality::normal, true, 512},
      {"semi draft", RenderMode::composite, Quality::draft, false, 1024},
      {"semi normal", RenderMode::composite, Quality::normal, false, 1024},
      {"isosurface normal", RenderMode::isosurface, Quality::normal, false, 512},
      {"isosurface normal, no skips", RenderMode::isosurface, Quality::normal, false, 512},
  };
  std::vector<Row> rows;
  for (const FrameCase& c : cases) {
    if (report.quick && c.pixels > 512) continue;
    const uint32_t pixels = report.quick ? c.pixels / 4 : c.pixels;
    TestContext context(1);
    Scene scene = make_scene(slice, ramp_function(0.3, 1, 0.3),
                             fit_camera(slice, c.perspective, 20, 30, pixels, pixels));
    scene.points = &kept;
    RenderOptions o;
    o.mode = c.mode, o.quality = c.quality, o.iso_value = 0.5;
    if (std::string(c.name).ends_with("no skips")) o.disable_skips = ~0u;
    ImageStorage out(pixels, pixels);
    RenderStats best;
    double total = 1e30;
    for (int repeat = 0; repeat < (report.quick ? 1 : 7); ++repeat) {
      RenderStats stats;
      const double ms = 1e3 * cpu_seconds([&] { stats = render(scene, o, context.get(), out.image); });
      if (repeat == 0) best = stats;
      // Stages are walls: what other programs took of one repeat is not in the least of all.
      best.drawn.ms_transform = std::min(best.drawn.ms_transform, stats.drawn.ms_transform);
      best.drawn.ms_splat = std::min(best.drawn.ms_splat, stats.drawn.ms_splat);
      best.drawn.ms_shade = std::min(best.drawn.ms_shade, stats.drawn.ms_shade);
      total = std::min(total, ms);
    }
    const double splat = static_cast<double>(best.drawn.contributions) / (1e-3 * best.drawn.ms_splat);
    rows.push_back(
        {word("frame", c.name), figure("pixels", pixels, 0), figure("ms", total, 1),
         figure("transform and bin", best.drawn.ms_transform, 1), figure("splat", best.drawn.ms_splat, 1),
         figure("classify, shade", best.drawn.ms_shade, 1),
         figure("rest", total - best.drawn.ms_transform - best.drawn.ms_splat - best.drawn.ms_shade, 1),
         figure("M visits", static_cast<double>(best.drawn.points_splatted) / 1e6, 2),
         figure("window samples, of peak", splat / peak, 3)});
  }
  report.table(concat("Where a frame's time goes, one thread, ms; ", points, " points with mirror images"),
               rows);
}

// Pictures with the kernel and with its short form against the field's own integral and against the analytic
// field.
void error_table(const Report& report) {
  const uint32_t n = 36, pixels = report.quick ? 48 : 128;
  const Field3 truth = marschner_lobb(n, 5);
  const Slice slice = make_slice({n, n, n}, truth);
  TestContext context(2);
  std::vector<Row> rows;
  for (const bool shading : {false, true}) {
    Scene scene =
        make_scene(slice, ramp_function(0.3, 1, 0.3), fit_camera(slice, false, 20, 30, pixels, pixels));
    RenderOptions o;
    o.shading = shading;
    ImageStorage own(pixels, pixels), exact(pixels, pixels), got(pixels, pixels);
    render_reference(scene, o, slice_field(slice), {}, context.get(), own.image);
    const auto analytic = [&](const Vec3& p, Vec3* gradient) {
      const auto at = [&](double x, double y, double z) { return truth(x, y, z); };
      const double h = 1e-4;
      if (gradient)
        *gradient = {(at(p[0] + h, p[1], p[2]) - at(p[0] - h, p[1], p[2])) / (2 * h),
                     (at(p[0], p[1] + h, p[2]) - at(p[0], p[1] - h, p[2])) / (2 * h),
                     (at(p[0], p[1], p[2] + h) - at(p[0], p[1], p[2] - h)) / (2 * h)};
      return at(p[0], p[1], p[2]);
    };
    render_reference(scene, o, analytic, {}, context.get(), exact.image);
    for (const auto gradient : {GradientMethod::fourth_order, GradientMethod::analytic})
      for (const double step : {1.0, 0.5, 0.25}) {
        if (!shading && gradient == GradientMethod::analytic) continue;
        o.sheet_step = step, o.gradient = gradient;
        Row row{word("shading", !shading                               ? "none"
                                : gradient == GradientMethod::analytic ? "kernel's gradient"
                                                                       : "fourth order"),
                figure("step", step, 2)};
        for (const KernelForm form : {KernelForm::exact, KernelForm::short_form, KernelForm::flat_form}) {
          o.kernel_form = form;
          render(scene, o, context.get(), got.image);
          const char* name = form == KernelForm::exact       ? "full"
                             : form == KernelForm::flat_form ? "flat"
                                                             : "short";
          row.push_back(figure(concat(name, ", to the field's integral, dB"), compare(own, got).db(), 1));
          row.push_back(figure(concat(name, ", to the truth, dB"), compare(exact, got).db(), 1));
        }
        rows.push_back(std::move(row));
      }
  }
  report.table("What the short kernels cost, RMSE over RGBA of covered pixels, peak 1", rows);
}

} // namespace

int run_splat_suite(std::span<const std::string> args, const Report& report) {
  const auto wanted = [&](const char* table) {
    return args.empty() || std::find(args.begin(), args.end(), std::string("--") + table) != args.end();
  };
  for (const std::string& arg : args)
    if (arg != "--floors" && arg != "--loop" && arg != "--targets" && arg != "--errors" && arg != "--frames")
      fail(Code::invalid_argument, "splat: ", arg, " is none of --floors --loop --targets --errors --frames");
  const double peak = fma_peak();
  if (wanted("floors")) floors_table(report, peak);
  const Slice small = make_slice({24, 24, 24}, marschner_lobb(24, 2));
  if (wanted("loop")) loop_table(report, small, peak);
  if (wanted("targets")) target_table(report, small);
  if (wanted("errors")) error_table(report);
  if (wanted("frames")) {
    const uint32_t n = report.quick ? 32 : 128;
    const Slice slice = make_slice({n, n, n}, marschner_lobb(n));
    TestContext context(1);
    const KeptPoints points;
    const uint64_t count = points.of(slice, context.get()).count;
    frame_table(report, slice, points, count, peak);
  }
  return 0;
}

} // namespace bccsplat::bench

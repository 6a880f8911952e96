// SPDX-License-Identifier: Apache-2.0
// Draws moving balls with and without trails in turn, by length and number of stills, and compares trails as
// they are drawn with ones in fine steps at the pixels.
#include "tests/bench/trail/trail.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/error.h"
#include "scene/picture.h"
#include "scene/trail.h"
#include "slice/time_slice.h"
#include "tests/bench/image_error.h"
#include "tests/bench/sheet_residue.h"
#include "tests/support/fields.h"

namespace bccsplat::bench {
namespace {

using test::TestContext;

// Eight soft balls on circles about the centre of a cube of n samples.
double balls(const Vec4& p, double n, double frames) {
  double sum = 0;
  for (int i = 0; i < 8; ++i) {
    const double phase = 6.2831853 * (i / 8.0 + (1 + i % 3) * p[3] / (4 * frames));
    const double r = n * (0.2 + 0.02 * i);
    const double x = p[0] - n / 2 - r * std::cos(phase), y = p[1] - n / 2 - r * std::sin(phase),
                 z = p[2] - n * (0.3 + 0.05 * i);
    sum += std::exp(-(x * x + y * y + z * z) / (2 * 0.0036 * n * n));
  }
  return sum < 1e-3 ? 0 : sum;
}

// Two rings of vortices that run after each other along the axis of a cube of n samples.
double rings(const Vec4& p, double n, double frames) {
  double sum = 0;
  for (int i = 0; i < 2; ++i) {
    const double r = n * (0.22 - 0.05 * i), z = n * (0.25 + 0.2 * i + (0.3 - 0.1 * i) * p[3] / frames);
    const double from_axis = std::hypot(p[0] - n / 2, p[1] - n / 2) - r, along = p[2] - z;
    sum += std::exp(-(from_axis * from_axis + along * along) / (2 * 0.0016 * n * n));
  }
  return sum < 1e-3 ? 0 : sum;
}

struct TrailBench {
  TestContext context{1};
  MemorySamples samples;
  Coefficients coefficients;
  Slice slice;
  KeptPoints points;
  TransferFunction function;
  RenderOptions options;
  int pixels;

  TrailBench(uint32_t n, uint32_t frames, int picture, double (*field)(const Vec4&, double, double) = balls)
      : samples(test::sample_field(Lattice4::fit(LatticeKind::d4star, {n, n, n, frames}),
                                   [&](const Vec4& p) { return field(p, n, frames); })),
        coefficients(samples, 0, make_kernel("default"), 0, uint64_t{4} << 30),
        slice(time_slice(coefficients, frames - 4.0, {0, 0}, {}, context.get())),
        points(make_points(slice, context.get())), pixels(picture) {
    function.colors = {{0.1, {0.2, 0.3, 0.9}}, {0.9, {0.9, 0.4, 0.1}}};
    function.opacities = {{0.1, 0}, {0.9, 0.3}};
  }

  struct Drawn {
    RenderStats stats;
    double step_world = 0;
  };
  Drawn draw(const Trail& trail, Image& image, bool perspective = false) {
    Scene scene;
    scene.slice = &slice, scene.points = &points, scene.function = function;
    scene.camera = fit_camera(slice, perspective, 20, 30, pixels, pixels);
    scene.trail = &trail, scene.trail_functions = {function};
    const RenderStats stats = render(scene, options, context.get(), image);
    return {stats,
            make_view(slice, resolve_camera(scene.camera), pixels, pixels, stats.sheet_step).step_world};
  }
  Trail make(double span, int stills) {
    return make_trail(coefficients, slice, {.interval = {-span, 0}, .samples = stills}, {}, {},
                      context.get());
  }
};

// Trails as they are drawn, and at the pixels, against fine steps at the pixels with the kernel's own
// gradient.
void compare_errors(TrailBench& bench, const Report& report) {
  std::vector<Row> rows;
  ImageStorage now(bench.pixels, bench.pixels), at_pixels(bench.pixels, bench.pixels),
      fine(bench.pixels, bench.pixels);
  for (const bool perspective : {false, true})
    for (const bool shading : {true, false})
      for (const int stills : {5, 21}) { // slices of their own, and out of layers
        const Trail trail = bench.make(6, stills);
        bench.options = {};
        bench.options.shading = shading;
        (void)bench.draw(trail, now.image, perspective);
        bench.options.raise = RaiseFilter{};
        (void)bench.draw(trail, at_pixels.image, perspective);
        bench.options.quality = Quality::best, bench.options.kernel_form = KernelForm::exact;
        bench.options.gradient = GradientMethod::analytic;
        (void)bench.draw(trail, fine.image, perspective);
        const auto error = [](const ImageStorage& a, const ImageStorage& b) {
          return image_error(a.image, b.image);
        };
        rows.push_back({word("view", perspective ? "perspective" : "orthographic"),
                        word("shading", shading ? "on" : "off"), figure("stills", stills, 0),
                        figure("dB", error(now, fine).psnr(), 1), figure("max", error(now, fine).most, 4),
                        figure("dB at the pixels", error(at_pixels, fine).psnr(), 1),
                        figure("max at the pixels", error(at_pixels, fine).most, 4),
                        figure("dB between them", error(now, at_pixels).psnr(), 1)});
      }
  report.table("Error of a trail over 6 frames", rows);
  bench.options = {};
}

struct Shown {
  const char* name;
  TransferFunction function;
};

std::vector<Shown> functions() {
  const std::vector<ColorPoint> colors{{0.1, {0.2, 0.3, 0.9}}, {0.9, {0.9, 0.4, 0.1}}};
  return {{"ramp to 0.3", {colors, {{0.1, 0}, {0.9, 0.3}}}},
          {"0.85 in a tenth", {colors, {{0.35, 0}, {0.45, 0.85}, {1, 0.95}}}},
          {"shell 0.02 wide", {colors, {{0.34, 0}, {0.35, 0.9}, {0.36, 0}}}}};
}

// Trails against ones of four times as many stills and sheets.
void compare_fine(const char* name, TrailBench& bench, const Report& report, std::vector<Row>& rows) {
  const double span = 12;
  for (const Shown& shown : functions()) {
    bench.function = shown.function;
    for (const int stills : {12, 21}) {
      const Trail trail = bench.make(span, stills), more = bench.make(span, 4 * stills);
      ImageStorage fine(bench.pixels, bench.pixels, true), out(bench.pixels, bench.pixels);
      bench.options = {};
      bench.options.sheet_step = 0.125, bench.options.preintegrate = Preintegrate::on;
      bench.options.kernel_form = KernelForm::flat_form;
      const double step = 4 * bench.draw(more, fine.image).step_world;
      Row row{word("scene", name), word("function", shown.name), figure("stills", stills, 0)};
      const auto draw = [&](Preintegrate how) {
        bench.options = {};
        bench.options.preintegrate = how;
        return bench.draw(trail, out.image).stats.drawn.preintegrated;
      };
      const bool chosen = draw(Preintegrate::automatic);
      row.push_back(word("chosen", chosen ? "integrals" : "entries"));
      for (const Preintegrate how : {Preintegrate::off, Preintegrate::on}) {
        const std::string by = how == Preintegrate::off ? "entries: " : "integrals: ";
        (void)draw(how);
        row.push_back(figure(by + "dB", image_error(out.image, fine.image).psnr(), 1));
        row.push_back(figure("/255", sheet_residue(out.image, fine.image, step).sheets, 2));
      }
      const auto [off, on] = paired_cpu_seconds([&] { (void)draw(Preintegrate::off); },
                                                [&] { (void)draw(Preintegrate::on); }, report.quick ? 1 : 3);
      row.push_back(figure("ms by entries", 1000 * off, 0));
      row.push_back(figure("by integrals", 1000 * on, 0));
      rows.push_back(row);
    }
  }
  bench.options = {};
}

// Stills and sheets against each other: which of them a trail's time is best spent on. The truth is what
// compare_fine() compares 21 stills with.
void compare_steps(const char* name, TrailBench& bench, const Report& report, std::vector<Row>& rows) {
  const double span = 12;
  for (const Shown& shown : functions()) {
    bench.function = shown.function;
    ImageStorage fine(bench.pixels, bench.pixels), out(bench.pixels, bench.pixels);
    bench.options = {};
    bench.options.sheet_step = 0.125, bench.options.preintegrate = Preintegrate::on;
    bench.options.kernel_form = KernelForm::flat_form;
    (void)bench.draw(bench.make(span, 84), fine.image);
    for (const int stills : {12, 16, 21}) {
      const Trail trail = bench.make(span, stills);
      Row row{word("scene", name), word("function", shown.name), figure("stills", stills, 0)};
      for (const double step : {0.5, 0.7, 1.0}) {
        bench.options = {};
        bench.options.sheet_step = step, bench.options.quality = step < 1 ? Quality::normal : Quality::draft;
        double least = 1e300;
        for (int r = 0; r < (report.quick ? 1 : 3); ++r)
          least = std::min(least, cpu_seconds([&] { (void)bench.draw(trail, out.image); }));
        row.push_back(figure(concat("step ", step, ": dB"), image_error(out.image, fine.image).psnr(), 1));
        row.push_back(figure(concat("ms at ", step), 1000 * least, 0));
      }
      rows.push_back(row);
    }
  }
  bench.options = {};
}

} // namespace

int run_trail_suite(std::span<const std::string> args, const Report& report) {
  for (const std::string& a : args)
    if (a != "--fine" && a != "--steps") fail(Code::invalid_argument, "trail: unknown option ", a);
  const auto asked = [&](const char* part) {
    return args.empty() || std::find(args.begin(), args.end(), part) != args.end();
  };
  std::vector<Row> against_fine, by_steps;
  for (const bool of_rings : {false, true}) {
    TrailBench moving(report.quick ? 32 : 64, 24, report.quick ? 64 : 256, of_rings ? rings : balls);
    const char* const name = of_rings ? "vortex rings" : "balls";
    if (asked("--fine")) compare_fine(name, moving, report, against_fine);
    if (asked("--steps")) compare_steps(name, moving, report, by_steps);
  }
  report.table("Trails over 12 frames against four times as many stills and sheets", against_fine);
  report.table("Trails over 12 frames: more stills or closer sheets, against 84 stills and sheets of 0.125 T",
               by_steps);
  if (!args.empty()) return 0;
  TrailBench bench(report.quick ? 32 : 96, 24, report.quick ? 64 : 384);
  ImageStorage image(bench.pixels, bench.pixels);
  std::vector<Row> rows;
  for (const bool shading : {true, false})
    for (const double span : {6.0, 12.0})
      for (const int stills : {5, 21, 64}) {
        bench.options.shading = shading;
        Trail trail;
        const double make = cpu_seconds([&] { trail = bench.make(span, stills); });
        RenderStats last;
        const auto [one, all] =
            paired_cpu_seconds([&] { (void)bench.draw({}, image.image); },
                               [&] { last = bench.draw(trail, image.image).stats; }, report.quick ? 1 : 3);
        const auto scale = [&](double ms) { return ms / 1000 / one; };
        rows.push_back({word("shading", shading ? "on" : "off"), figure("frames", span, 0),
                        figure("stills", stills, 0), figure("frame ms", 1000 * one, 1),
                        figure("trail / frame", all / one, 2),
                        figure("transform", scale(last.drawn.ms_transform), 2),
                        figure("splat", scale(last.drawn.ms_splat), 2),
                        figure("shade", scale(last.drawn.ms_shade), 2), figure("slicing", make / one, 2)});
      }
  report.table("A trail's picture, in pictures without", rows);
  compare_errors(bench, report);
  return 0;
}

} // namespace bccsplat::bench

// SPDX-License-Identifier: Apache-2.0
// Two ways of drawing in turn, and the ratio of their times. Isosurfaces are drawn as first pictures of a
// slice and value, and as later ones: a renderer keeps the cells that may hold the value.
#include <algorithm>
#include <chrono>
#include <limits>

#include "field/lattice_sums.h"
#include "rays/surface_cells.h"
#include "tests/bench/render/render.h"

namespace bccsplat::bench {
namespace {

struct Ratios {
  int rounds;
  std::vector<Row> rows;

  // Time of `second` over that of `first`; errors against the truth unless null.
  void add(const std::string& what, const Method& first, const Method& second, int size, const Image* truth,
           int stride) {
    const std::vector<double> ms = least_ms(std::array{first, second}, size, rounds);
    const auto psnr = [&](const Method& m) {
      return truth ? method_error(m, size, *truth, stride).psnr() : std::numeric_limits<double>::quiet_NaN();
    };
    rows.push_back({word("what", what), word("first", describe(first)), word("second", describe(second)),
                    figure("first ms", ms[0], 1), figure("second ms", ms[1], 1),
                    figure("second / first", ms[1] / ms[0], 2), figure("first dB", psnr(first), 1),
                    figure("second dB", psnr(second), 1)});
  }
  static std::string describe(const Method& m) {
    return concat(m.name, ", ", m.lattice, ", ", m.kernel, ", step ", m.step);
  }
};

struct Marched {
  MarchGrid grid;
  std::vector<uint8_t> distance;
  MarchScene scene;
  Marched(const FieldScene& field, const Camera& camera, const MarchOptions& options)
      : grid(make_march_grid({field.samples, field.samples, field.samples},
                             [&](double x, double y, double z) {
                               return field.field({x, y, z}, nullptr);
                             })),
        distance(march_distances(grid, field.function, options)) {
    scene.grid = &grid, scene.distance = &distance, scene.camera = camera, scene.function = field.function;
  }
  Marched(const Marched&) = delete;
  Marched& operator=(const Marched&) = delete;
};

void against_marcher(Ratios& out, const FieldScene& field, RenderMode mode, int size) {
  constexpr int stride = 8;
  BenchContext one(1);
  const Camera camera = scene_camera(field, size, 0);
  const SampledScene sampled = sample_scene(field, LatticeKind::bcc, "default");
  const Scene scene = splat_scene(field, sampled, camera);
  MarchOptions m;
  m.mode = mode, m.iso_value = field.iso_value;
  const Marched marched(field, camera, m);
  RenderOptions o;
  o.mode = mode, o.iso_value = field.iso_value;
  const auto truth = true_image(field, sampled, camera, o, size, stride);
  const bool iso = mode == RenderMode::isosurface;
  Drawers drawers;
  Scene later = scene;
  later.drawers = &drawers;
  for (const Quality q : {Quality::draft, Quality::normal}) {
    o.quality = q;
    const auto add = [&](const char* which, const Scene& drawn) {
      const Method splat = splat_method(concat("quality ", quality_name(q)), drawn, o, one);
      if (drawn.drawers) settle(splat, size);
      m.step = splat.step;
      out.add(
          concat(field.name, iso ? ", isosurface" : ", semi-transparent", which, ": ray-marcher / splatter"),
          splat, march_method(marched.scene, m, one), size, &truth->image, stride);
    };
    add(iso ? ", first picture" : "", scene);
    if (iso) add(", later pictures", later);
  }
  if (iso) return;
  // The coarsest marcher as good as any marcher, and the cheapest splatter that is no worse.
  const auto psnr = [&](const Method& method) {
    return method_error(method, size, truth->image, stride).psnr();
  };
  m.step = 0.125;
  const double best = psnr(march_method(marched.scene, m, one));
  for (m.step = 2; m.step > 0.125 && psnr(march_method(marched.scene, m, one)) < best - 0.3;) m.step /= 2;
  const Method march = march_method(marched.scene, m, one);
  const double goal = psnr(march);
  const SampledScene fast = sample_scene(field, LatticeKind::bcc, "fast");
  const Scene fast_scene = splat_scene(field, fast, camera);
  std::vector<Method> candidates;
  for (const Scene* s : {&fast_scene, &scene})
    for (const GradientMethod g : {GradientMethod::central, GradientMethod::fourth_order})
      for (const double step : {3.0, 2.0, 1.5, 1.0, 0.5}) {
        RenderOptions c;
        c.sheet_step = step, c.gradient = g;
        const Method method = splat_method(concat("splat, ", gradient_name(g)), *s, c, one);
        if (psnr(method) >= goal) candidates.push_back(method);
      }
  if (candidates.empty()) return;
  const std::vector<double> ms = least_ms(candidates, size, 1);
  const size_t cheapest = std::min_element(ms.begin(), ms.end()) - ms.begin();
  out.add(concat(field.name, ": at the marcher's least error"), candidates[cheapest], march, size,
          &truth->image, stride);
}

void lattices(Ratios& out, const FieldScene& field, bool quick) {
  constexpr int stride = 16;
  BenchContext one(1);
  const SampledScene bcc = sample_scene(field, LatticeKind::bcc, "default");
  const SampledScene bcc_paper = sample_scene(field, LatticeKind::bcc, "paper");
  const SampledScene cc_paper = sample_scene(field, LatticeKind::cc, "paper");
  std::vector<SampledScene> cc;
  for (const char* kernel : {"fast", "radial18+b3", "default"})
    cc.push_back(sample_scene(field, LatticeKind::cc, kernel));
  for (const double pixels : {1.0, 2.0, 4.0}) {
    const int size = static_cast<int>(field.samples * 2 * pixels);
    const Camera camera = scene_camera(field, size, pixels);
    RenderOptions o;
    o.sheet_step = 1;
    const Scene s = splat_scene(field, bcc, camera);
    const auto truth = true_image(field, bcc, camera, o, size, stride);
    const Method first = splat_method("splat", s, o, one);
    const double goal = method_error(first, size, truth->image, stride).psnr() - 0.5;
    for (const SampledScene& c : cc) {
      const Scene t = splat_scene(field, c, camera);
      const Method second = splat_method("splat", t, o, one);
      // The first, cheapest kernel that is as good; the last one in any case.
      if (&c != &cc.back() && method_error(second, size, truth->image, stride).psnr() < goal) continue;
      out.add(concat("BCC / CC, ", pixels, " px per T, CC with the cheapest kernel as good"), second, first,
              size, &truth->image, stride);
      break;
    }
    if (pixels > 2 || quick) continue;
    const Scene p = splat_scene(field, bcc_paper, camera), t = splat_scene(field, cc_paper, camera);
    out.add(concat("BCC / CC, ", pixels, " px per T, the paper's kernel"), splat_method("splat", t, o, one),
            splat_method("splat", p, o, one), size, &truth->image, stride);
  }
}

void views(Ratios& out, const FieldScene& field, int size) {
  BenchContext one(1);
  const SampledScene sampled = sample_scene(field, LatticeKind::bcc, "default");
  const Scene flat = splat_scene(field, sampled, scene_camera(field, size, 0)),
              deep = splat_scene(field, sampled, scene_camera(field, size, 0, true));
  RenderOptions o;
  out.add("perspective / orthographic", splat_method("orthographic", flat, o, one),
          splat_method("perspective", deep, o, one), size, nullptr, 1);
  o.mode = RenderMode::isosurface, o.iso_value = field.iso_value;
  Drawers drawers;
  Scene later = flat;
  later.drawers = &drawers;
  const Method all = splat_method("all skips", later, o, one);
  settle(all, size);
  o.disable_skips = 15;
  out.add("isosurface, later pictures, without skips / with", all, splat_method("no skips", later, o, one),
          size, nullptr, 1);
}

// Wall and CPU time of one thread and of two, in turn.
void threads(const Report& report, const FieldScene& field, int size, int rounds) {
  BenchContext one(1), two(2);
  const SampledScene sampled = sample_scene(field, LatticeKind::bcc, "default");
  const Scene scene = splat_scene(field, sampled, scene_camera(field, size, 0));
  ImageStorage out(size, size);
  std::array<double, 2> wall{1e300, 1e300}, cpu{1e300, 1e300};
  for (int r = 0; r < rounds; ++r)
    for (size_t i = 0; i < 2; ++i) {
      const auto begin = std::chrono::steady_clock::now();
      cpu[i] = std::min(
          cpu[i], 1e3 * cpu_seconds([&] { (void)render(scene, {}, (i ? two : one).get(), out.image); }));
      const std::chrono::duration<double, std::milli> passed = std::chrono::steady_clock::now() - begin;
      wall[i] = std::min(wall[i], passed.count());
    }
  report.table(concat(field.name, ", normal, ", size, "^2: two threads against one, least of ", rounds),
               {{figure("wall ms, 1", wall[0], 1), figure("wall ms, 2", wall[1], 1),
                 figure("speed-up", wall[0] / wall[1], 2), figure("CPU ms, 1", cpu[0], 1),
                 figure("CPU ms, 2", cpu[1], 1), figure("CPU 2 / 1", cpu[1] / cpu[0], 3)}});
}

// Where the time of a frame goes.
void stages(const Report& report, const FieldScene& field, int samples_per_side) {
  BenchContext one(1);
  const SampledScene sampled = sample_scene(field, LatticeKind::bcc, "default");
  std::vector<Row> rows;
  for (const bool iso : {false, true})
    for (const Quality q : {Quality::draft, Quality::normal})
      for (const double pixels : {1.0, 2.0, 4.0}) {
        const int size = static_cast<int>(2 * samples_per_side * pixels);
        const Scene scene = splat_scene(field, sampled, scene_camera(field, size, pixels));
        RenderOptions o;
        o.quality = q, o.rays = false; // rays have no such stages
        if (iso) o.mode = RenderMode::isosurface, o.iso_value = field.iso_value;
        ImageStorage out(size, size);
        RenderStats best;
        best.drawn.ms_transform = best.drawn.ms_splat = best.drawn.ms_shade = 1e300;
        for (int r = 0; r < (report.quick ? 2 : 8); ++r) {
          const RenderStats s = render(scene, o, one.get(), out.image);
          // Stages are timed by the wall clock: the least of each is the least disturbed.
          best.drawn.ms_transform = std::min(best.drawn.ms_transform, s.drawn.ms_transform);
          best.drawn.ms_splat = std::min(best.drawn.ms_splat, s.drawn.ms_splat),
          best.drawn.ms_shade = std::min(best.drawn.ms_shade, s.drawn.ms_shade);
          best.drawn.points_splatted = s.drawn.points_splatted,
          best.drawn.points_total = s.drawn.points_total;
          best.drawn.contributions = s.drawn.contributions;
        }
        rows.push_back(
            {word("mode", iso ? "isosurface by sheets" : "semi-transparent"),
             word("quality", quality_name(q)), figure("px per T", pixels, 0),
             figure("transform ms", best.drawn.ms_transform, 1), figure("splat ms", best.drawn.ms_splat, 1),
             figure("shade ms", best.drawn.ms_shade, 1),
             figure("visits / point",
                    static_cast<double>(best.drawn.points_splatted) /
                        static_cast<double>(best.drawn.points_total),
                    2),
             figure("Gsamples/s splatted",
                    static_cast<double>(best.drawn.contributions) / best.drawn.ms_splat * 1e-6, 1)});
      }
  report.table(concat(field.name, ' ', field.samples, "^3, shaded: stages of a frame, one thread"), rows);
}

} // namespace

void render_ratios(const Report& report) {
  const int n = report.quick ? 40 : 128, size = report.quick ? 160 : 512;
  Ratios out{report.quick ? 1 : 5, {}};
  const FieldScene field = marschner_lobb_scene(n);
  against_marcher(out, field, RenderMode::composite, size);
  against_marcher(out, field, RenderMode::isosurface, size);
  against_marcher(out, bessel_scene(n), RenderMode::isosurface, size);
  const FieldScene smoke = smoke_scene(2 * n);
  against_marcher(out, smoke, RenderMode::composite, size);
  against_marcher(out, smoke, RenderMode::isosurface, size);
  lattices(out, field, report.quick);
  views(out, field, size);
  report.table(concat("CPU time of two methods in turn, one thread, ", size,
                      "^2 unless said; PSNR against the analytic field"),
               out.rows);
  threads(report, field, size, report.quick ? 3 : 15);
  stages(report, field, report.quick ? 40 : 128);
}

} // namespace bccsplat::bench

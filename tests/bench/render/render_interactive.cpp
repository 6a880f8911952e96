// SPDX-License-Identifier: Apache-2.0
// What a viewer waits for: another view, the next moment, any moment.
#include <algorithm>
#include <chrono>

#include "field/coefficients/coefficients.h"
#include "slice/time_slice.h"
#include "tests/bench/render/render.h"
#include "tests/support/fields.h"

namespace bccsplat::bench {
namespace {

struct Timing {
  double wall = 1e300, cpu = 1e300; // ms
  double shade = 1e300;             // of them what sheets take that are finished, where that is told
  template<class Body> void run(const Body& body) {
    const auto begin = std::chrono::steady_clock::now();
    cpu = std::min(cpu, 1e3 * cpu_seconds(body));
    const std::chrono::duration<double, std::milli> passed = std::chrono::steady_clock::now() - begin;
    wall = std::min(wall, passed.count());
  }
};

// The same view again and again: drawn, drawn and kept, and what is kept only classified.
void kept_sheets(const Report& report) {
  const int n = report.quick ? 32 : 128, size = report.quick ? 128 : 512, rounds = report.quick ? 1 : 3;
  BenchContext one(1);
  ImageStorage picture(size, size);
  std::vector<Row> rows;
  for (const FieldScene& field : {marschner_lobb_scene(n), bessel_scene(n), smoke_scene(2 * n)}) {
    const SampledScene sampled = sample_scene(field, LatticeKind::bcc, "default");
    Scene scene = splat_scene(field, sampled, scene_camera(field, size, 0));
    for (const RenderMode mode : {RenderMode::composite, RenderMode::isosurface})
      for (const Quality quality : {Quality::draft, Quality::normal, Quality::fine}) {
        RenderOptions options;
        options.mode = mode, options.quality = quality, options.iso_value = field.iso_value;
        const auto draw = [&](Timing& timing) {
          RenderStats stats;
          timing.run([&] { stats = render(scene, options, one.get(), picture.image); });
          timing.shade = std::min(timing.shade, stats.drawn.ms_shade);
        };
        Timing drawn, keeping, taking;
        uint64_t bytes = 0;
        for (int r = 0; r < rounds; ++r) {
          Drawers kept;
          scene.drawers = &kept;
          const uint64_t before = one.memory.used();
          draw(drawn), draw(keeping), draw(taking);
          bytes = one.memory.used() - before;
        }
        rows.push_back(
            {word("scene", concat(field.name, mode == RenderMode::isosurface ? ", isosurface" : "")),
             word("quality", quality_name(quality)), figure("drawn ms", drawn.cpu, 1),
             figure("and kept ms", keeping.cpu, 1), figure("kept before ms", taking.cpu, 1),
             figure("ratio", taking.cpu / drawn.cpu, 2),
             figure("MiB", static_cast<double>(bytes) / (1 << 20), 0),
             figure("raise, classify, shade: drawn ms", drawn.shade, 1), figure("kept ms", taking.shade, 1),
             figure("of finished sheets, drawn / kept", drawn.shade / taking.shade, 2)});
      }
  }
  report.table(concat("The same view again, shaded, ", size, "^2; CPU ms of one thread, least of ", rounds),
               rows);
}

} // namespace

void render_interactive(const Report& report) {
  const int n = report.quick ? 32 : 128, frames = 12, size = report.quick ? 128 : 512,
            rounds = report.quick ? 1 : 5;
  constexpr int threads = 2;
  BenchContext context(threads);
  FieldScene scene = bessel_scene(n);
  const uint32_t count = n;
  const Lattice4 lattice =
      Lattice4::fit(LatticeKind::d4star, {count, count, count, static_cast<uint32_t>(frames)});
  // The rings drift along x by 0.7 T a frame.
  const MemorySamples samples = test::sample_field(lattice, [&](const Vec4& p) {
    return scene.field({p[0] - 0.7 * p[3], p[1], p[2]}, nullptr);
  });
  const auto coefficients = [&] {
    return std::make_unique<Coefficients>(samples, 0, make_kernel("default"), 0.0f, uint64_t{1} << 32);
  };
  const auto slice_at = [&](const Coefficients& c, double frame) {
    SampledScene out;
    out.slice = time_slice(c, frame, {0, 0}, {}, context.get());
    out.points = std::make_shared<const KeptPoints>(make_points(out.slice, context.get()));
    return out;
  };
  const Camera camera = scene_camera(scene, size, 0);
  ImageStorage picture(size, size);
  std::vector<Row> rows;
  for (const Quality quality : {Quality::draft, Quality::normal}) {
    RenderOptions options;
    options.quality = quality;
    const auto draw = [&](const SampledScene& s, Drawers* kept = nullptr) {
      Scene shown = splat_scene(scene, s, camera);
      shown.drawers = kept;
      (void)render(shown, options, context.get(), picture.image);
    };
    Timing rotate, keep, classify, slicing, points, next, cold;
    auto warm = coefficients();
    SampledScene now = slice_at(*warm, 3);
    const int64_t stored = now.slice.points();
    for (int r = 0; r < rounds; ++r) rotate.run([&] { draw(now); });
    uint64_t kept_bytes = 0;
    for (int r = 0; r < rounds; ++r) {
      Drawers kept;
      draw(now, &kept);
      keep.run([&] { draw(now, &kept); });
      classify.run([&] { draw(now, &kept); });
      kept_bytes = context.memory.used();
      kept.forget();
      kept_bytes -= context.memory.used();
    }
    for (int r = 0; r < rounds; ++r) {
      // A frame on: some of its layers are in memory already.
      const double frame = 3.5 + r;
      slicing.run([&] { now.slice = time_slice(*warm, frame, {0, 0}, {}, context.get()); });
      points.run(
          [&] { now.points = std::make_shared<const KeptPoints>(make_points(now.slice, context.get())); });
      next.run([&] { // the same again from the frame before, as a player sees it
        now = slice_at(*warm, frame + 0.5);
        draw(now);
      });
    }
    for (int r = 0; r < rounds; ++r)
      cold.run([&] {
        const auto fresh = coefficients();
        now = slice_at(*fresh, 2.3 + r);
        draw(now);
      });
    const auto row = [&](const std::string& what, const Timing& t) {
      rows.push_back({word("what", what), word("quality", quality_name(quality)),
                      figure("stored points", static_cast<double>(stored), 0), figure("wall ms", t.wall, 1),
                      figure("CPU ms", t.cpu, 1)});
    };
    row("turn the camera", rotate);
    row("another transfer function, once", keep);
    row(concat("another transfer function again (", kept_bytes >> 20, " MiB of sheets kept)"), classify);
    row("slice of the next moment", slicing);
    row("its points for the splatter", points),
        row("next moment, half a frame on: slice, points, picture", next);
    row("any moment, nothing cached: prefilter, slice, points, picture", cold);
  }
  report.table(concat("Rings on D4*, ", n, "^3, semi-transparent, shaded, ", size, "^2, ", threads,
                      " threads; least of ", rounds),
               rows);
  kept_sheets(report);
}

} // namespace bccsplat::bench

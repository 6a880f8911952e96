// SPDX-License-Identifier: Apache-2.0
// Cuts moments as a host does that plays a series, and counts what is sent for each.
#include "tests/bench/gpu/gpu_moments.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "draw/stage_clock.h"
#include "slice/time_slice.h"
#include "tests/bench/image_error.h"
#include "tests/bench/scene.h"
#include "tests/support/fields.h"

namespace bccsplat::bench {
namespace {

constexpr uint32_t frames = 12;
constexpr double begin_frame = 4, frames_played = 3;

// A series in memory, whose moments are merged by who draws them.
struct DriftingSmoke {
  BenchContext context{0};
  Lattice4 lattice;
  MemorySamples samples;
  Coefficients coefficients;

  explicit DriftingSmoke(int n)
      : lattice(Lattice4::fit(LatticeKind::d4star, {static_cast<uint32_t>(n), static_cast<uint32_t>(n),
                                                    static_cast<uint32_t>(n), frames})),
        samples(test::sample_field(lattice,
                                   [&](const Vec4& p) {
                                     return puffs(n, p[3])({p[0], p[1], p[2]}, nullptr);
                                   })),
        coefficients(samples, 0, make_kernel("default"), 0, uint64_t{1} << 34) {}
  [[nodiscard]] Slice cut(double frame, bool later) {
    return thick_time_slice(coefficients, frame, {0, 0}, ThicknessKind::mean, {}, context.get(), later);
  }
};

struct Player {
  DriftingSmoke& series;
  Scene scene;
  RenderOptions options;
  Drawers drawers;
  ImageStorage image;
  uint64_t bytes = 0, layers = 0, pictures = 0;

  Player(DriftingSmoke& of, const FieldScene& look, int size, const std::shared_ptr<GpuDevice>& gpu)
      : series(of), image(size, size) {
    scene.camera = scene_camera(look, size, 0), scene.function = look.function, scene.drawers = &drawers;
    options.backend = Backend::gpu, options.gpu = gpu;
  }
  // Returns the time of cutting and drawing a moment.
  double show(double frame, bool later) {
    const auto start = std::chrono::steady_clock::now();
    const Slice slice = series.cut(frame, later);
    scene.slice = &slice;
    const RenderStats stats = render(scene, options, series.context.get(), image.image);
    bytes += stats.drawn.bytes_sent, layers += stats.drawn.layers_sent, ++pictures;
    return ms_since(start);
  }
};

Row row_of(const char* what, const Player& p, const std::vector<double>& ms) {
  std::vector<double> sorted = ms;
  std::sort(sorted.begin(), sorted.end());
  double sum = 0;
  for (const double t : ms) sum += t;
  const auto count = static_cast<double>(ms.size());
  return {word("what", what),
          figure("pictures", count, 0),
          figure("median ms", sorted[sorted.size() / 2], 2),
          figure("longest ms", sorted.back(), 2),
          figure("pictures a second", 1000 * count / sum, 1),
          figure("layers sent", static_cast<double>(p.layers), 0),
          figure("MB sent", static_cast<double>(p.bytes) / 1e6, 1)};
}

} // namespace

std::vector<Row> measure_moments(int samples, int size, const std::shared_ptr<GpuDevice>& gpu, int rounds) {
  DriftingSmoke series(samples);
  const FieldScene look = smoke_scene(samples);
  std::vector<Row> rows;
  for (const bool later : {true, false}) {
    Player player(series, look, size, gpu);
    (void)player.show(begin_frame, later); // sends what is there, compiles
    player.bytes = player.layers = 0;
    std::vector<double> there, played;
    const double between = 0.02 * series.lattice.time_step; // layers stay the same
    for (int n = 1; n <= rounds; ++n) there.push_back(player.show(begin_frame + between * n / rounds, later));
    rows.push_back(
        row_of(later ? "a new moment, layers there" : "the same, merged by the CPU", player, there));
    player.bytes = player.layers = 0;
    const int steps = 8 * rounds;
    for (int n = 1; n <= steps; ++n)
      played.push_back(player.show(begin_frame + frames_played * n / steps, later));
    rows.push_back(row_of(later ? "three frames played" : "the same, merged by the CPU", player, played));
  }
  return rows;
}

namespace {

struct Beside {
  double cycles;
  int size;
  Quality quality;
  const char* name;
};

Row compare(const Beside& b, const std::shared_ptr<GpuDevice>& gpu) {
  constexpr int n = 41;
  FieldScene field = marschner_lobb_scene(n);
  field.field = marschner_lobb(n, b.cycles);
  BenchContext context(0);
  const SampledScene sampled = sample_scene(field, LatticeKind::bcc, "default");
  const Camera camera = scene_camera(field, b.size, 0);
  const Scene scene = splat_scene(field, sampled, camera);
  RenderOptions options;
  options.quality = b.quality, options.gpu = gpu;
  ImageStorage by_gpu(b.size, b.size), by_cpu(b.size, b.size);
  options.backend = Backend::gpu;
  (void)render(scene, options, context.get(), by_gpu.image);
  options.backend = Backend::cpu;
  (void)render(scene, options, context.get(), by_cpu.image);
  const auto truth = true_image(field, sampled, camera, options, b.size, 1, true);
  return {figure("cycles", b.cycles, 0),
          figure("pixels a side", b.size, 0),
          word("quality", b.name),
          figure("GPU, dB to the truth", image_error(by_gpu.image, truth->image).psnr(), 1),
          figure("CPU", image_error(by_cpu.image, truth->image).psnr(), 1),
          figure("each other", image_error(by_gpu.image, by_cpu.image).psnr(), 1)};
}

} // namespace

std::vector<Row> compare_with_cpu(const std::shared_ptr<GpuDevice>& gpu, bool quick) {
  constexpr int small = 96, large = 192;
  constexpr double original = 6, smoother = 4;
  std::vector<Row> rows;
  for (const double cycles : {original, smoother})
    for (const int size : {small, large})
      for (const auto& [quality, name] :
           {std::pair{Quality::draft, "draft"}, std::pair{Quality::normal, "normal"},
            std::pair{Quality::fine, "fine"}}) {
        if ((cycles == smoother || quick) && quality != Quality::normal) continue;
        if (quick && (size == large || cycles == smoother)) continue;
        rows.push_back(compare({cycles, size, quality, name}, gpu));
      }
  return rows;
}

} // namespace bccsplat::bench

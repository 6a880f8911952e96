// SPDX-License-Identifier: Apache-2.0
// What a frame costs on more threads than the machine has. Its parts run one by one, divided as for so many
// threads, and each is timed: the sum tells what the division adds, and giving every part to the thread that
// is free first how long the frame would take. Real threads that share cores, and with them caches, are
// measured beside it.
#include <algorithm>
#include <ctime>

#include "tests/bench/render/render.h"

namespace bccsplat::bench {
namespace {

// CPU time of this thread: other programs on the machine do not count.
double seconds() {
  timespec t{};
  (void)clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

// A runner of one thread that plays `threads`.
struct Played {
  explicit Played(int n)
      : free(static_cast<size_t>(n)),
        tasks([this](uint64_t count, const std::function<void(uint64_t)>& body) { run(count, body); }, n) {}

  void run(uint64_t count, const std::function<void(uint64_t)>& body) {
    std::fill(free.begin(), free.end(), 0.0);
    for (uint64_t n = 0; n < count; ++n) {
      const double begin = seconds();
      body(n);
      const double took = seconds() - begin;
      *std::min_element(free.begin(), free.end()) += took;
      saved += took;
    }
    saved -= *std::max_element(free.begin(), free.end());
  }

  std::vector<double> free; // when each of them is
  double saved = 0;         // what the threads take off the sum
  Tasks tasks;
  MemoryBudget memory;
  Progress progress;
};

struct Times {
  double sum = 1e300, frame = 1e300; // least of the rounds, seconds
  uint64_t tiles = 0;
};

Times play(const Scene& scene, const RenderOptions& options, int threads, int size) {
  Played played(threads);
  ImageStorage out(size, size);
  const double begin = seconds();
  const RenderStats stats = render(scene, options, {played.tasks, played.memory, played.progress}, out.image);
  const double sum = seconds() - begin;
  return {sum, sum - played.saved, stats.drawn.tiles};
}

void measure(const Report& report, const FieldScene& scene, RenderMode mode, int size,
             std::vector<Row>& rows) {
  const SampledScene sampled = sample_scene(scene, LatticeKind::bcc, "default");
  const Scene s = splat_scene(scene, sampled, scene_camera(scene, size, 0));
  for (const Quality q : {Quality::draft, Quality::normal}) {
    RenderOptions o;
    o.quality = q, o.mode = mode, o.iso_value = scene.iso_value;
    constexpr std::array counts{1, 2, 4, 8, 16};
    std::array<Times, counts.size()> least;
    for (int round = 0; round < (report.quick ? 1 : 9); ++round)
      for (size_t n = 0; n < counts.size(); ++n) {
        const Times t = play(s, o, counts[n], size);
        least[n] = {std::min(least[n].sum, t.sum), std::min(least[n].frame, t.frame), t.tiles};
      }
    BenchContext one(1), eight(8);
    const std::vector<Method> methods{splat_method("splat", s, o, one), splat_method("splat", s, o, eight)};
    const std::vector<double> ms = least_ms(methods, size, report.quick ? 1 : 5);
    Row row{word("scene", scene.name),
            word("mode", mode == RenderMode::composite ? "composite" : "isosurface"),
            word("quality", quality_name(q)), figure("pixels", size, 0), figure("ms", 1e3 * least[0].sum, 1)};
    for (size_t n = 1; n < counts.size(); ++n) {
      const std::string of = concat(counts[n], " threads: ");
      row.push_back(figure(of + "tiles", static_cast<double>(least[n].tiles), 0));
      row.push_back(figure("sum", least[n].sum / least[0].sum, 3));
      row.push_back(figure("speed", least[0].sum / least[n].frame, 2));
    }
    row.push_back(figure("CPU of 8 on this machine", ms[1] / ms[0], 3));
    rows.push_back(row);
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
  report.table("Frames divided for several threads: CPU time and speed relative to one", rows);
}

} // namespace bccsplat::bench

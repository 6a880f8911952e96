// SPDX-License-Identifier: Apache-2.0
// Finds the edge pixels of an isosurface by the depths of their neighbours, sends rays through each, and
// lights what they meet as pixel centres are lit. Rows are smoothed by themselves: nothing that is drawn is
// read.
#include "splat/smooth_edges.h"

#include <algorithm>
#include <cmath>
#include <mutex>

#include "splat/shade/edge_rays.h"
#include "splat/tile/sheet_source.h"

namespace bccsplat {
namespace {

// Rows of a picture that one task smooths: their rays go together.
constexpr int rows_at_once = 8;
// Two pixels are of one surface where their depths differ by no more than `steep` times what they differ by
// from the pixels beyond them, and `level` pixels.
constexpr double steep = 2, level = 2;
// A rotated grid: no two samples of a pixel share a column or a row.
constexpr size_t samples = 4;
constexpr std::array<std::array<double, 2>, samples> sample_at{
    {{-0.375, -0.125}, {0.125, -0.375}, {0.375, 0.125}, {-0.125, 0.375}}};
// Depths that are further apart than that are of different runs.
constexpr double run_gap = 4; // T

class EdgeFinder {
 public:
  EdgeFinder(const SurfaceDepths& depths, const SheetView& view)
      : depths_(depths), view_(view), pixel_(std::max(length(view.ex), length(view.ey)) / view.step) {}

  [[nodiscard]] bool is_edge(int i, int j) const {
    constexpr std::array<std::array<int, 2>, 4> beside{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
    const double here = at(i, j), least = std::isfinite(here) ? level * pixel_ * view_.scale(here) : 0;
    for (const auto& [x, y] : beside) {
      if (!within(i + x, j + y)) continue;
      const double there = at(i + x, j + y), apart = std::fabs(here - there);
      if (!(apart > least)) continue; // as NaN is not, where nothing is in either
      const double slope = std::max(change(i - x, j - y, here), change(i + 2 * x, j + 2 * y, there));
      if (apart > steep * slope + least) return true;
    }
    return false;
  }

  // Appends what the pixel and the eight around it met, in order.
  void nearby(int i, int j, std::vector<DepthRun>& runs) const {
    std::vector<double> k;
    for (int y = std::max(j - 1, 0); y <= std::min(j + 1, depths_.height - 1); ++y)
      for (int x = std::max(i - 1, 0); x <= std::min(i + 1, depths_.width - 1); ++x)
        if (std::isfinite(at(x, y))) k.push_back(at(x, y));
    std::sort(k.begin(), k.end());
    const double apart = run_gap / view_.step;
    for (size_t n = 0; n < k.size(); ++n)
      if (n > 0 && k[n] - k[n - 1] <= apart)
        runs.back().last = k[n];
      else
        runs.push_back({k[n], k[n]});
  }

 private:
  [[nodiscard]] bool within(int i, int j) const {
    return i >= 0 && j >= 0 && i < depths_.width && j < depths_.height;
  }
  [[nodiscard]] double at(int i, int j) const { return static_cast<double>(depths_.at(i, j)); }
  // How much a pixel's depth differs from `from`; 0 where it has none.
  [[nodiscard]] double change(int i, int j, double from) const {
    if (!within(i, j) || !std::isfinite(at(i, j))) return 0;
    return std::fabs(at(i, j) - from);
  }

  const SurfaceDepths& depths_;
  const SheetView& view_;
  double pixel_; // sheets, at scale 1
};

// The edge pixels of some rows, and their rays.
struct EdgeRows {
  struct Pixel {
    int i, j;
    size_t first_run;
  };
  std::vector<Pixel> pixels;
  std::vector<DepthRun> runs;

  [[nodiscard]] std::vector<EdgeRay> rays(const Slice& slice, const SheetView& view) const {
    std::vector<EdgeRay> out;
    const auto front = static_cast<double>(view.first_sheet());
    for (size_t n = 0; n < pixels.size(); ++n) {
      const Pixel& p = pixels[n];
      const size_t end = n + 1 < pixels.size() ? pixels[n + 1].first_run : runs.size();
      for (const auto& [x, y] : sample_at) {
        const double i = p.i + x, j = p.j + y;
        const auto [enter, leave] = ray_interval(slice, view, i, j);
        out.push_back(
            {i, j, std::max(enter, front), leave, std::span(runs).subspan(p.first_run, end - p.first_run)});
      }
    }
    return out;
  }
};

} // namespace

EdgeStats smooth_edges(const SplatScene& scene, const SplatOptions& options, const SurfaceDepths& depths,
                       const Context& context,
                       const std::function<void(int i, int j, const std::array<float, 4>& rgba)>& emit) {
  const SheetView& view = *scene.view;
  const EdgeFinder edges(depths, view);
  const SurfaceField field(*scene.slice);
  const double target = options.iso_value - static_cast<double>(scene.slice->base);
  const auto& color =
      scene.table->entry[static_cast<size_t>(scene.table->index(static_cast<float>(options.iso_value)))];
  std::mutex mutex;
  EdgeStats stats;
  const int parts = (depths.height + rows_at_once - 1) / rows_at_once;
  context.tasks.parallel_for(static_cast<uint64_t>(parts), [&](uint64_t part) {
    context.progress.check();
    auto clock = StageClock::now();
    const int top = static_cast<int>(part) * rows_at_once;
    EdgeRows rows;
    for (int j = top; j < std::min(top + rows_at_once, depths.height); ++j)
      for (int i = 0; i < depths.width; ++i)
        if (edges.is_edge(i, j)) {
          rows.pixels.push_back({i, j, rows.runs.size()});
          edges.nearby(i, j, rows.runs);
        }
    const std::vector<EdgeRay> rays = rows.rays(*scene.slice, view);
    const auto hits = trace_edge_rays(field, view, target, root_tolerance, rays);
    for (size_t n = 0; n < rows.pixels.size(); ++n) {
      std::array<float, 4> rgba{};
      for (size_t m = samples * n; m < samples * (n + 1); ++m) {
        if (!std::isfinite(hits[m].k)) continue;
        Shading lit{{1, 1, 1}, {}};
        if (options.shading)
          lit = shade(*scene.lights, hits[m].gradient, to_viewer(view, rays[m].i, rays[m].j), target);
        const std::array<float, 3> seen = lit_color(color, lit);
        for (size_t c = 0; c < 3; ++c) rgba[c] += seen[c] / static_cast<float>(samples);
        rgba[3] += 1.0f / static_cast<float>(samples);
      }
      emit(rows.pixels[n].i, rows.pixels[n].j, rgba);
    }
    double ms = 0;
    add_lap(clock, ms);
    const std::scoped_lock lock(mutex);
    stats.pixels += rows.pixels.size(), stats.ms += ms;
  });
  return stats;
}

} // namespace bccsplat

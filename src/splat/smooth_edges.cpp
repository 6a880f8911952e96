// SPDX-License-Identifier: Apache-2.0
// Finds the edge pixels of an isosurface by the depths of their neighbours, sends rays through each, and
// lights what they meet as pixel centres are lit.
#include "splat/smooth_edges.h"

#include <algorithm>
#include <array>
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
  EdgeFinder(const SurfacePicture& picture, const SheetView& view)
      : picture_(picture), view_(view), pixel_(std::max(length(view.ex), length(view.ey)) / view.step) {}

  [[nodiscard]] bool is_edge(int i, int j) const {
    constexpr std::array<std::array<int, 2>, 4> beside{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
    const double here = at(i, j), least = std::isfinite(here) ? level * pixel_ * view_.scale(here) : 0;
    for (const auto& [x, y] : beside) {
      if (!within(i + x, j + y)) continue;
      const double there = at(i + x, j + y), apart = std::fabs(here - there);
      if (!(apart > least)) continue; // as NaN is not, where nothing is in either
      if (std::isinf(apart)) return true;
      const double slope = std::max(change(i - x, j - y, here), change(i + 2 * x, j + 2 * y, there));
      if (apart > steep * slope + least) return true;
    }
    return false;
  }

  // Appends what the pixel and the eight around it met, in order.
  void nearby(int i, int j, std::vector<DepthRun>& runs) const {
    std::vector<double> k;
    for (int y = std::max(j - 1, 0); y <= std::min(j + 1, picture_.height - 1); ++y)
      for (int x = std::max(i - 1, 0); x <= std::min(i + 1, picture_.width - 1); ++x)
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
    return i >= 0 && j >= 0 && i < picture_.width && j < picture_.height;
  }
  [[nodiscard]] double at(int i, int j) const { return static_cast<double>(picture_.depth(i, j)); }
  // How much a pixel's depth differs from `from`; 0 where it has none.
  [[nodiscard]] double change(int i, int j, double from) const {
    if (!within(i, j) || !std::isfinite(at(i, j))) return 0;
    return std::fabs(at(i, j) - from);
  }

  const SurfacePicture& picture_;
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

  EdgeRows(const EdgeFinder& edges, int width, int top, int bottom) {
    for (int j = top; j < bottom; ++j)
      for (int i = 0; i < width; ++i)
        if (edges.is_edge(i, j)) {
          pixels.push_back({i, j, runs.size()});
          edges.nearby(i, j, runs);
        }
  }

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

class Smoother {
 public:
  Smoother(const SplatScene& scene, const SplatOptions& options, SurfacePicture& picture)
      : scene_(scene), options_(options), picture_(picture),
        field_(*scene.slice, options.without_ripple ? lattice_sums(*scene.slice) : nullptr),
        target_(options.iso_value - static_cast<double>(scene.slice->base)),
        color_(scene.table
                   ->entry[static_cast<size_t>(scene.table->index(static_cast<float>(options.iso_value)))]) {}

  void draw(const EdgeRows& rows) const {
    const std::vector<EdgeRay> rays = rows.rays(*scene_.slice, *scene_.view);
    const auto hits = trace_edge_rays(field_, *scene_.view, target_, root_tolerance, rays);
    for (size_t n = 0; n < rows.pixels.size(); ++n) {
      std::array<float, 4> sum{};
      for (size_t m = samples * n; m < samples * (n + 1); ++m)
        if (std::isfinite(hits[m].k)) add(hits[m], rays[m], sum);
      float* const out = picture_.color(rows.pixels[n].i, rows.pixels[n].j);
      for (size_t c = 0; c < 4; ++c) out[c] = sum[c] / static_cast<float>(samples);
    }
  }

 private:
  void add(const SurfacePoint& hit, const EdgeRay& ray, std::array<float, 4>& sum) const {
    Shading lit{{1, 1, 1}, {}};
    if (options_.shading)
      lit = shade(*scene_.lights, hit.gradient, to_viewer(*scene_.view, ray.i, ray.j), target_);
    const std::array<float, 3> seen = lit_color(color_, lit);
    for (size_t c = 0; c < 3; ++c) sum[c] += seen[c];
    sum[3] += 1;
  }

  const SplatScene& scene_;
  const SplatOptions& options_;
  SurfacePicture& picture_;
  SurfaceField field_;
  double target_;
  const std::array<float, 4>& color_;
};

} // namespace

EdgeStats smooth_edges(const SplatScene& scene, const SplatOptions& options, SurfacePicture& picture,
                       const Context& context) {
  const EdgeFinder edges(picture, *scene.view);
  const Smoother smoother(scene, options, picture);
  const auto parts = static_cast<size_t>((picture.height + rows_at_once - 1) / rows_at_once);
  std::mutex mutex;
  EdgeStats stats;
  context.tasks.parallel_for(parts, [&](uint64_t part) {
    context.progress.check();
    auto clock = StageClock::now();
    const int top = static_cast<int>(part) * rows_at_once;
    const EdgeRows rows(edges, picture.width, top, std::min(top + rows_at_once, picture.height));
    smoother.draw(rows);
    double ms = 0;
    add_lap(clock, ms);
    const std::scoped_lock lock(mutex);
    stats.pixels += rows.pixels.size(), stats.ms += ms;
  });
  return stats;
}

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Finds the edge pixels of an isosurface by the depths of their neighbours, sends rays through each, and
// lights what they meet as pixel centres are lit.
#include "draw/smooth_edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <mutex>

#include "draw/stage_clock.h"
#include "shade/edge_rays.h"

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
    if (!picture_.layered()) return is_edge(i, j, 0);
    const auto here = picture_.layers(i, j);
    for (const auto& [x, y] : beside) {
      if (!within(i + x, j + y)) continue;
      const auto there = picture_.layers(i + x, j + y);
      const auto same = [](const SurfaceHit& a, const SurfaceHit& b) { return a.surface == b.surface; };
      if (!std::equal(here.begin(), here.end(), there.begin(), there.end(), same)) return true;
    }
    for (size_t layer = 0; layer < here.size(); ++layer)
      if (is_edge(i, j, layer)) return true;
    return false;
  }

  // Appends where the pixel and the eight around it met a surface, in order.
  void nearby(int i, int j, uint32_t surface, std::vector<DepthRun>& runs) const {
    std::vector<double> k;
    for (int y = std::max(j - 1, 0); y <= std::min(j + 1, picture_.height - 1); ++y)
      for (int x = std::max(i - 1, 0); x <= std::min(i + 1, picture_.width - 1); ++x) {
        if (picture_.layered()) {
          for (const SurfaceHit& hit : picture_.layers(x, y))
            if (hit.surface == surface) k.push_back(hit.k);
        } else if (std::isfinite(at(x, y, 0))) {
          k.push_back(at(x, y, 0));
        }
      }
    std::sort(k.begin(), k.end());
    const double apart = run_gap / view_.step;
    for (size_t n = 0; n < k.size(); ++n)
      if (n > 0 && k[n] - k[n - 1] <= apart)
        runs.back().last = k[n];
      else
        runs.push_back({k[n], k[n]});
  }

 private:
  static constexpr std::array<std::array<int, 2>, 4> beside{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};

  [[nodiscard]] bool is_edge(int i, int j, size_t layer) const {
    const double here = at(i, j, layer), least = std::isfinite(here) ? level * pixel_ * view_.scale(here) : 0;
    for (const auto& [x, y] : beside) {
      if (!within(i + x, j + y)) continue;
      const double there = at(i + x, j + y, layer), apart = std::fabs(here - there);
      if (!(apart > least)) continue; // as NaN is not, where nothing is in either
      if (std::isinf(apart)) return true;
      const double slope =
          std::max(change(i - x, j - y, layer, here), change(i + 2 * x, j + 2 * y, layer, there));
      if (apart > steep * slope + least) return true;
    }
    return false;
  }
  [[nodiscard]] bool within(int i, int j) const {
    return i >= 0 && j >= 0 && i < picture_.width && j < picture_.height;
  }
  // Returns where a pixel's ray met its surface number `layer`; infinite where it met fewer.
  [[nodiscard]] double at(int i, int j, size_t layer) const {
    if (!picture_.layered()) return picture_.depth(i, j);
    const auto layers = picture_.layers(i, j);
    return layer < layers.size() ? static_cast<double>(layers[layer].k)
                                 : std::numeric_limits<double>::infinity();
  }
  // Returns how much a pixel's depth differs from `from`; 0 where it has none.
  [[nodiscard]] double change(int i, int j, size_t layer, double from) const {
    if (!within(i, j) || !std::isfinite(at(i, j, layer))) return 0;
    return std::fabs(at(i, j, layer) - from);
  }

  const SurfacePicture& picture_;
  const SheetView& view_;
  double pixel_; // sheets, at scale 1
};

// The edge pixels of some rows.
struct EdgeRows {
  struct Pixel {
    int i, j;
  };
  std::vector<Pixel> pixels;

  EdgeRows(const EdgeFinder& edges, int width, int top, int bottom) {
    for (int j = top; j < bottom; ++j)
      for (int i = 0; i < width; ++i)
        if (edges.is_edge(i, j)) pixels.push_back({i, j});
  }
};

// The rays of edge pixels that look for one surface, number `samples` n + m for sample m of pixel n.
struct SurfaceRays {
  std::vector<DepthRun> runs;
  std::vector<EdgeRay> rays;

  SurfaceRays(const EdgeFinder& edges, const EdgeRows& rows, uint32_t surface, const Slice& slice,
              const SheetView& view) {
    std::vector<size_t> first;
    for (const auto& [i, j] : rows.pixels) {
      first.push_back(runs.size());
      edges.nearby(i, j, surface, runs);
    }
    first.push_back(runs.size());
    const auto front = static_cast<double>(view.first_sheet());
    for (size_t n = 0; n < rows.pixels.size(); ++n)
      for (const auto& [x, y] : sample_at) {
        const double i = rows.pixels[n].i + x, j = rows.pixels[n].j + y;
        const auto [enter, leave] = ray_interval(slice, view, i, j);
        rays.push_back({i, j, std::max(enter, front), leave,
                        std::span(runs).subspan(first[n], first[n + 1] - first[n])});
      }
  }
};

class Smoother {
 public:
  Smoother(const Shot& shot, SurfacePicture& picture, const EdgeFinder& edges)
      : shot_(shot), lights_(lights_of(shot)), picture_(picture), edges_(edges),
        field_(*shot.slice, shot.options.without_ripple ? lattice_sums(*shot.slice, shot.sums) : nullptr) {
    for (const IsoSurface& s : shot.options.surfaces)
      surfaces_.push_back(
          {s.value - shot.slice->base, static_cast<float>(s.opacity), surface_color(s, *shot.table)});
  }

  void draw(const EdgeRows& rows) const {
    std::vector<Seen> seen;
    for (uint32_t s = 0; s < surfaces_.size(); ++s) look_for(s, rows, seen);
    std::stable_sort(seen.begin(), seen.end(), [](const Seen& a, const Seen& b) {
      return a.sample != b.sample ? a.sample < b.sample : a.k < b.k;
    });
    auto next = seen.begin();
    for (size_t n = 0; n < rows.pixels.size(); ++n) {
      std::array<float, 4> sum{};
      for (size_t m = samples * n; m < samples * (n + 1); ++m) {
        float passes = 1;
        for (; next != seen.end() && next->sample == m; ++next) {
          if (1 - passes >= static_cast<float>(shot_.options.opacity_stop)) continue;
          const float part = passes * next->color[3];
          for (size_t c = 0; c < 3; ++c) sum[c] += part * next->color[c];
          sum[3] += part;
          passes -= part;
        }
      }
      float* const out = picture_.color(rows.pixels[n].i, rows.pixels[n].j);
      for (size_t c = 0; c < 4; ++c) out[c] = sum[c] / static_cast<float>(samples);
    }
  }

 private:
  struct Surface {
    double target; // relative to the base
    float opacity;
    std::array<float, 4> color;
  };
  // What a sample's ray met: lit colour and opacity.
  struct Seen {
    uint32_t sample;
    double k;
    std::array<float, 4> color;
  };

  void look_for(uint32_t number, const EdgeRows& rows, std::vector<Seen>& seen) const {
    const Surface& s = surfaces_[number];
    const SurfaceRays of(edges_, rows, number, *shot_.slice, *shot_.view);
    const auto hits = trace_edge_rays(field_, *shot_.view, s.target, root_tolerance, of.rays, s.opacity < 1);
    for (const EdgeHit& hit : hits) {
      Shading lit{{1, 1, 1}, {}};
      if (shot_.options.shading)
        lit = shade(lights_, hit.point.gradient,
                    to_viewer(*shot_.view, of.rays[hit.ray].i, of.rays[hit.ray].j), s.target);
      const std::array<float, 3> color = lit_color(s.color, lit);
      seen.push_back({hit.ray, hit.point.k, {color[0], color[1], color[2], s.opacity}});
    }
  }

  const Shot& shot_;
  const Lights lights_;
  SurfacePicture& picture_;
  const EdgeFinder& edges_;
  SurfaceField field_;
  std::vector<Surface> surfaces_;
};

} // namespace

EdgeStats smooth_edges(const Shot& shot, SurfacePicture& picture, const Context& context,
                       const PixelsDrawn& drawn) {
  const EdgeFinder edges(picture, *shot.view);
  const Smoother smoother(shot, picture, edges);
  const size_t parts = (picture.height + rows_at_once - 1) / rows_at_once;
  std::mutex mutex;
  EdgeStats stats;
  context.tasks.parallel_for(parts, [&](uint64_t part) {
    context.progress.check();
    auto clock = StageClock::now();
    const int top = static_cast<int>(part) * rows_at_once;
    const int bottom = std::min(top + rows_at_once, picture.height);
    const EdgeRows rows(edges, picture.width, top, bottom);
    smoother.draw(rows);
    double ms = 0;
    add_lap(clock, ms);
    if (drawn) drawn({0, top, picture.width, bottom});
    const std::scoped_lock lock(mutex);
    stats.pixels += rows.pixels.size(), stats.ms += ms;
  });
  return stats;
}

} // namespace bccsplat

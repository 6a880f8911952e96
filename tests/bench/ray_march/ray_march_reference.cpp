// SPDX-License-Identifier: Apache-2.0
// The marcher in double precision, by the formulae: sample by sample, ray by ray.
#include <algorithm>
#include <cmath>

#include "shade/surface.h"
#include "tests/bench/ray_march/ray_march.h"

namespace bccsplat::bench {
namespace {

// Taps around a coordinate: the first sample, and what each of four counts in the value and in its
// derivative.
struct Taps {
  int first = 0;
  std::array<double, 4> weight{}, slope{};
};

Taps taps(double x, Interpolation interpolation) {
  const double whole = std::floor(x), t = x - whole, s = 1 - t;
  if (interpolation == Interpolation::trilinear) return {static_cast<int>(whole), {s, t, 0, 0}, {}};
  return {static_cast<int>(whole) - 1,
          {s * s * s / 6, (4 - 6 * t * t + 3 * t * t * t) / 6, (4 - 6 * s * s + 3 * s * s * s) / 6,
           t * t * t / 6},
          {-s * s / 2, (3 * t * t - 4 * t) / 2, (4 * s - 3 * s * s) / 2, t * t / 2}};
}

} // namespace

double march_value(const MarchGrid& grid, const Vec3& p, Vec3* gradient) {
  std::array<Taps, 3> t;
  for (size_t a = 0; a < 3; ++a) t[a] = taps(p[a], grid.interpolation);
  const size_t count = grid.interpolation == Interpolation::trilinear ? 2 : 4;
  double value = 0;
  Vec3 g{};
  for (size_t k = 0; k < count; ++k)
    for (size_t j = 0; j < count; ++j)
      for (size_t i = 0; i < count; ++i) {
        const double v =
            grid.value[grid.at(t[0].first + static_cast<int>(i), t[1].first + static_cast<int>(j),
                               t[2].first + static_cast<int>(k))];
        value += t[0].weight[i] * t[1].weight[j] * t[2].weight[k] * v;
        g[0] += t[0].slope[i] * t[1].weight[j] * t[2].weight[k] * v;
        g[1] += t[0].weight[i] * t[1].slope[j] * t[2].weight[k] * v;
        g[2] += t[0].weight[i] * t[1].weight[j] * t[2].slope[k] * v;
      }
  if (!gradient) return value;
  if (grid.interpolation == Interpolation::trilinear)
    for (size_t a = 0; a < 3; ++a) { // interpolated central differences are differences of the interpolation
      Vec3 low = p, high = p;
      low[a] -= 1, high[a] += 1;
      g[a] = 0.5 * (march_value(grid, high) - march_value(grid, low));
    }
  *gradient = g;
  return value;
}

void ray_march_reference(const MarchScene& scene, const MarchOptions& options, Image& image) {
  const Slice domain = grid_domain(*scene.grid);
  const SheetView view =
      make_view(domain, resolve_camera(scene.camera), image.width, image.height, options.step);
  const double unit = scene.function.unit_distance > 0 ? scene.function.unit_distance : 1;
  const auto value_at = [&](const Vec3& p) { return march_value(*scene.grid, p); };
  const bool iso = options.mode == RenderMode::isosurface;
  for (int j = 0; j < image.height; ++j)
    for (int i = 0; i < image.width; ++i) {
      float* out = image.rgba.at(i, j);
      std::fill_n(out, 4, 0.0f);
      const auto [k0, k1] = ray_interval(domain, view, i, j);
      if (!(k0 < k1)) continue;
      const double path = length(view.ray(i, j));
      const auto at = [&](double k) {
        Vec3 p = view.sample(i, j, std::clamp(k, k0, k1));
        for (size_t a = 0; a < 3; ++a) p[a] = std::clamp(p[a], 0.0, domain.domain_end[a]);
        return p;
      };
      const auto lit = [&](const Vec3& p) {
        if (!options.shading) return Shading{{1, 1, 1}, {}};
        Vec3 gradient;
        (void)march_value(*scene.grid, p, &gradient);
        return shade(scene.lights, gradient, to_viewer(view, i, j), 0); // no gradient is noise
      };
      Vec3 color{};
      double alpha = 0;
      const auto first = std::max(view.first_sheet(), static_cast<int64_t>(std::ceil(k0 - 0.5)));
      double before = iso ? value_at(at(static_cast<double>(first) - 1)) : 0;
      for (int64_t n = first; static_cast<double>(n) - (iso ? 1 : 0.5) < k1; ++n) {
        const auto k = static_cast<double>(n);
        const double value = value_at(at(k));
        if (iso) {
          const bool below = before < options.iso_value;
          if (below == (value < options.iso_value)) {
            before = value;
            continue;
          }
          double a = std::clamp(k - 1, k0, k1), b = std::clamp(k, k0, k1);
          for (int bisection = 0; bisection < 50; ++bisection) {
            const double middle = 0.5 * (a + b);
            (value_at(at(middle)) < options.iso_value) == below ? a = middle : b = middle;
          }
          const Shading s = lit(at(a));
          const Vec3 c = scene.function.color(options.iso_value);
          for (size_t ch = 0; ch < 3; ++ch) color[ch] = c[ch] * s.scale[ch] + s.highlight[ch];
          alpha = 1;
          break;
        }
        const double weight = std::min(k + 0.5, k1) - std::max(k - 0.5, k0);
        const double opacity = scene.function.opacity(value);
        if (!(opacity > 0)) continue;
        const double f = (1 - alpha) * -std::expm1(-extinction(opacity, unit) * path * weight);
        const Vec3 c = scene.function.color(value);
        const Shading s = lit(at(k));
        for (size_t ch = 0; ch < 3; ++ch) color[ch] += f * (c[ch] * s.scale[ch] + s.highlight[ch]);
        alpha += f;
        if (alpha >= options.opacity_stop) break;
      }
      for (size_t ch = 0; ch < 3; ++ch) out[ch] = static_cast<float>(color[ch]);
      out[3] = static_cast<float>(alpha);
    }
}

} // namespace bccsplat::bench

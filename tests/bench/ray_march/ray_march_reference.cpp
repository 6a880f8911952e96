// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "splat/shade/surface.h"
#include "tests/bench/ray_march/ray_march.h"

namespace bccsplat::bench {
namespace {

struct Sampler {
  const MarchGrid& grid;

  [[nodiscard]] double value(const Vec3& p) const {
    std::array<int, 3> i;
    Vec3 f;
    for (size_t a = 0; a < 3; ++a) {
      i[a] = static_cast<int>(std::floor(p[a]));
      f[a] = p[a] - i[a];
    }
    double sum = 0;
    for (int n = 0; n < 8; ++n) {
      const int x = n & 1, y = n >> 1 & 1, z = n >> 2;
      sum += (x ? f[0] : 1 - f[0]) * (y ? f[1] : 1 - f[1]) * (z ? f[2] : 1 - f[2]) *
             static_cast<double>(grid.value[grid.at(i[0] + x, i[1] + y, i[2] + z)]);
    }
    return sum;
  }
  // Interpolated central differences are differences of the interpolation.
  [[nodiscard]] Vec3 gradient(const Vec3& p) const {
    Vec3 g;
    for (size_t a = 0; a < 3; ++a) {
      Vec3 low = p, high = p;
      low[a] -= 1, high[a] += 1;
      g[a] = 0.5 * (value(high) - value(low));
    }
    return g;
  }
};

} // namespace

void ray_march_reference(const MarchScene& scene, const MarchOptions& options, Image& image) {
  const Slice domain = grid_domain(*scene.grid);
  const SheetView view =
      make_view(domain, resolve_camera(scene.camera), image.width, image.height, options.step);
  const double unit = scene.function.unit_distance > 0 ? scene.function.unit_distance : 1;
  const Sampler field{*scene.grid};
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
        return shade(scene.lights, field.gradient(p), to_viewer(view, i, j), 0); // no gradient is noise
      };
      Vec3 color{};
      double alpha = 0;
      const auto first = std::max(view.first_sheet(), static_cast<int64_t>(std::ceil(k0 - 0.5)));
      double before = iso ? field.value(at(static_cast<double>(first) - 1)) : 0;
      for (int64_t n = first; static_cast<double>(n) - (iso ? 1 : 0.5) < k1; ++n) {
        const auto k = static_cast<double>(n);
        const double value = field.value(at(k));
        if (iso) {
          const bool below = before < options.iso_value;
          if (below == (value < options.iso_value)) {
            before = value;
            continue;
          }
          double a = std::clamp(k - 1, k0, k1), b = std::clamp(k, k0, k1);
          for (int bisection = 0; bisection < 50; ++bisection) {
            const double middle = 0.5 * (a + b);
            (field.value(at(middle)) < options.iso_value) == below ? a = middle : b = middle;
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

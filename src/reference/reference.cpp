// SPDX-License-Identifier: Apache-2.0
// Integrates every ray in double precision: composites, X-rays and maxima by the midpoint rule, surfaces by
// bisection between samples. Pictures of the splatter are compared with it.
#include "reference/reference.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "shade/surface.h"

namespace bccsplat {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();

struct Pixel {
  Vec3 color{};
  double alpha = 0, depth = infinite, value = nan_value, time = nan_value; // depth as a sheet number
};

struct Ray {
  const Shot& shot;
  const FieldAt& field;
  const SheetView& view;
  const Lights& lights;
  const TimeField& time;
  double unit;
  int i, j;

  [[nodiscard]] Vec3 at(double k) const { return view.sample(i, j, k); }
  [[nodiscard]] bool hole(const Vec3& p) const { return shot.slice->has_holes && shot.slice->is_hole(p); }
  [[nodiscard]] double path() const { return length(view.lattice_to_world.vector(view.ray(i, j))); }
  [[nodiscard]] Shading lit(const Vec3& p) const {
    if (!shot.options.shading) return {{1, 1, 1}, {}};
    Vec3 gradient;
    const double above_base = field(p, &gradient) - shot.slice->base;
    return shade(lights, view.lattice_to_world.inverse().transposed(gradient), to_viewer(view, i, j),
                 above_base);
  }
};

Pixel composite(const Ray& ray, double k0, double k1, int64_t steps) {
  Pixel out;
  const double h = (k1 - k0) / static_cast<double>(steps), path = ray.path() * h;
  double value_sum = 0, time_sum = 0;
  const double depth_at = ray.shot.options.depth_opacity;
  for (int64_t n = 0; n < steps && out.alpha < 1; ++n) {
    const double k = k0 + (static_cast<double>(n) + 0.5) * h;
    const Vec3 p = ray.at(k);
    const double value = ray.field(p, nullptr);
    const double opacity = ray.shot.function->opacity(value);
    if (!(opacity > 0) || ray.hole(p)) continue;
    const double a = -std::expm1(-extinction(opacity, ray.unit) * path);
    const double f = (1 - out.alpha) * a;
    const Vec3 color = ray.shot.function->color(value);
    const Shading lit = ray.lit(p);
    for (size_t c = 0; c < 3; ++c) out.color[c] += f * (color[c] * lit.scale[c] + lit.highlight[c]);
    const double before = out.alpha;
    out.alpha += f;
    value_sum += f * value, time_sum += f * ray.time.at(p);
    if (before < depth_at && out.alpha >= depth_at) {
      const double part =
          out.alpha < 1 ? std::log((1 - depth_at) / (1 - before)) / std::log((1 - out.alpha) / (1 - before))
                        : 0;
      out.depth = k - h / 2 + part * h;
    }
  }
  if (out.alpha > 0) out.value = value_sum / out.alpha, out.time = time_sum / out.alpha;
  return out;
}

struct Crossed {
  double k;
  const IsoSurface* surface;
};

// Returns where the field passes one of the values between two sheets, in order.
std::vector<Crossed> crossed(const Ray& ray, std::span<const IsoSurface> surfaces, double from, double to,
                             double value_from, double value_to) {
  std::vector<Crossed> out;
  for (const IsoSurface& s : surfaces) {
    const bool below = value_from < s.value;
    if (below == (value_to < s.value)) continue;
    double a = from, b = to;
    constexpr int bisections = 60; // more halve nothing that a double holds
    for (int bisection = 0; bisection < bisections; ++bisection) {
      const double middle = 0.5 * (a + b);
      (ray.field(ray.at(middle), nullptr) < s.value) == below ? a = middle : b = middle;
    }
    out.push_back({0.5 * (a + b), &s});
  }
  std::stable_sort(out.begin(), out.end(), [](const Crossed& x, const Crossed& y) { return x.k < y.k; });
  return out;
}

Pixel isosurface(const Ray& ray, double k0, double k1, int64_t steps) {
  Pixel out;
  const std::vector<IsoSurface>& surfaces = ray.shot.options.surfaces;
  const double h = (k1 - k0) / static_cast<double>(steps);
  double low = k0, value_low = ray.field(ray.at(low), nullptr), value_sum = 0, time_sum = 0;
  for (int64_t n = 1; n <= steps && out.alpha < 1; ++n) {
    const double high = k0 + static_cast<double>(n) * h, value_high = ray.field(ray.at(high), nullptr);
    for (const Crossed& c : crossed(ray, surfaces, low, high, value_low, value_high)) {
      const Vec3 p = ray.at(c.k);
      if (ray.hole(p)) continue;
      const double f = (1 - out.alpha) * c.surface->opacity;
      const Vec3 color = c.surface->color.value_or(ray.shot.function->color(c.surface->value));
      const Shading lit = ray.lit(p);
      for (size_t i = 0; i < 3; ++i) out.color[i] += f * (color[i] * lit.scale[i] + lit.highlight[i]);
      if (!(out.alpha > 0)) out.depth = c.k;
      out.alpha += f;
      value_sum += f * c.surface->value, time_sum += f * ray.time.at(p);
    }
    low = high, value_low = value_high;
  }
  if (out.alpha > 0) out.value = value_sum / out.alpha, out.time = time_sum / out.alpha;
  return out;
}

Pixel xray(const Ray& ray, double k0, double k1, int64_t steps) {
  Pixel out;
  const double h = (k1 - k0) / static_cast<double>(steps), path = ray.path() * h;
  double sum = 0, weight = 0, time_sum = 0;
  for (int64_t n = 0; n < steps; ++n) {
    const Vec3 p = ray.at(k0 + (static_cast<double>(n) + 0.5) * h);
    if (ray.hole(p)) continue;
    const double part = (ray.field(p, nullptr) - ray.shot.slice->air) * path;
    sum += part, weight += std::fabs(part), time_sum += std::fabs(part) * ray.time.at(p);
  }
  out.color = {sum, sum, sum};
  out.alpha = 1, out.value = sum;
  if (weight > 0) out.time = time_sum / weight;
  return out;
}

Pixel maximum(const Ray& ray, double k0, double k1, int64_t steps) {
  Pixel out;
  const double h = (k1 - k0) / static_cast<double>(steps);
  double highest = -infinite, highest_k = 0;
  for (int64_t n = 0; n < steps; ++n) {
    const double k = k0 + (static_cast<double>(n) + 0.5) * h;
    const Vec3 p = ray.at(k);
    if (ray.hole(p)) continue;
    const double value = ray.field(p, nullptr);
    if (value > highest) highest = value, highest_k = k;
  }
  if (highest == -infinite) return out;
  const Vec3 color = ray.shot.function->color(highest);
  const Shading lit = ray.lit(ray.at(highest_k));
  out.alpha = ray.shot.function->opacity(highest);
  for (size_t c = 0; c < 3; ++c) out.color[c] = out.alpha * (color[c] * lit.scale[c] + lit.highlight[c]);
  out.value = highest, out.time = ray.time.at(ray.at(highest_k));
  if (out.alpha >= static_cast<double>(ray.shot.options.depth_opacity)) out.depth = highest_k;
  return out;
}

} // namespace

FieldAt slice_field(const Slice& slice, std::shared_ptr<const LatticeSums> sums) {
  return [&slice, sums = std::move(sums)](const Vec3& p, Vec3* gradient) {
    const double value = evaluate_reference(slice, p, gradient);
    if (sums && gradient) *gradient = sums->without_ripple(p, value - slice.base, *gradient);
    return value;
  };
}

double reference_step(const TransferFunction& function, const std::array<double, 2>& bounds) {
  double largest = 0, steepest = 0; // opacity, and its rise over the whole range
  for (const OpacityPoint& p : function.opacities) largest = std::max(largest, p.opacity);
  for (size_t n = 1; n < function.opacities.size(); ++n) {
    const OpacityPoint &a = function.opacities[n - 1], &b = function.opacities[n];
    if (a.opacity == b.opacity) continue;
    const double width = (b.value - a.value) / (bounds[1] - bounds[0]);
    steepest = std::max(steepest, width > 0 ? std::fabs(b.opacity - a.opacity) / width : infinite);
  }
  return steepest > 0 ? std::clamp(largest / steepest, finest_reference_step, default_reference_step)
                      : default_reference_step;
}

void draw_reference(const Shot& shot, const FieldAt& field, const ReferenceOptions& reference,
                    const Context& context, Image& image) {
  const SheetView& view = *shot.view;
  const Lights lights = lights_of(shot, KernelForm::flat_form);
  const TimeField time(*shot.slice);
  const double unit =
      shot.function->unit_distance > 0 ? shot.function->unit_distance : mean_voxel(*shot.slice);
  std::atomic<uint64_t> rows{0};
  context.tasks.parallel_for(image.height, [&](uint64_t row) {
    const int j = static_cast<int>(row);
    for (int i = 0; i < image.width; ++i) {
      context.progress.check();
      const auto [k0, k1] = ray_interval(*shot.slice, view, i, j);
      Pixel out;
      if (k0 < k1) {
        const Ray ray{shot, field, view, lights, time, unit, i, j};
        const auto steps = static_cast<int64_t>(std::ceil((k1 - k0) / reference.step));
        switch (shot.options.mode) {
        case RenderMode::composite:
          out = composite(ray, k0, k1, steps);
          break;
        case RenderMode::isosurface:
          out = isosurface(ray, k0, k1, steps);
          break;
        case RenderMode::xray:
          out = xray(ray, k0, k1, steps);
          break;
        case RenderMode::maximum:
          out = maximum(ray, k0, k1, steps);
          break;
        }
      }
      float* rgba = image.rgba.at(i, j);
      for (size_t c = 0; c < 3; ++c) rgba[c] = static_cast<float>(out.color[c]);
      rgba[3] = static_cast<float>(out.alpha);
      if (image.depth.pixels)
        *image.depth.at(i, j) = static_cast<float>((out.depth + view.depth) * view.step_world);
      if (image.value.pixels) *image.value.at(i, j) = static_cast<float>(out.value);
      if (image.time.pixels) *image.time.at(i, j) = static_cast<float>(out.time);
    }
    context.progress.report(static_cast<double>(++rows) / image.height);
  });
}

} // namespace bccsplat

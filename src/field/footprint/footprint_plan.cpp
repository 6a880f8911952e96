// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <numbers>

#include "field/footprint/footprint.h"
#include "kernel/cc_kernel.h"
#include "kernel/kernel_time.h"

namespace bccsplat {

void divide_by_lattice_sum(const FootprintPlan& plan, const Vec4& p, float& value,
                           std::array<float, 4>* gradient) {
  const auto sum_at = [&](const Vec4& q) { return lattice_sum(*plan.kernel, plan.bcc, q[0], q[1], q[2]); };
  const double total = sum_at(p);
  value = static_cast<float>(value / total);
  if (!gradient) return;
  for (size_t i = 0; i < 4; ++i) {
    float& g = (*gradient)[i];
    double slope = 0;
    if (i < 3) { // smooth and known in closed form: central differences are enough
      constexpr double h = 1e-4;
      Vec4 low = p, high = p;
      low[i] -= h, high[i] += h;
      slope = (sum_at(high) - sum_at(low)) / (2 * h);
    }
    g = static_cast<float>((g - value * slope) / total);
  }
}

void weigh_by_kernel(const FootprintPlan& plan, float from, std::array<float, max_stack>& w,
                     std::array<float, max_stack>& dw) {
  constexpr double pitch = std::numbers::sqrt2; // of kernel time
  double sum = 0, slope_sum = 0;
  std::array<double, max_stack> value, slope;
  const size_t depth = plan.depth;
  for (size_t k = 0; k < depth; ++k) {
    const double dt = pitch * (from - static_cast<double>(k));
    value[k] = plan.kernel->time.value(dt), slope[k] = pitch * plan.kernel->time.slope(dt);
    sum += value[k], slope_sum += slope[k];
  }
  const bool divide = plan.kernel->normalised && sum > 0;
  for (size_t k = 0; k < depth; ++k) {
    if (divide) value[k] /= sum, slope[k] = slope[k] / sum - value[k] * slope_sum / sum;
    w[k] = static_cast<float>(value[k]), dw[k] = static_cast<float>(slope[k]);
  }
}

FootprintPlan::FootprintPlan(const FieldLayers& field) : kernel(field.kernel), timeless(field.timeless) {
  constexpr double time_pitch = std::numbers::sqrt2; // of kernel time
  const Lattice3& lattice = field.layers[0].layer->lattice();
  bcc = lattice.bcc;
  cosets = lattice.cosets();
  const double pitch = coset_pitch(lattice);
  for (size_t i = 0; i < 3; ++i) per_pitch[i] = 1 / pitch, radius[i] = kernel->space.radius / pitch;
  per_pitch[3] = timeless ? 0 : 1 / time_pitch;
  radius[3] = timeless ? 0 : time_reach(*kernel) / time_pitch;
  edge = 2 * radius[0] <= 3 ? 3 : 4;
  if (!timeless) depth = static_cast<int>(std::ceil(2 * radius[3]));
  for (size_t i = 0; i < bend.size(); ++i) bend[i] = static_cast<float>(kernel->time.bend[i]);
  inverse_radius2 = static_cast<float>(1 / (radius[0] * radius[0]));
  terms = kernel->space.terms;
  for (size_t j = 0; j < a.size(); ++j) a[j] = static_cast<float>(kernel->space.a[j]);
  contact = terms == 8 && a[0] == 0 && a[1] == 0;
  for (const FieldLayer& l : field.layers) {
    const size_t c = l.layer->coset();
    Coset& to = coset[c];
    if (to.layer.empty()) {
      to.dims = l.layer->dims(), to.brick_dims = l.layer->brick_dims();
      for (size_t i = 0; i < 3; ++i) to.origin[i] = -0.5 * static_cast<double>(c);
      to.origin[3] = timeless ? 0 : -l.time / time_pitch;
    }
    to.layer.push_back(l.layer);
    to.bricks.push_back(&l.layer->share(0));
  }
}

} // namespace bccsplat

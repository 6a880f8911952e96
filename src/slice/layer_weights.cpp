// SPDX-License-Identifier: Apache-2.0
#include "slice/layer_weights.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "kernel/kernel_time.h"

namespace bccsplat {
namespace {

// Returns weight(kernel time of the layer) for all layers in [begin, end] +- half_width, kernel time, where
// it is not 0.
template<class Weight>
std::vector<LayerWeight> layer_weights(const Lattice4& lattice, const Kernel& kernel, double begin,
                                       double end, const Weight& weight) {
  const double distance = kernel_time_per_layer(lattice), reach = time_reach(kernel);
  const int32_t first = static_cast<int32_t>(std::ceil((begin - reach) / distance)) + lattice.lead;
  const int32_t last = static_cast<int32_t>(std::floor((end + reach) / distance)) + lattice.lead;
  std::vector<LayerWeight> result;
  std::array<double, 2> sum{};
  for (int32_t m = first; m <= last; ++m) {
    const double w = weight(kernel_time_of_layer(lattice, m));
    if (w == 0) continue;
    sum[lattice.coset(m)] += w;
    result.push_back({m, static_cast<float>(w)});
  }
  if (kernel.normalised)
    for (LayerWeight& l : result) l.weight = static_cast<float>(l.weight / sum[lattice.coset(l.layer)]);
  return result;
}

std::vector<LayerWeight> static_weights(const Lattice4& lattice) {
  std::vector<LayerWeight> result;
  for (int c = 0; c < lattice.space.cosets(); ++c) result.push_back({c, 1.0f});
  return result;
}

} // namespace

std::vector<LayerWeight> instant_weights(const Lattice4& lattice, const Kernel& kernel, double frame) {
  if (lattice.is_static()) return static_weights(lattice);
  const double t = frame * kernel_time_per_frame(lattice);
  return layer_weights(lattice, kernel, t, t, [&](double at) { return kernel.time.value(at - t); });
}

std::vector<LayerWeight> mean_weights(const Lattice4& lattice, const Kernel& kernel, double begin,
                                      double end) {
  if (lattice.is_static()) return static_weights(lattice);
  const double unit = kernel_time_per_frame(lattice);
  const double t0 = begin * unit, t1 = end * unit;
  return layer_weights(lattice, kernel, t0, t1,
                       [&](double at) { return kernel.time.integral(t0 - at, t1 - at) / (t1 - t0); });
}

std::optional<int32_t> layer_at(const Lattice4& lattice, double frame) {
  constexpr double tolerance = 1e-9; // layers
  const double layer = frame / lattice.time_step + lattice.lead, nearest = std::round(layer);
  if (std::fabs(layer - nearest) > tolerance) return std::nullopt;
  return static_cast<int32_t>(nearest);
}

std::vector<int32_t> layers_of(const std::vector<LayerWeight>& weights) {
  std::vector<int32_t> layers;
  for (const LayerWeight& l : weights) layers.push_back(l.layer);
  return layers;
}

std::vector<int32_t> all_layers(const Lattice4& lattice) {
  std::vector<int32_t> all(static_cast<size_t>(lattice.layers()));
  std::iota(all.begin(), all.end(), 0);
  return all;
}

std::array<double, 2> time_span(const Lattice4& lattice, double begin, double end) {
  const double last = lattice.last_frame(), beyond = lattice.periodic ? last : 0;
  return {std::clamp(begin, -beyond, last + beyond), std::clamp(end, -beyond, last + beyond)};
}

} // namespace bccsplat

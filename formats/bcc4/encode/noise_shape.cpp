// SPDX-License-Identifier: Apache-2.0
#include "formats/bcc4/encode/noise_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numbers>
#include <vector>

#include "formats/bcc4/encode/normal_equations.h"
#include "kernel/autocorrelation.h"

namespace bccsplat {
namespace {

// The way from a site to a neighbour, in planes and layers.
struct Step {
  Int3 planes;
  int layers;
};
[[nodiscard]] Step operator-(const Step& a, const Step& b) {
  return {{a.planes[0] - b.planes[0], a.planes[1] - b.planes[1], a.planes[2] - b.planes[2]},
          a.layers - b.layers};
}

// Returns the steps in the order of gather_taps.
[[nodiscard]] std::vector<Step> steps_to_taps(int c) {
  std::vector<Step> steps;
  const auto add_own = [&](int offset, int layers) {
    const Int3 s = sites_of_offset(offset);
    steps.push_back({{2 * s[0], 2 * s[1], 2 * s[2]}, layers});
  };
  for (const int o : own_offset) add_own(o, 0);
  if (c & 1)
    for (int i = 0; i < cross_taps; ++i)
      steps.push_back({{2 * (i & 1) - 1, 2 * (i >> 1 & 1) - 1, 2 * (i >> 2) - 1}, -1});
  if (c & 2)
    for (const int o : previous_offset) add_own(o, -2);
  return steps;
}

// The overlap of the kernels at two sites, that at the same site being 2^20.
class Overlap {
 public:
  Overlap(const Kernel& kernel, bool still)
      : kernel_(kernel), still_(still), scale_(0x1p20 / raw({{0, 0, 0}, 0})) {}
  [[nodiscard]] double operator()(const Step& s) const { return scale_ * raw(s); }

 private:
  [[nodiscard]] double raw(const Step& s) const {
    constexpr double plane = std::numbers::sqrt2 / 2; // the distance of planes and of layers
    const auto& [x, y, z] = s.planes;
    const int squares = x * x + y * y + z * z, layers = still_ ? 0 : std::abs(s.layers);
    const auto [at, fresh] = known_.try_emplace({squares, layers}, 0.0);
    if (fresh) {
      at->second = autocorrelation(kernel_.space, plane * std::sqrt(static_cast<double>(squares)));
      if (!still_) at->second *= autocorrelation(kernel_.time, plane * layers);
    }
    return at->second;
  }

  const Kernel& kernel_;
  bool still_;
  mutable std::map<std::array<int, 2>, double> known_;
  double scale_;
};

// Returns which layers behind `layer` see it.
[[nodiscard]] int layers_behind(const ChunkShape& shape, int layer) {
  const auto sees = [&](int m, bool (ChunkShape::*has)(int) const) {
    return m < shape.layers && !shape.empty(m) && (shape.*has)(m);
  };
  return (sees(layer + 1, &ChunkShape::has_cross) ? 1 : 0) |
         (sees(layer + shape.period, &ChunkShape::has_previous) ? 2 : 0);
}

} // namespace

Weights taps_of_layer(const NoiseShape& noise, const ChunkShape& shape, int layer) {
  Weights all{};
  auto* to = all.begin();
  const auto take = [&](int source, int first, int count) {
    const size_t c = layers_behind(shape, source);
    to = std::copy_n(noise.weights[c].begin() + first, count, to);
  };
  take(layer, 0, own_taps);
  if (shape.has_cross(layer)) take(layer - 1, own_taps, cross_taps);
  if (shape.has_previous(layer)) {
    const int source = layer - shape.period;
    take(source, own_taps + (layers_behind(shape, source) & 1 ? cross_taps : 0), previous_taps);
  }
  return all;
}

NoiseShape noise_shape(const Kernel& kernel, bool still) {
  const Overlap overlap(kernel, still);
  NoiseShape shape;
  for (int c = 0; c < (still ? 2 : classes); ++c) {
    const std::vector<Step> taps = steps_to_taps(c);
    LeastSquares equations;
    for (size_t i = 0; i < taps.size(); ++i) {
      for (size_t j = 0; j <= i; ++j) equations.a[i][j] = overlap(taps[i] - taps[j]);
      equations.b[i] = -overlap(taps[i]);
    }
    shape.weights[c] = solve(equations, taps.size());
  }
  return shape;
}

} // namespace bccsplat

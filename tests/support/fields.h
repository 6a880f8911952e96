// Analytic fields sampled on the lattices, and the context tests run in.
#pragma once

#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <vector>

#include "base/context.h"
#include "points/sample_source.h"

namespace bccsplat::test {

// A context that owns its parts.
struct TestContext {
  explicit TestContext(int threads = 2, uint64_t budget = UINT64_MAX) : tasks(threads), memory(budget) {}
  Tasks tasks;
  MemoryBudget memory;
  Progress progress;
  [[nodiscard]] Context get() { return {tasks, memory, progress}; }
};

// f(x, y, z, t) in source index units.
using Field4 = std::function<double(const Vec4&)>;

// Samples of f minus air at every site; values equal to air are not kept.
inline MemorySamples sample_field(const Lattice4& lattice, const Field4& f, double air = 0) {
  std::vector<BrickLayer> layers;
  for (int32_t m = 0; m < lattice.layers(); ++m) {
    const int c = lattice.coset(m);
    const Int3 n = lattice.space.dims(c);
    std::vector<float> dense;
    for (int z = 0; z < n[2]; ++z)
      for (int y = 0; y < n[1]; ++y)
        for (int x = 0; x < n[0]; ++x) {
          const Vec3 p = lattice.site_position(c, {x, y, z});
          dense.push_back(static_cast<float>(f({p[0], p[1], p[2], lattice.layer_frame(m)}) - air));
        }
    layers.push_back(layer_from_dense(lattice.space, c, dense));
  }
  std::vector<std::vector<BrickLayer>> channels;
  channels.push_back(std::move(layers));
  return {lattice, {static_cast<float>(air)}, std::move(channels)};
}

// A sum of plane waves with wave vectors uniform in the ball |w| <= rho pi / T, in index units.
class PlaneWaves {
 public:
  PlaneWaves(int count, double rho, uint32_t seed, int dimensions = 4) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-1, 1);
    while (waves_.size() < static_cast<size_t>(count)) {
      Vec4 w{};
      double length2 = 0;
      for (int a = 0; a < dimensions; ++a) w[static_cast<size_t>(a)] = uniform(random);
      for (const double v : w) length2 += v * v;
      if (length2 > 1) continue;
      for (double& v : w) v *= rho * std::numbers::pi;
      waves_.push_back({w, uniform(random) * std::numbers::pi});
    }
  }
  [[nodiscard]] double operator()(const Vec4& p) const {
    double sum = 0;
    for (const auto& [w, phase] : waves_)
      sum += std::cos(w[0] * p[0] + w[1] * p[1] + w[2] * p[2] + w[3] * p[3] + phase);
    return sum / std::sqrt(static_cast<double>(waves_.size()) / 2); // unit variance
  }

 private:
  struct Wave {
    Vec4 w;
    double phase;
  };
  std::vector<Wave> waves_;
};

// Random points of the domain at least `margin` index units from its ends.
inline std::vector<Vec4> random_points(const Lattice4& lattice, size_t count, uint32_t seed,
                                       double margin = 0) {
  std::mt19937 random(seed);
  std::vector<Vec4> points(count);
  for (Vec4& p : points)
    for (size_t a = 0; a < 4; ++a) {
      const double end = lattice.dims[a] - 1.0, m = std::min(margin, end / 2);
      p[a] = std::uniform_real_distribution<double>(m, end - m)(random);
    }
  return points;
}

} // namespace bccsplat::test

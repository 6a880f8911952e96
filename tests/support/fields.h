// SPDX-License-Identifier: Apache-2.0
// Analytic fields sampled on the lattices, and the context tests run in.
#pragma once

#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <vector>

#include "base/context.h"
#include "points/sample_source.h"
#include "tests/support/dense_layer.h"
#include "tests/support/plane_waves.h"

namespace bccsplat::test {

// A context that owns its parts.
struct TestContext {
  explicit TestContext(int threads = 2, uint64_t budget = UINT64_MAX) : tasks(threads), memory(budget) {}
  Tasks tasks;
  MemoryBudget memory;
  Progress progress;
  [[nodiscard]] Context get() { return {tasks, memory, progress}; }
};

// Bytes in which all coefficients of a test have room.
inline constexpr uint64_t large_cache = uint64_t{1} << 30;

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

// f in lattice units, for lattices whose distances differ from axis to axis: what f holds of a ball of
// frequencies stands alike to the lattice along each.
inline Field4 in_lattice_units(const Lattice4& lattice, Field4 f) {
  return [scales = lattice.scales(), f = std::move(f)](const Vec4& p) {
    return f({p[0] / scales[0], p[1] / scales[1], p[2] / scales[2], scales[3] > 0 ? p[3] / scales[3] : p[3]});
  };
}

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

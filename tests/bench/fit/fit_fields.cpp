// SPDX-License-Identifier: Apache-2.0
// Makes values of plane waves on grids as products along the axes, makes puffs, and compares the samples that
// the fit makes of waves with the waves at the sites.
#include "tests/bench/fit/fit_fields.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>

#include "fit/axis/filter.h"
#include "fit/axis/site_axis.h"

namespace bccsplat::bench {

SeriesWaves::SeriesWaves(double rho, int count, uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int i = 0; i < count; ++i) {
    std::array<double, 4> w;
    double norm = 0;
    for (double& c : w) {
      c = normal(random);
      norm += c * c;
    }
    const double length = rho * std::numbers::pi * std::pow(uniform(random), 0.25);
    for (double& c : w) c *= length / std::sqrt(norm);
    vector.push_back(w);
    phase.push_back(2 * std::numbers::pi * uniform(random));
  }
}

std::vector<double> SeriesWaves::on_grid(const std::array<std::vector<double>, 4>& coordinates) const {
  using Complex = std::complex<double>;
  const size_t waves = vector.size();
  std::array<std::vector<Complex>, 4> factor; // [axis][coordinate * waves + wave]
  for (size_t a = 0; a < 4; ++a)
    for (const double x : coordinates[a])
      for (size_t n = 0; n < waves; ++n)
        factor[a].push_back(std::polar(1.0, vector[n][a] * x + (a == 0 ? phase[n] : 0)));
  std::vector<double> values;
  std::vector<Complex> row(waves);
  for (size_t l = 0; l < coordinates[3].size(); ++l)
    for (size_t k = 0; k < coordinates[2].size(); ++k)
      for (size_t j = 0; j < coordinates[1].size(); ++j) {
        for (size_t n = 0; n < waves; ++n)
          row[n] = factor[3][l * waves + n] * factor[2][k * waves + n] * factor[1][j * waves + n];
        for (size_t i = 0; i < coordinates[0].size(); ++i) {
          double sum = 0;
          const Complex* x = factor[0].data() + i * waves;
          for (size_t n = 0; n < waves; ++n) sum += x[n].real() * row[n].real() - x[n].imag() * row[n].imag();
          values.push_back(sum);
        }
      }
  return values;
}

FitSeries smoke_like(const std::array<uint32_t, 4>& dims) {
  struct Puff {
    std::array<double, 3> start, drift;
    double radius, growth, turn;
  };
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(0, 1);
  const double size = std::min({dims[0], dims[1], dims[2]});
  std::vector<Puff> puffs(10);
  for (Puff& p : puffs) {
    for (size_t a = 0; a < 3; ++a) {
      p.start[a] = (0.2 + 0.6 * uniform(random)) * dims[a];
      p.drift[a] = 0.5 * (uniform(random) - 0.5);
    }
    p.radius = (0.03 + 0.03 * uniform(random)) * size;
    p.growth = 0.02 * uniform(random);
    p.turn = 2 + 2 * uniform(random);
  }
  FitSeries s{dims, {}};
  s.values.reserve(size_t{dims[0]} * dims[1] * dims[2] * dims[3]);
  for (uint32_t t = 0; t < dims[3]; ++t)
    for (uint32_t z = 0; z < dims[2]; ++z)
      for (uint32_t y = 0; y < dims[1]; ++y)
        for (uint32_t x = 0; x < dims[0]; ++x) {
          double v = 0;
          for (const Puff& p : puffs) {
            const double r = p.radius + p.growth * t;
            const double dx = x - p.start[0] - p.drift[0] * t, dy = y - p.start[1] - p.drift[1] * t,
                         dz = z - p.start[2] - p.drift[2] * t, q = (dx * dx + dy * dy + dz * dz) / (r * r);
            if (q < 9)
              v += std::exp(-q) *
                   (0.7 + 0.3 * std::sin(p.turn * (dx + dy * 0.7) / r + 0.2 * t) * std::cos(p.turn * dz / r));
          }
          s.values.push_back(v < 1e-3 ? 0.0f : static_cast<float>(v));
        }
  return s;
}

double sample_psnr(double rho, const std::array<uint32_t, 4>& dims, int waves, uint32_t seed) {
  const SeriesWaves field(rho, waves, seed);
  std::array<std::vector<double>, 4> grid;
  for (size_t a = 0; a < 4; ++a)
    for (uint32_t i = 0; i < dims[a]; ++i) grid[a].push_back(i);
  const std::vector<double> exact = field.on_grid(grid);
  const std::vector<float> values(exact.begin(), exact.end());

  Tasks tasks;
  MemoryBudget memory;
  Progress progress;
  FitOptions options;
  options.dims = dims;
  std::vector<BrickLayer> layers;
  Fit fit(options,
          [&](int32_t, int, std::span<const BrickLayer> given) {
            layers.insert(layers.end(), given.begin(), given.end());
          },
          {tasks, memory, progress});
  for (uint32_t t = 0; t < dims[3]; ++t) {
    FrameBox box;
    box.dims = {dims[0], dims[1], dims[2]};
    box.data = values.data() + size_t{t} * dims[0] * dims[1] * dims[2];
    fit.add_frame(0, {&box, 1});
  }
  const Lattice4 lattice = fit.finish().lattice;

  const double margin = filter_reach(1);
  double square = 0, low = INFINITY, high = -INFINITY;
  uint64_t count = 0;
  for (int32_t m = 0; m < lattice.layers(); ++m) {
    const double t = lattice.layer_frame(m);
    if (t < margin || t > dims[3] - 1.0 - margin) continue;
    const int coset = lattice.coset(m);
    std::array<std::vector<double>, 4> sites;
    Int3 first{};
    sites[3] = {t};
    for (size_t a = 0; a < 3; ++a) {
      const std::vector<double> all = site_positions(lattice, coset, a);
      for (size_t i = 0; i < all.size(); ++i) {
        if (all[i] < margin)
          first[a] = static_cast<int32_t>(i) + 1;
        else if (all[i] <= dims[a] - 1.0 - margin)
          sites[a].push_back(all[i]);
      }
    }
    const std::vector<double> truth = field.on_grid(sites);
    const Int3 n{static_cast<int32_t>(sites[0].size()), static_cast<int32_t>(sites[1].size()),
                 static_cast<int32_t>(sites[2].size())};
    size_t site = 0;
    for (int32_t k = 0; k < n[2]; ++k)
      for (int32_t j = 0; j < n[1]; ++j)
        for (int32_t i = 0; i < n[0]; ++i, ++site) {
          const float got = layers[m].value(first[0] + i, first[1] + j, first[2] + k);
          const double e = got - truth[site];
          square += e * e;
          ++count;
          low = std::min(low, truth[site]);
          high = std::max(high, truth[site]);
        }
  }
  return 20 * std::log10((high - low) / std::sqrt(square / static_cast<double>(count)));
}

} // namespace bccsplat::bench

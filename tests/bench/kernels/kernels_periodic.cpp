// SPDX-License-Identifier: Apache-2.0
// Loops over all sites and their neighbours, without bricks and vectors: stages in floats, as the library
// computes them, and interpolation in doubles.
#include "tests/bench/kernels/kernels_periodic.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace bccsplat::bench {
namespace {

constexpr double coset_pitch = std::numbers::sqrt2;

// A site in reach of another one: steps along the axes, and whether it is of the other coset.
struct Neighbour {
  std::array<int, 4> step{};
  bool other = false;
  double weight = 0;
};

// Seen from coset 0; from coset 1 the other coset lies one step further along every axis.
std::vector<Neighbour> neighbours(const PeriodicLattice& lattice, const Kernel& kernel) {
  std::vector<Neighbour> result;
  constexpr int reach = 4;
  for (const bool other : {false, true})
    for (int l = lattice.axes == 4 ? -reach : 0; l <= (lattice.axes == 4 ? reach : 0); ++l)
      for (int k = -reach; k <= reach; ++k)
        for (int j = -reach; j <= reach; ++j)
          for (int i = -reach; i <= reach; ++i) {
            const auto along = [&](int step) { return (step + (other ? 0.5 : 0)) * coset_pitch; };
            const double x = along(i), y = along(j), z = along(k);
            const double time = lattice.axes == 4 ? kernel.time.value(along(l)) : 1;
            const double weight = time * kernel.space.value(x * x + y * y + z * z);
            if (weight != 0) result.push_back({{i, j, k, l}, other, weight});
          }
  return result;
}

using Doubles = std::array<std::vector<double>, 2>;

Doubles sum_at_sites(const PeriodicLattice& lattice, const std::vector<Neighbour>& reach, const Doubles& c) {
  Doubles out;
  for (const size_t coset : {size_t{0}, size_t{1}}) {
    out[coset].resize(lattice.sites());
    for (size_t i = 0; i < lattice.sites(); ++i) {
      const std::array<int, 4> p = lattice.site(i);
      double sum = 0;
      for (const Neighbour& n : reach) {
        std::array<int, 4> q = p;
        for (size_t a = 0; a < lattice.axes; ++a) q[a] += n.step[a] + (n.other && coset == 1 ? 1 : 0);
        sum += n.weight * c[n.other ? 1 - coset : coset][lattice.index(q)];
      }
      out[coset][i] = sum;
    }
  }
  return out;
}

double dot(const Doubles& a, const Doubles& b) {
  double sum = 0;
  for (const size_t c : {size_t{0}, size_t{1}})
    for (size_t i = 0; i < a[c].size(); ++i) sum += a[c][i] * b[c][i];
  return sum;
}

// a += s * b
void add(Doubles& a, double s, const Doubles& b) {
  for (const size_t c : {size_t{0}, size_t{1}})
    for (size_t i = 0; i < a[c].size(); ++i) a[c][i] += s * b[c][i];
}

Doubles doubles(const Values& f) {
  Doubles d;
  for (const size_t c : {size_t{0}, size_t{1}}) d[c].assign(f[c].begin(), f[c].end());
  return d;
}

Values floats(const Doubles& d) {
  Values f;
  for (const size_t c : {size_t{0}, size_t{1}})
    for (const double v : d[c]) f[c].push_back(static_cast<float>(v));
  return f;
}

} // namespace

Values apply_stages(const PeriodicLattice& lattice, std::span<const PrefilterStage> stages, const Values& f) {
  Values c = f;
  for (const PrefilterStage& s : stages) {
    Values next;
    for (const int coset : {0, 1}) {
      const size_t k = coset;
      const std::vector<float>&own = c[k], &source = f[k], &other = c[1 - k];
      next[k].resize(own.size());
      for (size_t i = 0; i < own.size(); ++i) {
        const std::array<int, 4> p = lattice.site(i);
        const auto at = [&](std::array<int, 4> q, size_t axis, int step) {
          q[axis] += step;
          return q;
        };
        const auto spatial_sums = [&](const std::array<int, 4>& q) {
          std::array<float, 2> sums{};
          for (size_t a = 0; a < 3; ++a)
            for (const int step : {-1, 1}) {
              const size_t j = lattice.index(at(q, a, step));
              sums[0] += own[j];
              sums[1] += source[j];
            }
          return sums;
        };
        const auto w = [](double x) { return static_cast<float>(x); };
        const auto here = spatial_sums(p);
        float sum = w(s.self) * own[i] + w(s.source) * source[i] + w(s.spatial) * here[0] +
                    w(s.source_spatial) * here[1];
        if (lattice.axes == 4)
          for (const int step : {-1, 1}) {
            const std::array<int, 4> q = at(p, 3, step);
            const size_t j = lattice.index(q);
            const auto there = spatial_sums(q);
            sum += w(s.temporal) * own[j] + w(s.source_temporal) * source[j] + w(s.mixed) * there[0] +
                   w(s.source_mixed) * there[1];
          }
        float corners =
            0; // site p of coset 0 lies between p - 1 and p of coset 1, of coset 1 between p and p + 1
        for (unsigned corner = 0; corner < 1u << lattice.axes; ++corner) {
          std::array<int, 4> q = p;
          for (size_t a = 0; a < lattice.axes; ++a) q[a] += static_cast<int>(corner >> a & 1) + coset - 1;
          corners += other[lattice.index(q)];
        }
        next[k][i] = sum + w(s.cross) * corners;
      }
    }
    c = std::move(next);
  }
  return c;
}

Values values_at_sites(const PeriodicLattice& lattice, const Kernel& kernel, const Values& c) {
  return floats(sum_at_sites(lattice, neighbours(lattice, kernel), doubles(c)));
}

Interpolation interpolate(const PeriodicLattice& lattice, const Kernel& kernel, const Values& f,
                          double tolerance) {
  constexpr int most = 500;
  const std::vector<Neighbour> reach = neighbours(lattice, kernel);
  Doubles residual = doubles(f), direction = residual, c = residual;
  for (auto& coset : c) std::fill(coset.begin(), coset.end(), 0.0);
  double square = dot(residual, residual);
  const double enough = square * tolerance * tolerance;
  Interpolation result;
  while (square > enough && result.iterations < most) {
    const Doubles image = sum_at_sites(lattice, reach, direction);
    const double step = square / dot(direction, image);
    add(c, step, direction);
    add(residual, -step, image);
    const double next = dot(residual, residual);
    for (auto& coset : direction)
      for (double& v : coset) v *= next / square;
    add(direction, 1, residual);
    square = next;
    ++result.iterations;
  }
  result.coefficients = floats(c);
  return result;
}

double reconstruct(const Kernel& kernel, const PeriodicLattice& lattice, const Values& c,
                   const std::array<double, 4>& x) {
  const double radius = kernel.space.radius;
  double sum = 0, weights = 0;
  for (const int coset : {0, 1}) {
    std::array<int, 4> first{}, last{};
    for (size_t a = 0; a < lattice.axes; ++a) {
      const double reach = a < 3 ? radius : kernel.time.half_width;
      first[a] = static_cast<int>(std::ceil((x[a] - reach) / coset_pitch - 0.5 * coset));
      last[a] = static_cast<int>(std::floor((x[a] + reach) / coset_pitch - 0.5 * coset));
    }
    const auto distance = [&](const std::array<int, 4>& p, size_t a) {
      return (p[a] + 0.5 * coset) * coset_pitch - x[a];
    };
    std::array<int, 4> p{};
    for (p[3] = first[3]; p[3] <= last[3]; ++p[3]) {
      const double beta = lattice.axes == 4 ? kernel.time.value(distance(p, 3)) : 1;
      if (beta == 0) continue;
      for (p[2] = first[2]; p[2] <= last[2]; ++p[2])
        for (p[1] = first[1]; p[1] <= last[1]; ++p[1])
          for (p[0] = first[0]; p[0] <= last[0]; ++p[0]) {
            double r2 = 0;
            for (size_t a = 0; a < 3; ++a) r2 += distance(p, a) * distance(p, a);
            const double weight = beta * kernel.space.value(r2);
            if (weight == 0) continue;
            sum += weight * c[coset][lattice.index(p)];
            weights += weight;
          }
    }
  }
  return kernel.normalised ? sum / weights : sum;
}

} // namespace bccsplat::bench

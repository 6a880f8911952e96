#include <cmath>
#include <numbers>

#include "tests/bench/kernel_design.h"
#include "tests/bench/kernels.h"

namespace bccsplat::bench {
namespace {

constexpr double pitch = std::numbers::sqrt2;
constexpr size_t wave_count = 120;
constexpr size_t point_count = 1500;

// A periodic lattice: two cosets of edge^d sites, x fastest, coset 1 displaced by half a pitch on every axis.
struct Periodic {
  size_t axes;
  int edge;

  [[nodiscard]] size_t sites() const {
    size_t n = 1;
    for (size_t a = 0; a < axes; ++a) n *= static_cast<size_t>(edge);
    return n;
  }
  [[nodiscard]] std::array<int, 4> site(size_t i) const {
    std::array<int, 4> p{};
    for (size_t a = 0; a < axes; ++a, i /= static_cast<size_t>(edge)) p[a] = static_cast<int>(i) % edge;
    return p;
  }
  [[nodiscard]] size_t index(const std::array<int, 4>& p) const {
    size_t i = 0;
    for (size_t a = axes; a-- > 0;)
      i = i * static_cast<size_t>(edge) + static_cast<size_t>((p[a] + edge) % edge);
    return i;
  }
};

using Values = std::array<std::vector<float>, 2>; // by coset

// The stages as they are defined, site by site.
Values prefilter(const Periodic& lattice, std::span<const PrefilterStage> stages, const Values& f) {
  Values c = f;
  for (const PrefilterStage& s : stages) {
    Values next;
    for (const int coset : {0, 1}) {
      const auto k = static_cast<size_t>(coset);
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

struct Wave {
  std::array<double, 4> frequency{};
  double phase = 0;
};

double value(const std::vector<Wave>& waves, const std::array<double, 4>& x) {
  double sum = 0;
  for (const Wave& w : waves) {
    double turns = w.phase;
    for (size_t a = 0; a < 4; ++a) turns += w.frequency[a] * x[a];
    sum += std::cos(2 * std::numbers::pi * turns);
  }
  return sum;
}

// The sum over the sites in reach of x; divided by the sum of the weights for the paper's kernel.
double reconstruct(const Kernel& kernel, const Periodic& lattice, const Values& c,
                   const std::array<double, 4>& x) {
  const double radius = kernel.space.radius;
  double sum = 0, weights = 0;
  for (const int coset : {0, 1}) {
    std::array<int, 4> first{}, last{};
    for (size_t a = 0; a < lattice.axes; ++a) {
      const double reach = a < 3 ? radius : kernel.time.half_width;
      first[a] = static_cast<int>(std::ceil((x[a] - reach) / pitch - 0.5 * coset));
      last[a] = static_cast<int>(std::floor((x[a] + reach) / pitch - 0.5 * coset));
    }
    const auto distance = [&](const std::array<int, 4>& p, size_t a) {
      return (p[a] + 0.5 * coset) * pitch - x[a];
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
            sum += weight * static_cast<double>(c[static_cast<size_t>(coset)][lattice.index(p)]);
            weights += weight;
          }
    }
  }
  return kernel.normalised ? sum / weights : sum;
}

} // namespace

std::array<double, 4> measured_snr(const Kernel& kernel, int dimensions) {
  const auto axes = static_cast<size_t>(dimensions);
  const Periodic lattice{axes, dimensions == 4 ? 12 : 24};
  const double period = lattice.edge * pitch;
  uint64_t state = 7;
  const auto uniform = [&] { // [0, 1)
    state = state * 6364136223846793005u + 1442695040888963407u;
    return static_cast<double>(state >> 11) / 9007199254740992.0;
  };
  std::array<double, 4> snr{};
  for (size_t r = 0; r < design_rhos.size(); ++r) {
    const double radius = 0.5 * design_rhos[r] * period; // of the ball, in steps of the periodic frequencies
    std::vector<Wave> waves;
    while (waves.size() < wave_count) {
      Wave w;
      double square = 0;
      for (size_t a = 0; a < axes; ++a) {
        const double n = std::floor((2 * uniform() - 1) * radius + 0.5);
        square += n * n;
        w.frequency[a] = n / period;
      }
      w.phase = uniform();
      if (square <= radius * radius) waves.push_back(w);
    }
    Values f;
    for (const int coset : {0, 1})
      for (size_t i = 0; i < lattice.sites(); ++i) {
        const std::array<int, 4> p = lattice.site(i);
        std::array<double, 4> x{};
        for (size_t a = 0; a < axes; ++a) x[a] = (p[a] + 0.5 * coset) * pitch;
        f[static_cast<size_t>(coset)].push_back(static_cast<float>(value(waves, x)));
      }
    const Values c = prefilter(lattice, dimensions == 4 ? kernel.prefilter4 : kernel.prefilter3, f);
    double signal = 0, error = 0;
    for (size_t i = 0; i < point_count; ++i) {
      std::array<double, 4> x{};
      for (size_t a = 0; a < axes; ++a) x[a] = uniform() * period;
      const double truth = value(waves, x);
      const double miss = reconstruct(kernel, lattice, c, x) - truth;
      signal += truth * truth;
      error += miss * miss;
    }
    snr[r] = 10 * std::log10(signal / error);
  }
  return snr;
}

} // namespace bccsplat::bench

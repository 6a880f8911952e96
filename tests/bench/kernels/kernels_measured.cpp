// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <numbers>

#include "tests/bench/kernels/kernels.h"
#include "tests/bench/kernels/kernels_periodic.h"

namespace bccsplat::bench {
namespace {

constexpr double pitch = std::numbers::sqrt2;
constexpr size_t wave_count = 120;
constexpr size_t point_count = 1500;

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

} // namespace

std::array<double, 4> measured_snr(const Kernel& kernel, int dimensions, bool interpolating) {
  const size_t axes = dimensions;
  const PeriodicLattice lattice{axes, dimensions == 4 ? 12 : 24};
  const double period = lattice.edge * pitch;
  uint64_t state = 7;
  const auto uniform = [&] { // [0, 1)
    state = state * 6364136223846793005u + 1442695040888963407u;
    return static_cast<double>(state >> 11) / 9007199254740992.0;
  };
  std::array<double, 4> snr{};
  for (size_t r = 0; r < table_rhos.size(); ++r) {
    const double radius = 0.5 * table_rhos[r] * period; // of the ball, in steps of the periodic frequencies
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
        f[coset].push_back(static_cast<float>(value(waves, x)));
      }
    const Values c = interpolating
                         ? interpolate(lattice, kernel, f, 1e-5).coefficients
                         : apply_stages(lattice, dimensions == 4 ? kernel.prefilter4 : kernel.prefilter3, f);
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

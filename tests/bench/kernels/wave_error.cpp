// SPDX-License-Identifier: Apache-2.0
// Integrates the error of a kernel and its prefilter over the plane waves of a ball of frequencies.
#include "tests/bench/kernels/wave_error.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/vec.h"

namespace bccsplat {
namespace {

using std::numbers::pi;
constexpr double site_pitch = std::numbers::sqrt2;

// The additive recurrence of the generalised golden ratio, x^(d+1) = x + 1 (Roberts), which fills the unit
// cube evenly.
class Recurrence {
 public:
  explicit Recurrence(int d) {
    double g = 2;
    for (int i = 0; i < 60; ++i) g = std::pow(1 + g, 1.0 / (d + 1));
    for (double& a : alpha_) a = 1 / g, g *= 1 / alpha_[0];
  }
  [[nodiscard]] std::array<double, 4> next() {
    std::array<double, 4> x;
    for (size_t i = 0; i < 4; ++i) {
      state_[i] += alpha_[i];
      state_[i] -= std::floor(state_[i]);
      x[i] = state_[i];
    }
    return x;
  }

 private:
  std::array<double, 4> alpha_{};
  std::array<double, 4> state_{0.5, 0.5, 0.5, 0.5};
};

} // namespace

// Sums over the dual lattice, whose vectors n / sqrt2 have n with an even sum: n_t is even or odd with the
// rest.
WaveSample wave_sample(const KernelSpectrum& kernel, int dimensions, const std::array<double, 4>& xi) {
  constexpr int far = 6;       // units of 1/sqrt2: 4.2 cycles per T, the spectra of phi are below 1e-6 there
  constexpr int far_time = 12; // those of beta fall more slowly, but their fourth powers are below 1e-6 there
  double time = 1;
  std::array<double, 2> time2{1, 0}; // by parity of n_t: the sum of the squares of beta's transform
  if (dimensions == 4) {
    time = kernel.time(xi[3]);
    time2 = {0, 0};
    for (int n = -far_time; n <= far_time; ++n) {
      const double b = kernel.time(xi[3] + n / site_pitch);
      time2[n & 1] += b * b;
    }
  }
  WaveSample w;
  w.means = neighbour_means4(xi);
  w.symbol = kernel.symbol(xi, dimensions);
  w.pass = kernel.space(std::hypot(xi[0], xi[1], xi[2])) * time;
  double total2 = 0, gradient2 = 0;
  for (int c = -far; c <= far; ++c)
    for (int b = -far; b <= far; ++b)
      for (int a = -far; a <= far; ++a) {
        if (a * a + b * b + c * c > far * far) continue;
        const Vec3 k{xi[0] + a / site_pitch, xi[1] + b / site_pitch, xi[2] + c / site_pitch};
        const double k2 = dot(k, k);
        const double phi = kernel.space(std::sqrt(k2));
        const double square = phi * phi * time2[(a + b + c) & 1];
        total2 += square;
        gradient2 += k2 * square;
      }
  w.alias2 = std::max(total2 - w.pass * w.pass, 0.0);
  w.space2 = xi[0] * xi[0] + xi[1] * xi[1] + xi[2] * xi[2];
  w.alias_gradient2 = std::max(gradient2 - w.space2 * w.pass * w.pass, 0.0);
  return w;
}

std::vector<std::array<double, 4>> ball_frequencies(int dimensions, double rho, size_t count) {
  Recurrence points(dimensions);
  std::vector<std::array<double, 4>> frequencies;
  frequencies.reserve(count);
  while (frequencies.size() < count) {
    const std::array<double, 4> u = points.next();
    if (dimensions == 3) {
      const double r = 0.5 * rho * std::cbrt(u[0]);
      const double z = 2 * u[1] - 1;
      const double s = std::sqrt(1 - z * z);
      frequencies.push_back({r * s * std::cos(2 * pi * u[2]), r * s * std::sin(2 * pi * u[2]), r * z, 0});
    } else { // Hopf coordinates: the square of the first radius is uniform on the 3-sphere
      const double r = 0.5 * rho * std::pow(u[0], 0.25);
      const double p = r * std::sqrt(u[1]);
      const double q = r * std::sqrt(1 - u[1]);
      frequencies.push_back({p * std::cos(2 * pi * u[2]), p * std::sin(2 * pi * u[2]),
                             q * std::cos(2 * pi * u[3]), q * std::sin(2 * pi * u[3])});
    }
  }
  return frequencies;
}

std::vector<WaveSample> ball_waves(const KernelSpectrum& kernel, int dimensions, double rho, size_t count) {
  std::vector<WaveSample> waves;
  waves.reserve(count);
  for (const auto& xi : ball_frequencies(dimensions, rho, count))
    waves.push_back(wave_sample(kernel, dimensions, xi));
  return waves;
}

std::vector<WaveSample> all_waves(const KernelSpectrum& kernel, int dimensions, size_t count) {
  // Symbols are even in every component and periodic over the dual, so that the box [0, 1/sqrt2] per axis
  // holds them all.
  std::vector<WaveSample> waves;
  waves.reserve(count);
  // Multiples of 1/4 of that box come first: centre, vertices, edges and faces of the dual cell are among
  // them.
  const int planes = 5;
  for (int i = 0; i < planes * planes * planes * (dimensions == 4 ? planes : 1); ++i) {
    std::array<double, 4> xi{};
    int rest = i;
    for (size_t a = 0; a < static_cast<size_t>(dimensions); ++a, rest /= planes)
      xi[a] = rest % planes / (4 * site_pitch);
    waves.push_back(wave_sample(kernel, dimensions, xi));
  }
  Recurrence points(dimensions);
  while (waves.size() < count) {
    std::array<double, 4> xi = points.next();
    for (double& x : xi) x /= site_pitch;
    if (dimensions == 3) xi[3] = 0;
    waves.push_back(wave_sample(kernel, dimensions, xi));
  }
  return waves;
}

double snr_db(std::span<const WaveSample> waves, std::span<const PrefilterStage> stages, int dimensions) {
  const int cross = dimensions == 4 ? 16 : 8;
  double sum = 0;
  for (const WaveSample& w : waves) sum += wave_error(w, prefilter_symbol(stages, w.means, cross));
  return -10 * std::log10(sum / static_cast<double>(waves.size()));
}

double gradient_snr_db(std::span<const WaveSample> waves, std::span<const PrefilterStage> stages,
                       int dimensions) {
  const int cross = dimensions == 4 ? 16 : 8;
  double signal = 0, error = 0;
  for (const WaveSample& w : waves) {
    signal += w.space2;
    error += wave_gradient_error(w, prefilter_symbol(stages, w.means, cross));
  }
  return 10 * std::log10(signal / error);
}

double snr_db_interpolating(std::span<const WaveSample> waves) {
  double sum = 0;
  for (const WaveSample& w : waves) sum += wave_error(w, 1 / w.symbol);
  return -10 * std::log10(sum / static_cast<double>(waves.size()));
}

} // namespace bccsplat

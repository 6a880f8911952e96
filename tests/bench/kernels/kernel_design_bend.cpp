// SPDX-License-Identifier: Apache-2.0
// Has the error of a wave at one instant in closed form, quadratic in the bends, and minimises it over balls
// and phases by least squares, weighted anew in each of 20 rounds.
#include "tests/bench/kernels/kernel_design_bend.h"

#include <cmath>
#include <complex>
#include <numbers>

#include "kernel/wave_error.h"
#include "tests/bench/kernels/kernel_design.h"

namespace bccsplat::bench {
namespace {

using Complex = std::complex<double>;

// A wave of frequency xi becomes, in the layers of an instant, sum over n in Z^3 of Q W_n Phi(xi + n / sqrt2)
// times waves of those frequencies: in space the sites of a coset repeat the spectrum at n / sqrt2, with the
// sign (-1)^(n_x + n_y + n_z) for coset 1. W_n adds the weights of the layers, times the phases of the wave
// there, of both cosets for even sums of n, and takes those of coset 1 from those of coset 0 for odd ones.
struct BentWave {
  double time;      // its frequency along t, cycles per T
  double q;         // of the prefilter
  double pass;      // Phi(xi)
  double even, odd; // sums of Phi^2 over n of even and odd sum, the former with n = 0
};

std::vector<BentWave> waves_of(const Kernel& kernel, double rho, size_t count) {
  const KernelSpectrum spectrum(kernel);
  std::vector<BentWave> waves;
  for (const auto& xi : ball_frequencies(4, rho, count)) {
    BentWave w{xi[3], prefilter_symbol(kernel.prefilter4, neighbour_means4(xi), 16), 0, 0, 0};
    constexpr int reach = 4;
    for (int z = -reach; z <= reach; ++z)
      for (int y = -reach; y <= reach; ++y)
        for (int x = -reach; x <= reach; ++x) {
          const double k = std::hypot(xi[0] + x / std::numbers::sqrt2, xi[1] + y / std::numbers::sqrt2,
                                      xi[2] + z / std::numbers::sqrt2);
          const double phi = spectrum.space(k);
          if (x == 0 && y == 0 && z == 0) w.pass = phi;
          ((x + y + z) % 2 == 0 ? w.even : w.odd) += phi * phi;
        }
    waves.push_back(w);
  }
  return waves;
}

constexpr int spline_reach = 4; // layers on either side: no spline has more

// Weights of layers -spline_reach .. spline_reach + 1 at an instant `phase` layers after layer 0.
using LayerWeights = std::array<double, 2 * spline_reach + 2>;

LayerWeights weights_at(const TemporalKernel& beta, double phase) {
  LayerWeights w;
  for (int i = 0; i < 2 * spline_reach + 2; ++i)
    w[i] = beta.value((i - spline_reach - phase) / std::numbers::sqrt2);
  return w;
}

// W_n for even and odd sums of n.
std::array<Complex, 2> passed(const BentWave& wave, const LayerWeights& weights, double phase) {
  std::array<Complex, 2> by_coset{};
  for (int i = 0; i < 2 * spline_reach + 2; ++i) {
    const double t = (i - spline_reach - phase) / std::numbers::sqrt2;
    by_coset[i & 1] += std::polar(0.5 * weights[i], 2 * std::numbers::pi * wave.time * t);
  }
  return {by_coset[0] + by_coset[1], by_coset[0] - by_coset[1]};
}

double error_of(const BentWave& w, const LayerWeights& weights, double phase) {
  const auto [even, odd] = passed(w, weights, phase);
  return std::norm(w.q * w.pass * even - 1.0) +
         w.q * w.q * (std::norm(even) * (w.even - w.pass * w.pass) + std::norm(odd) * w.odd);
}

double phase_of(int i, int phases) { return 0.5 * i / (phases - 1); }
// Of the mean over all phases, the ends being their own mirror images.
double share_of(int i, int phases) { return (i == 0 || i == phases - 1 ? 0.5 : 1.0) / (phases - 1); }

} // namespace

std::vector<double> phase_errors(const Kernel& kernel, double rho, int phases, size_t waves) {
  const std::vector<BentWave> ball = waves_of(kernel, rho, waves);
  std::vector<double> errors;
  for (int i = 0; i < phases; ++i) {
    const double phase = phase_of(i, phases);
    const LayerWeights weights = weights_at(kernel.time, phase);
    double sum = 0;
    for (const BentWave& w : ball) sum += error_of(w, weights, phase);
    errors.push_back(sum / static_cast<double>(ball.size()));
  }
  return errors;
}

std::array<double, 2> design_bend(const Kernel& kernel) {
  constexpr int phases = 17, rounds = 20;
  constexpr size_t waves = 1500;
  Kernel bent = kernel;
  bent.time.bend = {};
  const TemporalKernel straight = bent.time;
  std::vector<std::vector<BentWave>> balls;
  for (const double rho : design_rhos) balls.push_back(waves_of(kernel, rho, waves));
  const int order = kernel.time.order;
  const std::array<bool, 2> free{order > 2, true}; // what the order uses
  // The error is quadratic in the bends: least squares, weighted by 1 / error of the ball and by how much
  // louder than the mean a phase is, until that settles.
  for (int round = 0; round < rounds; ++round) {
    std::array<std::array<double, 2>, 2> normal{};
    std::array<double, 2> right{};
    for (const auto& ball : balls) {
      double error = 0;
      std::array<double, phases> at{}; // error of each phase
      for (int i = 0; i < phases; ++i) {
        const LayerWeights weights = weights_at(bent.time, phase_of(i, phases));
        for (const BentWave& w : ball) at[i] += error_of(w, weights, phase_of(i, phases));
        error += share_of(i, phases) * at[i];
      }
      for (int i = 0; i < phases; ++i) {
        const double phase = phase_of(i, phases), louder = at[i] / error;
        const double share = share_of(i, phases) * std::pow(louder, 6) / error;
        const LayerWeights base = weights_at(straight, phase);
        std::array<LayerWeights, 2> turn{};
        for (size_t b = 0; b < 2; ++b) {
          TemporalKernel one = straight;
          one.bend[b] = free[b] ? 1 : 0;
          turn[b] = weights_at(one, phase);
          for (size_t k = 0; k < base.size(); ++k) turn[b][k] -= base[k];
        }
        for (const BentWave& w : ball) {
          const auto [even, odd] = passed(w, base, phase);
          std::array<std::array<Complex, 2>, 2> d;
          for (size_t b = 0; b < 2; ++b) d[b] = passed(w, turn[b], phase);
          const double scale = share * w.q * w.q;
          for (size_t a = 0; a < 2; ++a) {
            right[a] +=
                share * w.q * w.pass * d[a][0].real() - scale * (w.even * (even * std::conj(d[a][0])).real() +
                                                                 w.odd * (odd * std::conj(d[a][1])).real());
            for (size_t b = 0; b < 2; ++b)
              normal[a][b] += scale * (w.even * (d[a][0] * std::conj(d[b][0])).real() +
                                       w.odd * (d[a][1] * std::conj(d[b][1])).real());
          }
        }
      }
    }
    for (size_t b = 0; b < 2; ++b)
      if (!free[b]) normal[b][b] = 1;
    const double determinant = normal[0][0] * normal[1][1] - normal[0][1] * normal[1][0];
    bent.time.bend = {(right[0] * normal[1][1] - right[1] * normal[0][1]) / determinant,
                      (right[1] * normal[0][0] - right[0] * normal[1][0]) / determinant};
  }
  return bent.time.bend;
}

} // namespace bccsplat::bench

// SPDX-License-Identifier: Apache-2.0
// Spectra of kernels against closed forms and integrals, and the error of waves against a wave that is summed
// from its sites.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "kernel/kernel.h"
#include "tests/bench/kernels/wave_error.h"

namespace bccsplat {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double pitch = std::numbers::sqrt2;

TEST(KernelSpectrum, OfGaussiansIsAGaussian) {
  const KernelSpectrum spectrum(make_kernel("gauss09"));
  for (double k = 0; k < 1.2; k += 0.07) {
    const double expected = std::exp(-pi * pi * k * k / 0.9); // cut at 7e-4 of its height
    EXPECT_NEAR(spectrum.space(k), expected, 4e-3) << k;
    EXPECT_NEAR(spectrum.time(k), expected, 1e-3) << k;
  }
}

TEST(KernelSpectrum, StartsWithTheSecondMoment) {
  for (const char* name : {"radial16+b2", "radial18+b3", "radial20+b4", "radial24+b3"}) {
    const Kernel kernel = make_kernel(name);
    const KernelSpectrum spectrum(kernel);
    const double k = 0.01;
    const double drop = 2 * pi * pi * k * k;
    EXPECT_NEAR(spectrum.space(0), 1, 1e-8);
    double variance = 0, in_space = 0; // along one axis
    constexpr int steps = 20000;
    for (int i = 0; i < steps; ++i) {
      const double t = kernel.time.half_width * (i + 0.5) / steps;
      variance += 2 * t * t * kernel.time.value(t) / pitch * kernel.time.half_width / steps;
      const double r = kernel.space.radius * (i + 0.5) / steps;
      in_space +=
          4 * pi / 3 * std::pow(r, 4) * kernel.space.value(r * r) / pitch * kernel.space.radius / steps;
    }
    EXPECT_NEAR(spectrum.space(k), 1 - drop * in_space, 1e-6);
    EXPECT_NEAR(spectrum.time(k), 1 - drop * variance, 1e-6);
    // The table agrees with the integral between its entries and at them.
    for (const double f : {0.123456, 0.7, 1.37, 2.9}) {
      double sum = 0;
      constexpr int n = 20000;
      for (int i = 0; i < n; ++i) {
        const double r = kernel.space.radius * (i + 0.5) / n;
        sum += 2 * r * kernel.space.value(r * r) * std::sin(2 * pi * f * r) / f * kernel.space.radius / n;
      }
      EXPECT_NEAR(spectrum.space(f), sum / pitch, 1e-7) << name << " at " << f;
    }
  }
}

// Reconstructs a complex wave from the sites around a point, the prefilter taken by its symbol.
std::complex<double> reconstruct(const Kernel& kernel, int dimensions, const std::array<double, 4>& xi,
                                 double q, const std::array<double, 4>& x) {
  std::complex<double> sum = 0;
  const int t_end = dimensions == 4 ? 5 : 0;
  for (const double half : {0.0, 0.5})
    for (int t = -t_end; t <= t_end; ++t) {
      const double dt = dimensions == 4 ? (t + half) * pitch - x[3] : 0;
      const double beta = dimensions == 4 ? kernel.time.value(dt) : 1;
      if (beta == 0) continue;
      for (int a = -4; a <= 4; ++a)
        for (int b = -4; b <= 4; ++b)
          for (int c = -4; c <= 4; ++c) {
            const double dx = (a + half) * pitch - x[0], dy = (b + half) * pitch - x[1];
            const double dz = (c + half) * pitch - x[2];
            const double weight = beta * kernel.space.value(dx * dx + dy * dy + dz * dz);
            if (weight == 0) continue;
            const double turns =
                xi[0] * (x[0] + dx) + xi[1] * (x[1] + dy) + xi[2] * (x[2] + dz) + xi[3] * (x[3] + dt);
            sum += weight * q * std::polar(1.0, 2 * pi * turns);
          }
    }
  return sum;
}

TEST(WaveError, IsTheMeanSquareErrorOfTheSum) {
  struct Case {
    const char* name;
    int dimensions;
    std::array<double, 4> xi;
  };
  for (const Case& c : {Case{"fast", 4, {0.21, 0.1, -0.15, 0.3}}, Case{"default", 4, {0.1, 0.33, 0.2, -0.25}},
                        Case{"fine", 3, {0.3, -0.3, 0.1, 0}}, Case{"gauss09", 4, {0.4, 0.2, 0.1, 0.1}}}) {
    const Kernel kernel = make_kernel(c.name);
    const KernelSpectrum spectrum(kernel);
    const WaveSample w = wave_sample(spectrum, c.dimensions, c.xi);
    const auto& stages = c.dimensions == 4 ? kernel.prefilter4 : kernel.prefilter3;
    for (const double q : {1.0, prefilter_symbol(stages, w.means, c.dimensions == 4 ? 16 : 8)}) {
      double error = 0;
      constexpr int n = 400;
      for (int i = 0; i < n; ++i) { // multiples of irrational vectors fill the cell evenly
        const std::array<double, 4> x{
            pitch * std::fmod(i * 0.8566749, 1), pitch * std::fmod(i * 0.7338919, 1),
            pitch * std::fmod(i * 0.6287067, 1), c.dimensions == 4 ? pitch * std::fmod(i * 0.5385973, 1) : 0};
        const double turns = c.xi[0] * x[0] + c.xi[1] * x[1] + c.xi[2] * x[2] + c.xi[3] * x[3];
        error +=
            std::norm(reconstruct(kernel, c.dimensions, c.xi, q, x) - std::polar(1.0, 2 * pi * turns)) / n;
      }
      EXPECT_NEAR(error, wave_error(w, q), 0.04 * error + 1e-7) << c.name << ", Q " << q;
    }
    // The gradient's error comes from differences of the error.
    double gradient = 0;
    constexpr int n = 300;
    constexpr double h = 1e-4;
    for (int i = 0; i < n; ++i)
      for (size_t a = 0; a < 3; ++a) {
        std::array<std::complex<double>, 2> miss;
        for (const size_t side : {0u, 1u}) {
          std::array<double, 4> x{pitch * std::fmod(i * 0.8566749, 1), pitch * std::fmod(i * 0.7338919, 1),
                                  pitch * std::fmod(i * 0.6287067, 1),
                                  c.dimensions == 4 ? pitch * std::fmod(i * 0.5385973, 1) : 0};
          x[a] += side == 0 ? -h : h;
          const double turns = c.xi[0] * x[0] + c.xi[1] * x[1] + c.xi[2] * x[2] + c.xi[3] * x[3];
          miss[side] = reconstruct(kernel, c.dimensions, c.xi, 1, x) - std::polar(1.0, 2 * pi * turns);
        }
        gradient += std::norm((miss[1] - miss[0]) / (2 * h)) / n;
      }
    EXPECT_NEAR(gradient / (4 * pi * pi), wave_gradient_error(w, 1), 0.04 * wave_gradient_error(w, 1))
        << c.name;
    // At the sites the kernel multiplies the wave by its symbol.
    EXPECT_NEAR(std::abs(reconstruct(kernel, c.dimensions, c.xi, 1, {}) - w.symbol), 0, 1e-12) << c.name;
  }
}

TEST(WaveError, BallsAreUniform) {
  for (const int dimensions : {3, 4}) {
    double second = 0;
    std::array<double, 4> per_axis{};
    const auto waves = ball_frequencies(dimensions, 0.8, 5000);
    for (const auto& xi : waves)
      for (size_t a = 0; a < 4; ++a) second += xi[a] * xi[a] / 5000, per_axis[a] += xi[a] * xi[a] / 5000;
    EXPECT_NEAR(second, 0.16 * dimensions / (dimensions + 2), 1e-3);
    for (size_t a = 0; a < static_cast<size_t>(dimensions); ++a)
      EXPECT_NEAR(per_axis[a], second / dimensions, 1e-3);
  }
}

} // namespace
} // namespace bccsplat

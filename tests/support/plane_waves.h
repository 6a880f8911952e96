// SPDX-License-Identifier: Apache-2.0
// Fields known everywhere: sums of plane waves inside a ball of frequencies.
#pragma once

#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <vector>

#include "base/vec.h"

namespace bccsplat::test {

using Grid4 = std::array<std::vector<double>, 4>; // coordinates of a tensor grid per axis x, y, z, t

// A sum of plane waves whose wave vectors are uniform in the ball |w| <= rho pi / T (index units, T = 1) of 3
// or 4 dimensions; mean square 1.
class PlaneWaves {
 public:
  PlaneWaves(int count, double rho, uint32_t seed, int dimensions = 4) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-1, 1);
    while (waves_.size() < static_cast<size_t>(count)) {
      Vec4 w{};
      double length2 = 0;
      for (int a = 0; a < dimensions; ++a) w[a] = uniform(random);
      for (const double v : w) length2 += v * v;
      if (length2 > 1) continue;
      for (double& v : w) v *= rho * std::numbers::pi;
      waves_.push_back({w, uniform(random) * std::numbers::pi});
    }
    amplitude_ = std::sqrt(2.0 / count);
  }
  [[nodiscard]] double operator()(const Vec4& p) const {
    double sum = 0;
    for (const Wave& w : waves_) sum += std::cos(angle(w, p));
    return amplitude_ * sum;
  }
  [[nodiscard]] Vec4 gradient(const Vec4& p) const {
    Vec4 g{};
    for (const Wave& w : waves_) {
      const double s = -amplitude_ * std::sin(angle(w, p));
      for (size_t a = 0; a < 4; ++a) g[a] += s * w.vector[a];
    }
    return g;
  }
  // Values on a tensor grid, x fastest.
  [[nodiscard]] std::vector<double> on_grid(const Grid4& at) const {
    using Complex = std::complex<double>;
    const size_t n = waves_.size();
    std::array<std::vector<Complex>, 4> factor; // [axis][coordinate * waves + wave]
    for (size_t a = 0; a < 4; ++a)
      for (const double x : at[a])
        for (const Wave& w : waves_)
          factor[a].push_back(std::polar(1.0, w.vector[a] * x + (a == 0 ? w.phase : 0)));
    std::vector<double> values, real(n), imaginary(n);
    for (size_t l = 0; l < at[3].size(); ++l)
      for (size_t k = 0; k < at[2].size(); ++k)
        for (size_t j = 0; j < at[1].size(); ++j) {
          for (size_t i = 0; i < n; ++i) {
            const Complex row = factor[3][l * n + i] * factor[2][k * n + i] * factor[1][j * n + i];
            real[i] = amplitude_ * row.real(), imaginary[i] = amplitude_ * row.imag();
          }
          for (size_t x = 0; x < at[0].size(); ++x) {
            const Complex* f = factor[0].data() + x * n;
            double sum = 0;
            for (size_t i = 0; i < n; ++i) sum += f[i].real() * real[i] - f[i].imag() * imaginary[i];
            values.push_back(sum);
          }
        }
    return values;
  }

 private:
  struct Wave {
    Vec4 vector;
    double phase;
  };
  static double angle(const Wave& w, const Vec4& p) {
    return w.vector[0] * p[0] + w.vector[1] * p[1] + w.vector[2] * p[2] + w.vector[3] * p[3] + w.phase;
  }
  std::vector<Wave> waves_;
  double amplitude_;
};

} // namespace bccsplat::test

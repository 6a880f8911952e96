// SPDX-License-Identifier: Apache-2.0
// How close the samples on D4* come to a band-limited field, from its Cartesian samples.
#include <complex>

#include <gtest/gtest.h>

#include "fit/axis/filter.h"
#include "tests/unit/fit/fit_series.h"

namespace bccsplat::test {
namespace {

// A sum of plane waves whose wave vectors are uniform in the ball |w| <= rho * pi / T.
struct Waves {
  std::vector<std::array<double, 4>> w;
  std::vector<double> phase;

  Waves(double rho, int count, uint32_t seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform(0, 1);
    for (int i = 0; i < count; ++i) {
      std::array<double, 4> v;
      double norm = 0;
      for (double& c : v) {
        c = normal(random);
        norm += c * c;
      }
      const double r = rho * std::numbers::pi * std::pow(uniform(random), 0.25);
      for (double& c : v) c *= r / std::sqrt(norm);
      w.push_back(v);
      phase.push_back(2 * std::numbers::pi * uniform(random));
    }
  }

  // Values on a tensor grid; calls body(i, j, k, l, value).
  template<class Body> void on_grid(const std::array<std::vector<double>, 4>& p, const Body& body) const {
    using Complex = std::complex<double>;
    std::array<std::vector<Complex>, 4> e; // [axis][position * waves + wave]
    for (size_t a = 0; a < 4; ++a)
      for (const double x : p[a])
        for (size_t n = 0; n < w.size(); ++n)
          e[a].push_back(std::polar(1.0, w[n][a] * x + (a == 0 ? phase[n] : 0)));
    std::vector<Complex> row(w.size());
    for (size_t l = 0; l < p[3].size(); ++l)
      for (size_t k = 0; k < p[2].size(); ++k)
        for (size_t j = 0; j < p[1].size(); ++j) {
          for (size_t n = 0; n < w.size(); ++n)
            row[n] = e[3][l * w.size() + n] * e[2][k * w.size() + n] * e[1][j * w.size() + n];
          for (size_t i = 0; i < p[0].size(); ++i) {
            double sum = 0;
            for (size_t n = 0; n < w.size(); ++n) {
              const Complex& x = e[0][i * w.size() + n];
              sum += x.real() * row[n].real() - x.imag() * row[n].imag();
            }
            body(i, j, k, l, sum);
          }
        }
  }
};

// PSNR (peak: the range of the signal) of the D4* samples that see no mirrored frame or sample.
double sample_psnr(double rho) {
  const Waves waves(rho, 100, 11);
  Series s;
  s.dims = {26, 24, 25, 24};
  std::array<std::vector<double>, 4> grid;
  for (size_t a = 0; a < 4; ++a)
    for (uint32_t i = 0; i < s.dims[a]; ++i) grid[a].push_back(i);
  waves.on_grid(grid,
                [&](size_t, size_t, size_t, size_t, double v) { s.values.push_back(static_cast<float>(v)); });

  FitOptions o = options_for(s);
  const Fitted f = run_fit(o, s);
  const Lattice4& l = f.report.lattice;
  const int margin = filter_reach(1);
  double square = 0, low = 1e9, high = -1e9;
  uint64_t count = 0;
  for (int32_t m = 0; m < l.layers(); ++m) {
    const double t = l.layer_frame(m);
    if (t < margin || t > s.dims[3] - 1.0 - margin) continue;
    const int c = l.coset(m);
    std::array<std::vector<double>, 4> sites;
    std::array<std::vector<int32_t>, 3> index;
    sites[3] = {t};
    for (size_t a = 0; a < 3; ++a)
      for (int32_t i = 0; i < l.space.dims(c)[a]; ++i) {
        const double p = l.space.plane(c, i) * l.space_step[a];
        if (p < margin || p > s.dims[a] - 1.0 - margin) continue;
        sites[a].push_back(p);
        index[a].push_back(i);
      }
    waves.on_grid(sites, [&](size_t i, size_t j, size_t k, size_t, double truth) {
      const double e = f.layers[m].value(index[0][i], index[1][j], index[2][k]) - truth;
      square += e * e;
      ++count;
      low = std::min(low, truth);
      high = std::max(high, truth);
    });
  }
  return count ? 20 * std::log10((high - low) / std::sqrt(square / static_cast<double>(count))) : 0;
}

// Measured on 48^4 samples and 2000 waves: 76 / 65 / 44 dB; less 1.5 dB for the smaller sample.
TEST(FitAccuracy, KaiserEight) {
  EXPECT_GE(sample_psnr(0.5), 74.5);
  EXPECT_GE(sample_psnr(0.7), 64);
  EXPECT_GE(sample_psnr(0.9), 43.5);
}

} // namespace
} // namespace bccsplat::test

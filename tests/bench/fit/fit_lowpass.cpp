// SPDX-License-Identifier: Apache-2.0
// Compares the windowed spectrum of the sites with that of the source at wave vectors in balls, with and
// without the low-pass, of white noise and of smoke.
#include "tests/bench/fit/fit_lowpass.h"

#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <vector>

#include "tests/bench/fit/fit_source.h"

namespace bccsplat::bench {
namespace {

using Complex = std::complex<double>;

// The mean over points of a tensor grid (x fastest) of value * window * exp(-i pi f p); Hann windows over the
// whole domain, so that ends take no part.
class WindowedSum {
 public:
  WindowedSum(const std::array<uint32_t, 4>& dims, const std::array<double, 4>& f) : dims_(dims), f_(f) {}

  void add(const std::vector<float>& values, const std::array<std::vector<double>, 4>& coordinates) {
    std::array<std::vector<Complex>, 4> factor;
    std::array<double, 4> weight{};
    for (size_t a = 0; a < 4; ++a)
      for (const double p : coordinates[a]) {
        const double w = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * p / (dims_[a] - 1.0));
        factor[a].push_back(std::polar(w, -std::numbers::pi * f_[a] * p));
        weight[a] += w;
      }
    size_t i = 0;
    for (const Complex& t : factor[3])
      for (const Complex& z : factor[2])
        for (const Complex& y : factor[1]) {
          Complex row = 0;
          for (const Complex& x : factor[0]) row += x * static_cast<double>(values[i++]);
          sum_ += row * t * z * y;
        }
    weight_ += weight[0] * weight[1] * weight[2] * weight[3];
  }
  [[nodiscard]] Complex mean() const { return sum_ / weight_; }

 private:
  std::array<uint32_t, 4> dims_;
  std::array<double, 4> f_;
  Complex sum_ = 0;
  double weight_ = 0;
};

// Of the samples on D4* against the source, dB: the spectrum at wave vectors of length up to rho.
double spectrum_snr(const FitSource& s, const Lattice4& lattice, const std::vector<BrickLayer>& layers,
                    const std::vector<std::array<double, 4>>& vectors) {
  std::vector<std::vector<float>> frames, dense;
  for (uint32_t t = 0; t < s.dims[3]; ++t) frames.push_back(s.frame(t));
  for (const BrickLayer& layer : layers) dense.push_back(layer_to_dense(layer));
  double signal = 0, error = 0;
  for (const auto& f : vectors) {
    WindowedSum source(s.dims, f), sites(s.dims, f);
    for (uint32_t t = 0; t < s.dims[3]; ++t) {
      std::array<std::vector<double>, 4> p;
      for (size_t a = 0; a < 3; ++a)
        for (uint32_t i = 0; i < s.dims[a]; ++i) p[a].push_back(i);
      p[3] = {static_cast<double>(t)};
      source.add(frames[t], p);
    }
    for (int32_t m = 0; m < lattice.layers(); ++m) {
      if (lattice.layer_frame(m) > lattice.last_frame()) continue;
      std::array<std::vector<double>, 4> p;
      const int coset = lattice.coset(m);
      for (size_t a = 0; a < 3; ++a)
        for (int32_t i = 0; i < lattice.space.dims(coset)[a]; ++i)
          p[a].push_back(lattice.space.plane(coset, i) * lattice.space_step[a]);
      p[3] = {lattice.layer_frame(m)};
      sites.add(dense[m], p);
    }
    signal += std::norm(source.mean());
    error += std::norm(sites.mean() - source.mean());
  }
  return 10 * std::log10(signal / error);
}

} // namespace

void report_lowpass(const Report& report) {
  const uint32_t n = report.quick ? 16 : 32;
  FitSeries noise{{n, n, n, n}, {}};
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (size_t i = 0; i < size_t{n} * n * n * n; ++i)
    noise.values.push_back(static_cast<float>(normal(random)));
  const FitSource white = source_of<float>(noise, SourceType::f32, 1, "white noise");
  const FitSource smoke = source_of<float>(smoke_like({n, n, n, n}), SourceType::f32, 1, "smoke-like");

  std::vector<Row> rows;
  for (const FitSource* s : {&white, &smoke}) {
    double plain_time = 0;
    for (const bool lowpass : {false, true}) {
      FitOptions options;
      options.lowpass = lowpass;
      std::vector<BrickLayer> layers;
      FitReport made;
      const double time = cpu_seconds([&] {
        layers.clear();
        made = fit_source(*s, options, 1, &layers);
      });
      const auto samples = static_cast<double>(made.channels[0].source_samples);
      if (!lowpass) plain_time = time;
      Row row{word("series", s->name), word("low-pass", lowpass ? "yes" : "no")};
      for (const double rho : {0.5, 0.7, 0.9}) {
        const SeriesWaves waves(rho, report.quick ? 20 : 60, 9);
        std::vector<std::array<double, 4>> f = waves.vector;
        for (auto& v : f)
          for (double& w : v) w /= std::numbers::pi;
        row.push_back(
            figure("SNR dB below rho " + concat(rho), spectrum_snr(*s, made.lattice, layers, f), 1));
      }
      row.push_back(figure("kept % of sites",
                           100 * static_cast<double>(made.channels[0].sites_kept) /
                               static_cast<double>(made.channels[0].sites_total),
                           2));
      row.push_back(figure("CPU ns/sample", 1e9 * time / samples, 1));
      row.push_back(figure("low-pass alone", 1e9 * (time - plain_time) / samples, 1));
      rows.push_back(row);
    }
  }
  report.table("low-pass of the 24-cell: spectrum of the D4* samples against that of the source", rows);
}

} // namespace bccsplat::bench

// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "tests/bench/kernels/kernel_spectrum.h"
#include "tests/bench/kernels/kernels.h"
#include "tests/bench/kernels/kernels_chain.h"
#include "tests/bench/kernels/kernels_periodic.h"

namespace bccsplat::bench {
namespace {

constexpr double tolerance = 1e-5;

struct Input {
  const char* name;
  Values f;
};

std::vector<Input> inputs(const PeriodicLattice& lattice) {
  std::vector<Input> result;
  std::mt19937 random(41);
  std::normal_distribution<float> normal;
  Values noise, site, board;
  for (const size_t c : {size_t{0}, size_t{1}}) {
    for (size_t i = 0; i < lattice.sites(); ++i) noise[c].push_back(normal(random));
    site[c].assign(lattice.sites(), 0);
    board[c].assign(lattice.sites(), c == 0 ? 1.0f : -1.0f);
  }
  site[0][0] = 1;
  result.push_back({"white noise", noise});
  result.push_back({"one site", site});
  result.push_back({"cosets +1, -1", board});
  Values alternating = board; // the other extreme: signs alternate within each coset as well
  for (const size_t c : {size_t{0}, size_t{1}})
    for (size_t i = 0; i < lattice.sites(); ++i) {
      const auto p = lattice.site(i);
      alternating[c][i] = (p[0] + p[1] + p[2] + p[3]) & 1 ? -1.0f : 1.0f;
    }
  result.push_back({"checkerboard in each coset", alternating});
  return result;
}

double rms(const Values& v) {
  double sum = 0;
  for (const auto& coset : v)
    for (const float x : coset) sum += static_cast<double>(x) * x;
  return std::sqrt(sum / static_cast<double>(v[0].size() + v[1].size()));
}
double largest(const Values& v) {
  double most = 0;
  for (const auto& coset : v)
    for (const float x : coset) most = std::max(most, std::abs(static_cast<double>(x)));
  return most;
}
Values minus(Values a, const Values& b) {
  for (const size_t c : {size_t{0}, size_t{1}})
    for (size_t i = 0; i < a[c].size(); ++i) a[c][i] -= b[c][i];
  return a;
}

} // namespace

void run_kernel_interpolation(const Report& report) {
  for (const int dimensions : {3, 4}) {
    const std::string lattice_name = dimensions == 4 ? "D4*" : "BCC";
    const PeriodicLattice lattice{static_cast<size_t>(dimensions),
                                  dimensions == 4 ? (report.quick ? 6 : 8) : 16};
    std::vector<Row> waves, rows;
    for (const char* name : {"radial16+b2", "radial18+b3", "default", "fine", "gauss09"}) {
      const Kernel kernel = make_kernel(name);
      const auto& stages = dimensions == 4 ? kernel.prefilter4 : kernel.prefilter3;
      if (!report.quick) {
        const auto fir = measured_snr(kernel, dimensions), exact = measured_snr(kernel, dimensions, true);
        Row row{word("kernel", name)};
        for (size_t r = 0; r < fir.size(); ++r) {
          row.push_back(figure("stages, rho " + number(table_rhos[r], 1), fir[r], 1));
          row.push_back(figure("interpolating, rho " + number(table_rhos[r], 1), exact[r], 1));
        }
        waves.push_back(row);
      }
      for (const Input& input : inputs(lattice)) {
        const Values c = apply_stages(lattice, stages, input.f);
        const Interpolation exact = interpolate(lattice, kernel, input.f, tolerance);
        const auto miss = [&](const Values& coefficients) {
          return 20 * std::log10(rms(minus(values_at_sites(lattice, kernel, coefficients), input.f)) /
                                 rms(input.f));
        };
        rows.push_back(
            {word("kernel", name), word("samples", input.name),
             figure("residual at the sites dB", miss(c), 1), figure("of CG dB", miss(exact.coefficients), 1),
             figure("CG steps", exact.iterations, 0),
             figure("largest coefficient", largest(c) / largest(input.f), 2),
             figure("largest, interpolating", largest(exact.coefficients) / largest(input.f), 2),
             figure("bound (gain)", dimensions == 4 ? prefilter_gain4(stages) : prefilter_gain3(stages), 1),
             figure("rms of the coefficients", rms(c) / rms(input.f), 2),
             figure("rms, interpolating", rms(exact.coefficients) / rms(input.f), 2)});
      }
    }
    report.table("SNR (dB) of the stages and of exact interpolation, random waves, " + lattice_name, waves);
    report.table("Stages against exact interpolation, " + lattice_name, rows);
  }
}

} // namespace bccsplat::bench

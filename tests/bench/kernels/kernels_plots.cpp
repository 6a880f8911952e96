// SPDX-License-Identifier: Apache-2.0
// Error against frequency and against taps, from the exact mean-square error.
#include <cmath>

#include "tests/bench/kernels/kernel_ripple.h"
#include "tests/bench/kernels/kernels.h"
#include "tests/bench/kernels/kernels_chain.h"

namespace bccsplat::bench {
namespace {

constexpr size_t waves = 500;

struct Reference {
  const char* name;
  CartesianKernel kernel;
  int width;
};
constexpr Reference references[] = {
    {"CC linear", CartesianKernel::linear, 2},
    {"CC Catmull-Rom", CartesianKernel::catmull_rom, 4},
    {"CC cubic B-spline, interpolating", CartesianKernel::cubic_interpolating, 4}};

double snr_of(const Kernel& kernel, const KernelSpectrum& spectrum, int dimensions, double rho) {
  return snr_db(ball_waves(spectrum, dimensions, rho, waves),
                dimensions == 4 ? kernel.prefilter4 : kernel.prefilter3, dimensions);
}

// Grouped by the temporal order, so that the points of a group lie on a line.
void against_taps(const Report& report, int dimensions, double rho) {
  Plot plot{.title = std::string("Error against taps, ") + (dimensions == 4 ? "4D" : "3D") +
                     ", waves of the ball rho " + number(rho, 1),
            .x_label = "taps (sites in the support, mean)",
            .y_label = "signal to error, dB (predicted, shipped prefilters)",
            .log_x = true,
            .series = {}};
  for (const int order : {2, 3, 4}) {
    if (dimensions == 3 && order > 2) break;
    Series s{.title = dimensions == 4 ? "D4*, b" + std::to_string(order) + " in time" : "BCC",
             .points = {},
             .labels = {}};
    for (const char* space : {"radial16", "radial18", "radial20", "radial24"}) {
      const Kernel kernel = make_kernel(std::string(space) + "+b" + std::to_string(order));
      s.points.push_back(
          {mean_taps(kernel, dimensions), snr_of(kernel, KernelSpectrum(kernel), dimensions, rho)});
      s.labels.emplace_back(space);
    }
    plot.series.push_back(s);
  }
  for (const char* name : {"paper", "gauss09"}) {
    const Kernel kernel = make_kernel(name);
    plot.series.push_back(
        {.title = (dimensions == 4 ? "D4* " : "BCC ") + std::string(name),
         .points = {{mean_taps(kernel, dimensions), snr_of(kernel, KernelSpectrum(kernel), dimensions, rho)}},
         .line = false,
         .labels = {}});
  }
  for (const Reference& r : references)
    plot.series.push_back(
        {.title = r.name,
         .points = {{std::pow(r.width, dimensions),
                     snr_db_interpolating(cartesian_waves(r.kernel, dimensions, rho, waves))}},
         .line = false,
         .labels = {}});
  report.plot("error-taps-" + std::to_string(dimensions) + "d", plot);
}

void against_frequency(const Report& report, int dimensions) {
  Plot plot{.title = std::string("Error against frequency, ") +
                     (dimensions == 4 ? "D4* and CC, 4D" : "BCC and CC, 3D"),
            .x_label = "rho: waves uniform in the ball of this fraction of the Nyquist frequency of CC",
            .y_label = "signal to error, dB (predicted, shipped prefilters)",
            .series = {}};
  const std::vector<std::string> names =
      dimensions == 4
          ? std::vector<std::string>{"paper",       "fast", "radial18+b3", "default",
                                     "radial24+b3", "fine", "gauss09"}
          : std::vector<std::string>{"paper", "fast", "radial18+b3", "default", "fine", "gauss09"};
  const auto rho_of = [](int i) { return 0.1 * i; };
  for (const std::string& name : names) {
    const Kernel kernel = make_kernel(name);
    const KernelSpectrum spectrum(kernel);
    Series s{.title = (dimensions == 4 ? "D4* " : "BCC ") +
                      (dimensions == 4 ? name : kernel.name.substr(0, kernel.name.find('+'))),
             .points = {},
             .labels = {}};
    for (int i = 1; i <= 10; ++i)
      s.points.push_back({rho_of(i), snr_of(kernel, spectrum, dimensions, rho_of(i))});
    plot.series.push_back(s);
  }
  for (const Reference& r : references) {
    Series s{.title = r.name, .points = {}, .labels = {}};
    for (int i = 2; i <= 10; ++i)
      s.points.push_back(
          {rho_of(i), snr_db_interpolating(cartesian_waves(r.kernel, dimensions, rho_of(i), waves))});
    plot.series.push_back(s);
  }
  report.plot("error-frequency-" + std::to_string(dimensions) + "d", plot);
}

} // namespace

void plot_kernels(const Report& report) {
  if (report.plots.empty()) return;
  for (const int dimensions : {3, 4}) {
    against_frequency(report, dimensions);
    against_taps(report, dimensions, 0.7);
  }
}

} // namespace bccsplat::bench

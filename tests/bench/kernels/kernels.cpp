// SPDX-License-Identifier: Apache-2.0
// Reads the options of the suite and makes the predicted tables. The others have files of their own
// (kernels_chain.h).
#include "tests/bench/kernels/kernels.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>

#include "base/error.h"
#include "tests/bench/kernels/kernel_ripple.h"
#include "tests/bench/kernels/kernels_chain.h"
#include "tests/bench/report.h"

namespace bccsplat::bench {
namespace {

constexpr size_t waves_per_ball = 4000;

// Kernels of the tables in the order of their cost; 3D tables list one temporal order only.
std::vector<std::string> listed_kernels(int dimensions) {
  std::vector<std::string> names{"paper"};
  for (const char* space : {"radial16", "radial18", "radial20", "radial24"})
    for (const char* time : {"+b2", "+b3", "+b4"})
      if (dimensions == 4 || time == std::string("+b2")) names.push_back(std::string(space) + time);
  names.push_back("gauss09");
  return names;
}

std::string label(const std::string& kernel, int dimensions) {
  return dimensions == 3 ? kernel.substr(0, kernel.find('+')) : kernel;
}

void add_snr(Row& row, const std::array<double, 4>& snr) {
  for (size_t r = 0; r < snr.size(); ++r) row.push_back(figure("rho " + number(table_rhos[r], 1), snr[r], 1));
}

std::vector<Row> predicted(int dimensions, size_t count) {
  std::vector<Row> rows;
  const std::string dash = "-";
  const auto finish = [&](Row& row) {
    for (const char* name :
         {"ripple dB", "gain", "noise", "largest Q", "at sites", "min symbol", "stages", "reach"})
      row.push_back(word(name, dash));
    rows.push_back(row);
  };
  const auto cartesian = [&](const char* name, const char* prefilter, CartesianKernel kernel, int width) {
    std::array<double, 4> snr{};
    for (size_t r = 0; r < snr.size(); ++r)
      snr[r] = snr_db_interpolating(cartesian_waves(kernel, dimensions, table_rhos[r], count));
    Row row{word("kernel", name), word("prefilter", prefilter),
            figure("taps", std::pow(width, dimensions), 0)};
    add_snr(row, snr);
    finish(row);
  };
  cartesian("CC linear", "none", CartesianKernel::linear, 2);
  cartesian("CC Catmull-Rom", "none", CartesianKernel::catmull_rom, 4);
  cartesian("CC cubic B-spline", "interpolating", CartesianKernel::cubic_interpolating, 4);

  for (const std::string& name : listed_kernels(dimensions)) {
    const Kernel kernel = make_kernel(name);
    const KernelSpectrum spectrum(kernel);
    const std::vector<PrefilterStage>& stages = dimensions == 4 ? kernel.prefilter4 : kernel.prefilter3;
    std::array<double, 4> ideal{}, best{}, shipped{};
    for (size_t r = 0; r < ideal.size(); ++r) {
      const std::vector<WaveSample> waves = ball_waves(spectrum, dimensions, table_rhos[r], count);
      ideal[r] = snr_db_interpolating(waves);
      shipped[r] = snr_db(waves, stages, dimensions);
      double sum = 0;
      for (const WaveSample& w : waves) sum += wave_error(w, w.pass / (w.pass * w.pass + w.alias2));
      best[r] = -10 * std::log10(sum / static_cast<double>(waves.size()));
    }
    double largest = 0, lowest = 1e9, highest = 0, symbol = 1e9;
    for (const WaveSample& w : all_waves(spectrum, dimensions, 8000)) {
      const double q = prefilter_symbol(stages, w.means, dimensions == 4 ? 16 : 8);
      largest = std::max(largest, std::abs(q));
      lowest = std::min(lowest, q * w.symbol), highest = std::max(highest, q * w.symbol);
      symbol = std::min(symbol, w.symbol);
    }
    const auto head = [&](const char* prefilter) {
      return Row{word("kernel", label(name, dimensions)), word("prefilter", prefilter),
                 figure("taps", mean_taps(kernel, dimensions), 0)};
    };
    if (!kernel.normalised) {
      Row row = head("interpolating");
      add_snr(row, ideal);
      finish(row);
      row = head("best");
      add_snr(row, best);
      finish(row);
    }
    Row row = head(stages.empty() ? "none" : "shipped");
    add_snr(row, shipped);
    row.push_back(figure("ripple dB", dc_ripple_db(kernel, dimensions), 0));
    row.push_back(figure("gain", dimensions == 4 ? prefilter_gain4(stages) : prefilter_gain3(stages), 1));
    row.push_back(figure("noise", noise_gain(kernel, dimensions), 2));
    row.push_back(figure("largest Q", largest, 1));
    row.push_back(word("at sites", number(lowest, 2) + " .. " + number(highest, 2)));
    row.push_back(figure("min symbol", symbol, 4));
    row.push_back(figure("stages", static_cast<double>(stages.size()), 0));
    const Reach reach = prefilter_reach(stages);
    row.push_back(figure("reach", dimensions == 4 ? reach.time : reach.space, 0));
    rows.push_back(row);
  }
  return rows;
}

// Of the analytic gradient in space. "best": the prefilter that is best for the gradient, of any reach: what
// is missing there the shape of phi loses.
std::vector<Row> gradients(int dimensions, size_t count) {
  std::vector<Row> rows;
  for (const std::string& name : listed_kernels(dimensions)) {
    const Kernel kernel = make_kernel(name);
    const KernelSpectrum spectrum(kernel);
    std::array<double, 4> snr{}, best{};
    for (size_t r = 0; r < snr.size(); ++r) {
      const std::vector<WaveSample> waves = ball_waves(spectrum, dimensions, table_rhos[r], count);
      snr[r] = gradient_snr_db(waves, dimensions == 4 ? kernel.prefilter4 : kernel.prefilter3, dimensions);
      double signal = 0, error = 0;
      for (const WaveSample& w : waves) {
        const double total = w.space2 * w.pass * w.pass + w.alias_gradient2;
        signal += w.space2, error += wave_gradient_error(w, w.space2 * w.pass / total);
      }
      best[r] = 10 * std::log10(signal / error);
    }
    Row row{word("kernel", label(name, dimensions))};
    add_snr(row, snr);
    for (size_t r = 0; r < best.size(); ++r)
      row.push_back(figure("best " + number(table_rhos[r], 1), best[r], 1));
    rows.push_back(row);
  }
  return rows;
}

std::vector<Row> measured(int dimensions, bool quick) {
  std::vector<Row> rows;
  for (const char* name : {"default", "paper", "fast", "radial18+b3", "fine", "gauss09"}) {
    if (quick && !rows.empty()) break;
    Row row{word("kernel", dimensions == 3 ? label(make_kernel(name).name, 3) : make_kernel(name).name)};
    add_snr(row, measured_snr(make_kernel(name), dimensions));
    rows.push_back(row);
  }
  return rows;
}

void run_predicted(const Report& report) {
  const size_t waves = report.quick ? 200 : waves_per_ball;
  for (const int dimensions : {3, 4}) {
    const std::string lattice = dimensions == 3 ? "BCC" : "D4*";
    report.table("Predicted SNR (dB), " + lattice, predicted(dimensions, waves));
    report.table("Predicted SNR of the gradient (dB), " + lattice, gradients(dimensions, waves));
  }
  plot_kernels(report);
}

void run_measured(const Report& report) {
  for (const int dimensions : {3, 4})
    report.table(std::string("Measured SNR (dB), ") + (dimensions == 3 ? "BCC" : "D4*"),
                 measured(dimensions, report.quick));
}

struct Part {
  std::string_view option;
  void (*run)(const Report& report);
};
constexpr Part parts[] = {{"--predicted", run_predicted},
                          {"--measured", run_measured},
                          {"--chain", run_kernel_chain},
                          {"--marschner", run_marschner_lobb},
                          {"--gradients", run_kernel_gradients},
                          {"--constants", run_kernel_constants},
                          {"--interpolation", run_kernel_interpolation},
                          {"--paper", run_paper_kernel}};

} // namespace

int run_kernels_suite(std::span<const std::string> args, const Report& report) {
  for (const std::string& arg : args)
    if (std::none_of(std::begin(parts), std::end(parts), [&](const Part& p) { return p.option == arg; })) {
      std::string known;
      for (const Part& p : parts) known += std::string(p.option) + ' ';
      fail(Code::invalid_argument, "kernels: unknown option '", arg, "'; known: ", known);
    }
  for (const Part& part : parts)
    if (args.empty() || std::find(args.begin(), args.end(), part.option) != args.end()) part.run(report);
  return 0;
}

} // namespace bccsplat::bench

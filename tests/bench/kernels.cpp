#include "tests/bench/kernels.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>

#include "base/error.h"
#include "tests/bench/kernel_design.h"
#include "tests/bench/kernel_design_cc.h"
#include "tests/bench/kernel_design_shape.h"
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

// Sites in the support, in the mean.
double taps(const Kernel& kernel, int dimensions) {
  const double ball = 4 * std::numbers::pi / 3 * std::pow(kernel.space.radius, 3);
  return dimensions == 3 ? ball / std::numbers::sqrt2 : ball * 2 * kernel.time.half_width / 2;
}

// Largest deviation from 1 of a reconstructed constant, in dB. A B-spline adds none of its own.
double dc_ripple_db(const Kernel& kernel, int dimensions) {
  constexpr int n = 12; // positions per axis of an eighth of the cell of a coset
  constexpr double pitch = std::numbers::sqrt2;
  const bool layers = dimensions == 4 && kernel.time.shape == TemporalKernel::Shape::gaussian;
  double worst = 0;
  for (int t = 0; t <= (layers ? n : 0); ++t) {
    std::array<double, 2> by_coset{1, 1};
    if (layers)
      for (const int coset : {0, 1}) {
        double sum = 0;
        for (int k = -4; k <= 4; ++k) sum += kernel.time.value((k + 0.5 * coset - 0.5 * t / n) * pitch);
        by_coset[static_cast<size_t>(coset)] = sum;
      }
    for (int i = 0; i <= n; ++i)
      for (int j = 0; j <= i; ++j)
        for (int k = 0; k <= j; ++k) {
          double sum = 0;
          for (const int coset : {0, 1})
            for (int a = -3; a <= 4; ++a)
              for (int b = -3; b <= 4; ++b)
                for (int c = -3; c <= 4; ++c) {
                  const double x = (a + 0.5 * coset - 0.5 * i / n) * pitch;
                  const double y = (b + 0.5 * coset - 0.5 * j / n) * pitch;
                  const double z = (c + 0.5 * coset - 0.5 * k / n) * pitch;
                  sum += by_coset[static_cast<size_t>(coset)] * kernel.space.value(x * x + y * y + z * z);
                }
          worst = std::max(worst, std::abs(sum - 1));
        }
  }
  return 20 * std::log10(worst);
}

void add_snr(Row& row, const std::array<double, 4>& snr) {
  for (size_t r = 0; r < snr.size(); ++r)
    row.push_back(figure("rho " + number(design_rhos[r], 1), snr[r], 1));
}

std::vector<Row> predicted(int dimensions) {
  std::vector<Row> rows;
  const std::string dash = "-";
  const auto finish = [&](Row& row) {
    for (const char* name :
         {"ripple dB", "gain", "largest Q", "at sites", "min symbol", "stages", "reach", "rounding"})
      row.push_back(word(name, dash));
    rows.push_back(row);
  };
  const auto cartesian = [&](const char* name, const char* prefilter, CartesianKernel kernel, int width) {
    std::array<double, 4> snr{};
    for (size_t r = 0; r < snr.size(); ++r)
      snr[r] = snr_db_interpolating(cartesian_waves(kernel, dimensions, design_rhos[r], waves_per_ball));
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
      const std::vector<WaveSample> waves = ball_waves(spectrum, dimensions, design_rhos[r], waves_per_ball);
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
                 figure("taps", taps(kernel, dimensions), 0)};
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
    row.push_back(figure("largest Q", largest, 1));
    row.push_back(word("at sites", number(lowest, 2) + " .. " + number(highest, 2)));
    row.push_back(figure("min symbol", symbol, 4));
    row.push_back(figure("stages", static_cast<double>(stages.size()), 0));
    const Reach reach = prefilter_reach(stages);
    row.push_back(figure("reach", dimensions == 4 ? reach.time : reach.space, 0));
    row.push_back(figure("rounding", stages.empty() ? 0 : rounding_growth(stages, dimensions), 1));
    rows.push_back(row);
  }
  return rows;
}

// Of the analytic gradient in space.
std::vector<Row> gradients(int dimensions) {
  std::vector<Row> rows;
  for (const std::string& name : listed_kernels(dimensions)) {
    const Kernel kernel = make_kernel(name);
    const KernelSpectrum spectrum(kernel);
    std::array<double, 4> snr{};
    for (size_t r = 0; r < snr.size(); ++r)
      snr[r] = gradient_snr_db(ball_waves(spectrum, dimensions, design_rhos[r], waves_per_ball),
                               dimensions == 4 ? kernel.prefilter4 : kernel.prefilter3, dimensions);
    Row row{word("kernel", label(name, dimensions))};
    add_snr(row, snr);
    rows.push_back(row);
  }
  return rows;
}

std::vector<Row> measured(int dimensions) {
  std::vector<Row> rows;
  for (const char* name : {"paper", "fast", "radial18+b3", "default", "fine", "gauss09"}) {
    Row row{word("kernel", dimensions == 3 ? label(make_kernel(name).name, 3) : make_kernel(name).name)};
    add_snr(row, measured_snr(make_kernel(name), dimensions));
    rows.push_back(row);
  }
  return rows;
}

// A constant array as it stands in prefilter_tables.inc.
void print_stages(std::ostream& out, const std::string& name, const std::vector<PrefilterStage>& stages) {
  out << "constexpr PrefilterStage " << name << "[] = {\n";
  for (const PrefilterStage& s : stages) {
    const std::array<double, 9> w{s.self,   s.spatial,        s.temporal,        s.mixed,       s.cross,
                                  s.source, s.source_spatial, s.source_temporal, s.source_mixed};
    out << "    {";
    const size_t count = s.uses_source() ? 9 : 5;
    for (size_t i = 0; i < count; ++i) {
      char text[32];
      std::snprintf(text, sizeof text, "%.9g", w[i] + 0.0);
      out << (i == 0 ? "" : i == 5 ? ",\n     " : ", ") << text;
    }
    out << "},\n";
  }
  out << "};\n";
}

std::string identifier(std::string name) {
  std::replace(name.begin(), name.end(), '+', '_');
  return name;
}

void design(std::ostream& out, const std::string& which) {
  std::vector<std::string> names;
  if (which == "all") {
    names = listed_kernels(4);
    names.erase(names.begin()); // the paper's has none
  } else {
    names = {make_kernel(which).name};
  }
  std::map<std::string, Design> of_space; // 3D stages do not depend on the temporal kernel
  std::string entries;
  for (const std::string& name : names) {
    const Kernel kernel = make_kernel(name);
    const std::string space = label(name, 3);
    if (!of_space.contains(space)) {
      of_space[space] = design_prefilter(kernel, shipped_goal(name, 3));
      print_stages(out, identifier(space) + "_bcc", of_space[space].stages);
    }
    const Design on_d4star = design_prefilter(kernel, shipped_goal(name, 4));
    print_stages(out, identifier(name) + "_d4star", on_d4star.stages);
    const double gain = std::max(prefilter_gain4(on_d4star.stages), prefilter_gain3(of_space[space].stages));
    entries += "    {\"" + name + "\", " + identifier(name) + "_d4star, " + identifier(space) + "_bcc, " +
               number(gain + 0.005, 2) + "},\n";
    out.flush();
  }
  out << "constexpr Entry entries[] = {\n" << entries << "};\n";
}

// One prefilter with stages of another pattern, and its figures.
void compare(std::ostream& out, const std::string& name, const std::string& pattern, int dimensions) {
  const Kernel kernel = make_kernel(name);
  DesignGoal goal = shipped_goal(kernel.name, dimensions);
  goal.pattern = pattern;
  const Design found = design_prefilter(kernel, goal);
  print_stages(out, identifier(kernel.name) + "_" + pattern, found.stages);
  const KernelSpectrum spectrum(kernel);
  out << "// dB:";
  for (const double rho : design_rhos)
    out << ' '
        << number(snr_db(ball_waves(spectrum, dimensions, rho, waves_per_ball), found.stages, dimensions), 1);
  const Reach reach = prefilter_reach(found.stages);
  out << "; reach " << (dimensions == 4 ? reach.time : reach.space) << "; gain "
      << number(dimensions == 4 ? prefilter_gain4(found.stages) : prefilter_gain3(found.stages), 1) << "\n";
}

void shape(std::ostream& out, const std::string& which) {
  const std::vector<std::string> names =
      which == "all" ? std::vector<std::string>{"radial16", "radial18", "radial20", "radial24"}
                     : std::vector{which};
  for (const std::string& name : names) {
    const ShapeGoal goal = shipped_shape_goal(name);
    const Shape found = design_shape(goal);
    char text[160];
    const auto& a = found.phi.a;
    std::snprintf(text, sizeof text, "{%.9g, %.9g, %.9g, %.9g, %.9g, %.9g}", a[2], a[3], a[4], a[5], a[6],
                  a[7]);
    out << "    {\"" << name << "\", " << number(goal.radius, 1) << ", " << text
        << "},\n    // dB, BCC then D4*:";
    for (const double db : found.figures) out << ' ' << number(db, 2);
    out << "; to beat:";
    for (const double db : goal.beat) out << ' ' << number(db, 2);
    out << "\n" << std::flush;
  }
}

} // namespace

int run_kernels_suite(std::span<const std::string> args, const Report& report) {
  std::ostream& out = report.out;
  bool want_predicted = false, want_measured = false;
  for (size_t i = 0; i < args.size(); ++i) {
    const std::string& arg = args[i];
    if (arg == "--predicted") {
      want_predicted = true;
    } else if (arg == "--measured") {
      want_measured = true;
    } else if (arg == "--compare") {
      const bool flat = args.size() == 4 && args[3] == "3";
      if (i != 0 || (args.size() != 3 && !flat))
        fail(Code::invalid_argument, "kernels --compare takes a kernel, a pattern of stages and perhaps 3");
      compare(out, args[1], args[2], flat ? 3 : 4);
      return 0;
    } else if (arg == "--design-cc" && args.size() == 1) {
      print_cc_designs(out);
      return 0;
    } else if (arg == "--design" || arg == "--shape") {
      if (i != 0 || args.size() != 2)
        fail(Code::invalid_argument, "kernels ", arg, " takes one name, or all, and no other option");
      arg == "--design" ? design(out, args[1]) : shape(out, args[1]);
      return 0;
    } else {
      fail(Code::invalid_argument, "kernels: unknown option '", arg,
           "'; known: --predicted --measured --design NAME --design-cc --shape NAME --compare NAME "
           "PATTERN");
    }
  }
  if (!want_predicted && !want_measured) want_predicted = want_measured = true;
  for (const int dimensions : {3, 4}) {
    const std::string lattice = dimensions == 3 ? "BCC" : "D4*";
    if (want_predicted) report.table("Predicted SNR (dB), " + lattice, predicted(dimensions));
    if (want_predicted) report.table("Predicted SNR of the gradient (dB), " + lattice, gradients(dimensions));
    if (want_measured) report.table("Measured SNR (dB), " + lattice, measured(dimensions));
  }
  return 0;
}

} // namespace bccsplat::bench

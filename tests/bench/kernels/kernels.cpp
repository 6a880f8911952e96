// SPDX-License-Identifier: Apache-2.0
// Reads the options of the suite, makes the predicted tables, and runs the designs of prefilters, bends and
// shapes, printing what src/kernel holds of them. The other tables have files of their own (kernels_chain.h).
#include "tests/bench/kernels/kernels.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>

#include "base/error.h"
#include "tests/bench/kernels/kernel_design.h"
#include "tests/bench/kernels/kernel_design_bend.h"
#include "tests/bench/kernels/kernel_design_cc.h"
#include "tests/bench/kernels/kernel_design_shape.h"
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
  for (size_t r = 0; r < snr.size(); ++r)
    row.push_back(figure("rho " + number(design_rhos[r], 1), snr[r], 1));
}

std::vector<Row> predicted(int dimensions, size_t count) {
  std::vector<Row> rows;
  const std::string dash = "-";
  const auto finish = [&](Row& row) {
    for (const char* name :
         {"ripple dB", "gain", "noise", "largest Q", "at sites", "min symbol", "stages", "reach", "rounding"})
      row.push_back(word(name, dash));
    rows.push_back(row);
  };
  const auto cartesian = [&](const char* name, const char* prefilter, CartesianKernel kernel, int width) {
    std::array<double, 4> snr{};
    for (size_t r = 0; r < snr.size(); ++r)
      snr[r] = snr_db_interpolating(cartesian_waves(kernel, dimensions, design_rhos[r], count));
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
      const std::vector<WaveSample> waves = ball_waves(spectrum, dimensions, design_rhos[r], count);
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
    row.push_back(figure("rounding", stages.empty() ? 0 : rounding_growth(stages, dimensions), 1));
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
      const std::vector<WaveSample> waves = ball_waves(spectrum, dimensions, design_rhos[r], count);
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
      row.push_back(figure("best " + number(design_rhos[r], 1), best[r], 1));
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

// A constant array as prefilter_tables.inc holds it.
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

std::string range_db(const std::vector<double>& errors) {
  const auto [low, high] = std::minmax_element(errors.begin(), errors.end());
  return number(-10 * std::log10(*high), 2) + " .. " + number(-10 * std::log10(*low), 2);
}

// The bends of splines in time, and what they make of the phases of time slices.
void bend(const Report& report, const std::string& which) {
  std::vector<std::string> names;
  if (which != "all") names = {make_kernel(which).name};
  for (const std::string& name : listed_kernels(4))
    if (which == "all" && name.find('+') != std::string::npos) names.push_back(name);
  std::vector<Row> rows;
  for (const std::string& name : names) {
    Kernel kernel = make_kernel(name);
    if (kernel.time.shape != TemporalKernel::Shape::bspline)
      fail(Code::invalid_argument, "kernels --bend: ", name, " is no spline in time");
    const std::array<double, 2> shipped = kernel.time.bend;
    const auto add = [&](const std::string& what, const std::array<double, 2>& bends) {
      kernel.time.bend = bends;
      char text[64];
      std::snprintf(text, sizeof text, "%.6f, %.6f", bends[0], bends[1]);
      Row row{word("kernel", name), word("spline", what), word("bends", text)};
      for (const double rho : design_rhos)
        row.push_back(word("rho " + number(rho, 1),
                           range_db(phase_errors(kernel, rho, 17, report.quick ? 200 : 2000))));
      rows.push_back(row);
    };
    add("straight", {});
    add("shipped", shipped);
    add("bent", design_bend(kernel));
  }
  report.table("SNR (dB) of time slices, lowest .. highest of all phases of the instant", rows);
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

// What a shape gains in the gradient when its values may lose up to a number of dB, or in constants.
class ShapeTable {
 public:
  explicit ShapeTable(const std::string& name)
      : goal(shipped_shape_goal(name)),
        shipped(measure_shape(goal, make_kernel(name + "+b" + std::to_string(goal.time_order)).space)) {
    add(name + ", shipped", shipped);
  }
  void add(const std::string& what, const Shape& s) {
    Row row{word("shape", what)};
    for (size_t r = 0; r < design_rhos.size(); ++r)
      row.push_back(figure("value " + number(design_rhos[r], 1), s.figures[5 + r], 1));
    for (size_t r = 0; r < design_rhos.size(); ++r)
      row.push_back(figure("gradient " + number(design_rhos[r], 1), s.gradient[r], 1));
    row.push_back(figure("constant", s.figures[4], 1));
    row.push_back(figure("largest ripple %", 100 * s.ripple, 4));
    std::string a;
    for (size_t j = 2; j < 8; ++j) a += concat(j == 2 ? "" : " ", s.phi.a[j]);
    row.push_back(word("a_2 .. a_7", a));
    rows.push_back(row);
  }

  ShapeGoal goal;
  Shape shipped;
  std::vector<Row> rows;
};

void shape_for_gradient(const Report& report, const std::string& name, const std::vector<double>& losses) {
  ShapeTable table(name);
  for (const double loss : losses) {
    ShapeGoal goal = table.goal;
    goal.for_gradient = true;
    goal.gradient_beat = table.shipped.gradient;
    goal.beat = table.shipped.figures;
    for (double& db : goal.beat) db -= loss;
    table.add("up to " + number(loss, 1) + " dB given up", design_shape(goal));
  }
  report.table("Shapes designed for the gradient, best prefilters (dB), D4*: " + name, table.rows);
}

void shape_for_constants(const Report& report, const std::string& name, const std::vector<double>& ripples) {
  ShapeTable table(name);
  for (const double ripple : ripples) {
    ShapeGoal goal = table.goal;
    goal.beat = table.shipped.figures;
    goal.ripple = ripple;
    table.add("a constant within " + number(100 * ripple, 3) + " %", design_shape(goal));
  }
  report.table("Shapes designed for constants, best prefilters (dB), D4*: " + name, table.rows);
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
  std::ostream& out = report.out;
  const std::string_view first = args.empty() ? std::string_view() : args[0];
  if (first == "--compare") {
    if (args.size() != 3 && !(args.size() == 4 && args[3] == "3"))
      fail(Code::invalid_argument, "kernels --compare takes a kernel, a pattern of stages and perhaps 3");
    compare(out, args[1], args[2], args.size() == 4 ? 3 : 4);
    return 0;
  }
  if (first == "--design-cc" && args.size() == 1) {
    print_cc_designs(out);
    return 0;
  }
  if (first == "--design" || first == "--shape") {
    if (args.size() != 2) fail(Code::invalid_argument, "kernels ", first, " takes one name, or all");
    first == "--design" ? design(out, args[1]) : shape(out, args[1]);
    return 0;
  }
  if (first == "--bend") {
    if (args.size() != 2) fail(Code::invalid_argument, "kernels --bend takes one name, or all");
    bend(report, args[1]);
    return 0;
  }
  if (first == "--shape-constant") {
    if (args.size() != 2) fail(Code::invalid_argument, "kernels --shape-constant takes one name");
    shape_for_constants(report, args[1], {1e-3, 3e-4, 1e-4});
    return 0;
  }
  if (first == "--shape-gradient") {
    if (args.size() != 2) fail(Code::invalid_argument, "kernels --shape-gradient takes one name");
    shape_for_gradient(report, args[1], {0.3, 1, 2});
    return 0;
  }
  for (const std::string& arg : args)
    if (std::none_of(std::begin(parts), std::end(parts), [&](const Part& p) { return p.option == arg; })) {
      std::string known;
      for (const Part& p : parts) known += std::string(p.option) + ' ';
      fail(Code::invalid_argument, "kernels: unknown option '", arg, "'; known: ", known,
           "or alone: --design NAME --design-cc --bend NAME --shape NAME --shape-gradient NAME "
           "--shape-constant "
           "NAME --compare "
           "NAME PATTERN");
    }
  for (const Part& part : parts)
    if (args.empty() || std::find(args.begin(), args.end(), part.option) != args.end()) part.run(report);
  return 0;
}

} // namespace bccsplat::bench

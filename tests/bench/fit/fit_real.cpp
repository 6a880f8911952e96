// SPDX-License-Identifier: Apache-2.0
// Writes each set as raw samples, runs the tool on it and reads its JSON; gzip, zfp and every second frame
// stand beside it. Where the tool is not built there is only an error.
#include "tests/bench/fit/fit_real.h"

#include <zlib.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>

#include "base/error.h"
#include "base/text.h"
#include "tests/bench/fit/fit_rate.h"
#include "tests/bench/fit/fit_source.h"
#include "tests/bench/fit/tool_import.h"
#include "tests/bench/fit/zfp_size.h"
#include "tests/bench/paper/paper.h"

#ifdef BCCSPLAT_BENCH_HAS_TOOL
#include <nlohmann/json.hpp>
#endif

namespace bccsplat::bench {

#ifndef BCCSPLAT_BENCH_HAS_TOOL

void report_real(const std::string&, const Report&) {
  fail(Code::unsupported,
       "fit --real runs bcc4, which is not built here: configure with -DBCCSPLAT_BUILD_TOOL=ON");
}

#else

namespace {

struct RealSet {
  FitSource source;
  bool smooth = false; // band-limited: at most 0.8 of zfp's bytes
};

// Waves of an ellipsoid: radius rho of the Nyquist frequency along each axis.
FitSource ellipsoid(const std::string& name, const std::array<uint32_t, 4>& dims,
                    const std::array<double, 4>& rho) {
  constexpr int waves = 60;
  SeriesWaves field(1, waves, 5);
  for (auto& v : field.vector)
    for (size_t a = 0; a < 4; ++a) v[a] *= rho[a];
  std::array<std::vector<double>, 4> grid;
  for (size_t a = 0; a < 4; ++a)
    for (uint32_t i = 0; i < dims[a]; ++i) grid[a].push_back(i);
  FitSeries s{dims, {}};
  for (const double v : field.on_grid(grid)) s.values.push_back(static_cast<float>(v));
  return source_of<float>(s, SourceType::f32, 1, name);
}

std::vector<RealSet> all_sets(const std::string& folder, bool quick) {
  std::vector<RealSet> sets;
  for (const PaperSet& set : real_series())
    if (auto source = load_paper_set(set, folder)) sets.push_back({std::move(*source), false});
  const uint32_t n = quick ? 24 : 48;
  sets.push_back({ellipsoid("ball .5", {n, n, n, n}, {.5, .5, .5, .5}), true});
  sets.push_back({ellipsoid("slow", {n, n, n / 2, n / 2}, {.7, .7, .7, .15}), true});
  sets.push_back({ellipsoid("fast", {n, n, n, n / 2}, {.25, .25, .25, .8}), true});
  sets.push_back({ellipsoid("slices", {n, n, n / 2, n / 2}, {.35, .35, .8, .4}), true});
  return sets;
}

// One run of the tool.
struct Imported {
  double psnr = 0, predicted = 0; // dB
  double bytes = 0, sites = 0;    // per source sample
  double lattice_psnr = 0;
  std::string lattice;
};

std::string distances(const nlohmann::json& coding) {
  std::string text = coding.at("lattice").get<std::string>();
  for (const auto& d : coding.at("distances")) text += " " + number(d.get<double>(), 2);
  return text;
}

Imported import(const ToolImport& tool, const std::string& options) {
  const auto j = nlohmann::json::parse(tool.run(options), nullptr, false);
  if (j.is_discarded()) fail(Code::io_error, "no report of bcc4 import ", options);
  Imported out;
  const auto& error = j.at("error").at("channels").at(0);
  out.psnr = error.at("psnr").is_null() ? HUGE_VAL : error.at("psnr").get<double>();
  out.bytes = j.at("bytes").at("file").get<double>();
  out.sites = (j.at("sites_total").get<double>() + j.at("sites_outside").get<double>()) /
              j.at("cc_samples").get<double>();
  const auto& plan = j.at("plan");
  if (plan.contains("wavelets")) {
    out.lattice = "wavelets", out.predicted = NAN;
    return out;
  }
  const auto& chosen =
      plan.contains("choice") ? plan.at("choice").at("rounded") : plan.at("coding").at("chosen");
  out.predicted = 20 * std::log10(error.at("peak").get<double>() / chosen.at("rmse").at(0).get<double>());
  out.lattice = distances(chosen);
  return out;
}

double gzip_bytes(const FitSource& s) {
  uLongf size = compressBound(static_cast<uLong>(s.bytes.size()));
  std::vector<Bytef> out(size);
  compress2(out.data(), &size, reinterpret_cast<const Bytef*>(s.bytes.data()),
            static_cast<uLong>(s.bytes.size()), 6);
  return static_cast<double>(size);
}

std::string kib(double bytes) { return number(bytes / 1024, 1); }

// Ways to keep about half of the samples, rounded alike.
void add_equal_samples(std::vector<Row>& rows, const RealSet& set, const ToolImport& tool) {
  const Imported chosen = import(tool, "--density .5");
  double best = 0;
  const auto row = [&](const std::string& way, double psnr, double bytes, double sites,
                       const std::string& lattice, double predicted) {
    rows.push_back({word("series", set.source.name), word("kept", way), word("lattice", lattice),
                    figure("sites / samples", sites, 3), figure("PSNR dB", psnr, 2),
                    std::isfinite(predicted) ? figure("prediction off by", predicted - psnr, 2)
                                             : word("prediction off by", "-"),
                    word("KiB", kib(bytes)), figure("dB behind the best", 0, 2)});
  };
  const size_t first = rows.size();
  const auto add = [&](const std::string& way, const Imported& i) {
    row(way, i.psnr, i.bytes, i.sites, i.lattice, i.predicted);
  };
  add("as chosen", chosen);
  add("D4*, fitted", import(tool, "--lattice d4star --density .5"));
  add("D4*, cubic", import(tool, "--lattice d4star"));
  add("CC, fitted", import(tool, "--lattice cc --density .5"));
  for (const bool cubic : {false, true}) {
    const RatePoint half = through_half_the_frames(set.source, 0, cubic);
    row(cubic ? "every 2nd frame, Catmull-Rom" : "every 2nd frame, linear", half.psnr,
        static_cast<double>(half.bytes),
        static_cast<double>((set.source.dims[3] + 1) / 2) / set.source.dims[3], "-", NAN);
  }
  const auto psnr_of = [](const Row& r) { return std::strtod(r[4].text.c_str(), nullptr); };
  for (size_t i = first; i < rows.size(); ++i) best = std::max(best, psnr_of(rows[i]));
  for (size_t i = first; i < rows.size(); ++i)
    rows[i].back() = figure("dB behind the best", best - psnr_of(rows[i]), 2);
}

void add_equal_errors(std::vector<Row>& rows, const RealSet& set, const ToolImport& tool) {
  const double gzip = gzip_bytes(set.source);
  for (const double goal : {0.0, 45.0, 50.0, 60.0}) { // 0: whatever an import promises
    const Imported i = import(tool, goal > 0 ? concat("--psnr ", goal) : "");
    const std::string bound = concat("--psnr ", goal > 0 ? goal : i.psnr);
    const Imported d4 = import(tool, bound + " --lattice d4star"), cc = import(tool, bound + " --lattice cc");
    const auto zfp = zfp_bytes(set.source, i.psnr);
    rows.push_back({word("series", set.source.name), figure("asked dB", goal, 0),
                    figure("reached", i.psnr, 2), word("lattice", i.lattice), word("KiB", kib(i.bytes)),
                    word("D4* alone", kib(d4.bytes)), word("CC alone", kib(cc.bytes)),
                    word("zfp 4D KiB", zfp ? kib(*zfp) : "-"),
                    zfp ? figure("of zfp", i.bytes / *zfp, 2) : word("of zfp", "-"),
                    figure("to be", set.smooth ? .8 : 1.05, 2), figure("of gzip", i.bytes / gzip, 2)});
  }
}

} // namespace

void report_real(const std::string& folder, const Report& report) {
#ifndef BCCSPLAT_BENCH_ZFP
  std::fprintf(stderr,
               "fit --real: *** no zfp in this build: nothing is compared with it (libzfp-dev) ***\n");
#endif
  std::vector<Row> samples, errors;
  for (const RealSet& set : all_sets(folder, report.quick)) {
    const ToolImport tool(set.source);
    add_equal_samples(samples, set, tool);
    add_equal_errors(errors, set, tool);
  }
  report.table("half of the samples: what comes back at the source samples", samples);
  report.table("bytes of an accepted error", errors);
}

#endif

} // namespace bccsplat::bench

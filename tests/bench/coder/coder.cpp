// SPDX-License-Identifier: Apache-2.0
// Codes every real series to three errors and to a bound, reads the bytes back and compares; the tool's files
// for the same are made and read beside them.
#include "tests/bench/coder/coder.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "base/error.h"
#include "base/files.h"
#include "base/text.h"
#include "tests/bench/coder/trial_coder.h"
#include "tests/bench/fit/fit_source.h"
#include "tests/bench/fit/tool_import.h"
#include "tests/bench/fit/zfp_size.h"
#include "tests/bench/moments/moments_volume.h"
#include "tests/bench/paper/paper.h"

namespace bccsplat::bench {
namespace {

constexpr double kibibyte = 1024;

struct CoderArguments {
  std::string data, set;
  int slab = 0, edge = TrialOptions{}.edge;
  bool today = true;
};

CoderArguments coder_arguments(std::span<const std::string> args) {
  CoderArguments out;
  for (size_t i = 0; i < args.size(); ++i) {
    if (args[i] == "--no-today") {
      out.today = false;
      continue;
    }
    if (i + 1 == args.size()) fail(Code::invalid_argument, "coder: ", args[i], " needs a value");
    const std::string& value = args[i + 1];
    const auto whole = [&] {
      const auto n = parse_number<int>(value);
      if (!n || *n < 1)
        fail(Code::invalid_argument, "coder: ", args[i], " is a number of 1 or more, not ", value);
      return *n;
    };
    if (args[i] == "--data")
      out.data = value;
    else if (args[i] == "--set")
      out.set = value;
    else if (args[i] == "--slab")
      out.slab = whole();
    else if (args[i] == "--edge")
      out.edge = whole();
    else
      fail(Code::invalid_argument, "coder: no option ", args[i],
           "; there are --data, --set, --slab, --edge, --no-today");
    ++i;
  }
  if (out.data.empty()) fail(Code::invalid_argument, "coder: needs --data DIR, a folder of real series");
  return out;
}

TrialSeries trial_series(const FitSource& source) {
  TrialSeries s;
  for (size_t a = 0; a < 4; ++a) s.dims[a] = static_cast<int>(source.dims[a]);
  for (uint32_t t = 0; t < source.dims[3]; ++t) {
    const std::vector<float> frame = source.frame(t);
    s.values.insert(s.values.end(), frame.begin(), frame.end());
  }
  return s;
}

struct Measured {
  double psnr = 0, largest = 0; // dB and share of the range; the largest error of a sample
};

Measured compare(const TrialSeries& source, const TrialSeries& back) {
  const auto [low, high] = std::minmax_element(source.values.begin(), source.values.end());
  const double range = *high - *low;
  double squares = 0;
  Measured m;
  for (size_t i = 0; i < source.values.size(); ++i) {
    const double e = std::fabs(double{back.values[i]} - source.values[i]);
    squares += e * e;
    m.largest = std::max(m.largest, e / range);
  }
  m.psnr = 20 * std::log10(range / std::sqrt(squares / static_cast<double>(source.values.size())));
  return m;
}

// What one way to store a series gives.
struct Stored {
  double psnr = 0, largest = 0, bytes = 0, encode = 0, decode = 0, moment = 0;
  std::string how;
};

// Moments between frames that are read one by one: places in the series, 0 .. 1.
constexpr std::array moments{.21, .37, .52, .68, .83};

// Frames that an interpolation in time of four frames needs.
double trial_moment(std::span<const std::byte> file, int frames) {
  double sum = 0;
  for (const double m : moments) {
    const int before = static_cast<int>(m * (frames - 1));
    sum += static_cast<double>(
        trial_moment_bytes(file, std::max(0, before - 1), std::min(frames - 1, before + 2)));
  }
  return sum / moments.size();
}

Stored store_trial(const TrialSeries& series, const TrialOptions& options) {
  Stored s;
  TrialFile file;
  s.encode = cpu_seconds([&] { file = trial_encode(series, options); });
  TrialSeries back;
  s.decode = median_cpu_seconds([&] { back = trial_decode(file.bytes); }, 3);
  const Measured m = compare(series, back);
  s.psnr = m.psnr, s.largest = m.largest;
  s.bytes = static_cast<double>(file.bytes.size());
  s.moment = trial_moment(file.bytes, series.dims[3]);
  s.how =
      concat(file.chain, "; ", number(static_cast<double>(file.details) / kibibyte, 1), " KiB of details");
  return s;
}

double today_moment(const std::string& path, int frames) {
  const auto source = open_file_source(path);
  WrittenSeries written;
  written.file.resize(source->size());
  source->read_at(0, written.file);
  double sum = 0;
  for (const double m : moments) {
    Opened volume(written, MomentOptions{});
    (void)volume.moment(m * (frames - 1));
    sum += static_cast<double>(volume.reader->bytes_read());
  }
  return sum / moments.size();
}

Stored store_today(const FitSource& source, const TrialSeries& series, const ToolImport& tool,
                   const std::string& bound) {
  Stored s;
  s.encode = tool.seconds(bound);
  s.bytes = static_cast<double>(open_file_source(tool.file())->size());
  FitSource back{source.name, source.dims, source.type, {}};
  s.decode = tool.export_seconds(back.bytes);
  if (back.bytes.size() != source.bytes.size())
    fail(Code::io_error, "export of ", source.name, " has another size");
  const Measured m = compare(series, trial_series(back));
  s.psnr = m.psnr, s.largest = m.largest;
  s.moment = today_moment(tool.file(), series.dims[3]);
  return s;
}

struct Tables {
  std::vector<Row> bytes, costs, bounds;
  double ratios = 0;
  int count = 0;
};

std::string kib_of(double bytes) { return number(bytes / kibibyte, 1); }

void add_psnr(const FitSource& source, double goal, const Stored& trial, const Stored& today,
              Tables& tables) {
  const auto zfp = zfp_bytes(source, goal);
  const double best = today.bytes > 0 ? std::min(today.bytes, zfp.value_or(today.bytes)) : zfp.value_or(NAN),
               ratio = trial.bytes / best;
  tables.ratios += ratio, ++tables.count;
  tables.bytes.push_back({word("series", source.name), figure("asked dB", goal, 0),
                          figure("trial dB", trial.psnr, 2), word("trial KiB", kib_of(trial.bytes)),
                          figure("today dB", today.psnr, 2), word("today KiB", kib_of(today.bytes)),
                          word("zfp KiB", zfp ? kib_of(*zfp) : "-"), figure("trial / best", ratio, 3),
                          figure("trial, largest error %", 100 * trial.largest, 2),
                          figure("today's %", 100 * today.largest, 2), word("chain", trial.how)});
  tables.costs.push_back(
      {word("series", source.name), figure("dB", goal, 0), figure("trial, encode s", trial.encode, 2),
       figure("today, import s", today.encode, 2), figure("trial, decode s", trial.decode, 3),
       figure("today, export s", today.decode, 3),
       figure("decode, trial / today", trial.decode / today.decode, 2),
       word("trial, moment KiB", kib_of(trial.moment)), word("today, moment KiB", kib_of(today.moment)),
       figure("moment, trial / today", trial.moment / today.moment, 2)});
}

void add_bound(const FitSource& source, const Stored& trial, const Stored& today, Tables& tables) {
  tables.bounds.push_back(
      {word("series", source.name), figure("trial dB", trial.psnr, 2), word("trial KiB", kib_of(trial.bytes)),
       figure("largest error %", 100 * trial.largest, 3), figure("today dB", today.psnr, 2),
       word("today KiB", kib_of(today.bytes)), figure("today's largest error %", 100 * today.largest, 3),
       figure("trial / today", trial.bytes / today.bytes, 3), word("chain", trial.how)});
}

double range_of(const TrialSeries& s) {
  const auto [low, high] = std::minmax_element(s.values.begin(), s.values.end());
  return *high - *low;
}

void measure_series(const FitSource& source, const CoderArguments& arguments, Tables& tables) {
  const TrialSeries series = trial_series(source);
  TrialOptions options;
  options.slab = arguments.slab, options.edge = arguments.edge;
  const ToolImport tool(source);
  for (const double goal : {45.0, 50.0, 60.0}) {
    options.psnr = goal;
    const Stored today =
        arguments.today ? store_today(source, series, tool, concat("--psnr ", goal)) : Stored{};
    add_psnr(source, goal, store_trial(series, options), today, tables);
  }
  constexpr double bound = .01; // of the range
  options.bound = bound * range_of(series);
  const Stored today = arguments.today
                           ? store_today(source, series, tool, concat("--abs ", number(options.bound, 6)))
                           : Stored{};
  add_bound(source, store_trial(series, options), today, tables);
}

} // namespace

int run_coder_suite(std::span<const std::string> args, const Report& report) {
  const CoderArguments arguments = coder_arguments(args);
  if (arguments.today && !has_tool())
    fail(Code::unsupported,
         "coder runs bcc4, which is not built here: configure with -DBCCSPLAT_BUILD_TOOL=ON, "
         "or give --no-today");
  Tables tables;
  for (const PaperSet& set : real_series()) {
    if (!arguments.set.empty() && arguments.set != set.name) continue;
    const auto source = load_paper_set(set, arguments.data);
    if (source)
      measure_series(*source, arguments, tables);
    else
      std::fprintf(stderr, "coder: *** %s is not in %s: not measured ***\n", set.file,
                   arguments.data.c_str());
  }
  report.table("bytes of an accepted error", tables.bytes);
  report.table("what they cost, one thread", tables.costs);
  report.table("every sample within 1 % of the range", tables.bounds);
  if (tables.count > 0)
    report.table("all of them", {{figure("mean of trial / best", tables.ratios / tables.count, 3)}});
  return 0;
}

} // namespace bccsplat::bench

// SPDX-License-Identifier: Apache-2.0
// Has the tool store every real series as wavelets, to three errors and to a bound, reads the files back and
// compares; its files of samples for the same are made and read beside them, and zfp's.
#include "tests/bench/coder/coder.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "base/error.h"
#include "base/files.h"
#include "base/text.h"
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
  bool others = true;
};

CoderArguments coder_arguments(std::span<const std::string> args) {
  CoderArguments out;
  for (size_t i = 0; i < args.size(); ++i) {
    if (args[i] == "--wavelets-only") {
      out.others = false;
      continue;
    }
    if (i + 1 == args.size()) fail(Code::invalid_argument, "coder: ", args[i], " needs a value");
    const std::string& value = args[i + 1];
    if (args[i] == "--data")
      out.data = value;
    else if (args[i] == "--set")
      out.set = value;
    else
      fail(Code::invalid_argument, "coder: no option ", args[i],
           "; there are --data, --set, --wavelets-only");
    ++i;
  }
  if (out.data.empty()) fail(Code::invalid_argument, "coder: needs --data DIR, a folder of real series");
  return out;
}

std::vector<float> all_values(const FitSource& source) {
  std::vector<float> values;
  for (uint32_t t = 0; t < source.dims[3]; ++t) {
    const std::vector<float> frame = source.frame(t);
    values.insert(values.end(), frame.begin(), frame.end());
  }
  return values;
}

struct Measured {
  double psnr = 0, largest = 0; // dB and share of the range; the largest error of a sample
};

Measured compare(std::span<const float> source, std::span<const float> back) {
  const auto [low, high] = std::minmax_element(source.begin(), source.end());
  const double range = *high - *low;
  double squares = 0;
  Measured m;
  for (size_t i = 0; i < source.size(); ++i) {
    const double e = std::fabs(double{back[i]} - source[i]);
    squares += e * e;
    m.largest = std::max(m.largest, e / range);
  }
  m.psnr = 20 * std::log10(range / std::sqrt(squares / static_cast<double>(source.size())));
  return m;
}

// What one way to store a series gives.
struct Stored {
  double psnr = 0, largest = 0, bytes = 0, encode = 0, decode = 0, moment = 0;
};

// Moments between frames that are read one by one: places in the series, 0 .. 1.
constexpr std::array moments{.21, .37, .52, .68, .83};

double moment_bytes(const std::string& path, int frames) {
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

Stored store(const FitSource& source, const ToolImport& tool, const std::string& options) {
  Stored s;
  s.encode = tool.seconds(options);
  s.bytes = static_cast<double>(open_file_source(tool.file())->size());
  FitSource back{source.name, source.dims, source.type, {}};
  s.decode = tool.export_seconds(back.bytes);
  if (back.bytes.size() != source.bytes.size())
    fail(Code::io_error, "export of ", source.name, " has another size");
  const Measured m = compare(all_values(source), all_values(back));
  s.psnr = m.psnr, s.largest = m.largest;
  s.moment = moment_bytes(tool.file(), static_cast<int>(source.dims[3]));
  return s;
}

struct Tables {
  std::vector<Row> bytes, costs, bounds;
  double ratios = 0;
  int count = 0;
};

std::string kib_of(double bytes) { return number(bytes / kibibyte, 1); }

void add_psnr(const FitSource& source, double goal, const Stored& wavelets, const Stored& other,
              Tables& tables) {
  const auto zfp = zfp_bytes(source, goal);
  const double best = other.bytes > 0 ? std::min(other.bytes, zfp.value_or(other.bytes)) : zfp.value_or(NAN),
               ratio = wavelets.bytes / best;
  tables.ratios += ratio, ++tables.count;
  tables.bytes.push_back(
      {word("series", source.name), figure("asked dB", goal, 0), figure("wavelets dB", wavelets.psnr, 2),
       word("wavelets KiB", kib_of(wavelets.bytes)), figure("--psnr dB", other.psnr, 2),
       word("--psnr KiB", kib_of(other.bytes)), word("zfp KiB", zfp ? kib_of(*zfp) : "-"),
       figure("wavelets / best", ratio, 3), figure("wavelets, largest error %", 100 * wavelets.largest, 2),
       figure("--psnr, largest error %", 100 * other.largest, 2)});
  tables.costs.push_back(
      {word("series", source.name), figure("dB", goal, 0), figure("wavelets, import s", wavelets.encode, 2),
       figure("--psnr, import s", other.encode, 2), figure("wavelets, export s", wavelets.decode, 3),
       figure("--psnr, export s", other.decode, 3), word("wavelets, moment KiB", kib_of(wavelets.moment)),
       word("--psnr, moment KiB", kib_of(other.moment))});
}

void add_bound(const FitSource& source, const Stored& wavelets, const Stored& other, Tables& tables) {
  tables.bounds.push_back({word("series", source.name), figure("wavelets dB", wavelets.psnr, 2),
                           word("wavelets KiB", kib_of(wavelets.bytes)),
                           figure("largest error %", 100 * wavelets.largest, 3),
                           figure("--abs dB", other.psnr, 2), word("--abs KiB", kib_of(other.bytes)),
                           figure("its largest error %", 100 * other.largest, 3),
                           figure("wavelets / --abs", wavelets.bytes / other.bytes, 3)});
}

void measure_series(const FitSource& source, const CoderArguments& arguments, Tables& tables) {
  const ToolImport tool(source);
  const auto other = [&](const std::string& options) {
    return arguments.others ? store(source, tool, options) : Stored{};
  };
  for (const double goal : {45.0, 50.0, 60.0}) {
    const std::string psnr = concat("--psnr ", goal);
    add_psnr(source, goal, store(source, tool, psnr + " --store wavelets"), other(psnr + " --store samples"),
             tables);
  }
  constexpr double share = .01; // of the range
  const std::vector<float> values = all_values(source);
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const std::string bound = concat("--abs ", number(share * (*high - *low), 6));
  add_bound(source, store(source, tool, bound + " --store wavelets"), other(bound + " --store samples"),
            tables);
}

} // namespace

int run_coder_suite(std::span<const std::string> args, const Report& report) {
  const CoderArguments arguments = coder_arguments(args);
  if (!has_tool())
    fail(Code::unsupported,
         "coder runs bcc4, which is not built here: configure with -DBCCSPLAT_BUILD_TOOL=ON");
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
    report.table("all of them", {{figure("mean of wavelets / best", tables.ratios / tables.count, 3)}});
  return 0;
}

} // namespace bccsplat::bench

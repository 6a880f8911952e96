// SPDX-License-Identifier: Apache-2.0
// bcc4 compare: two .bcc4 files, or one and a series, where both have values.
#include <cstdio>
#include <memory>

#include "readers/open_series.h"
#include "tool/cli.h"
#include "tool/commands/commands.h"
#include "tool/compare/compare_fields.h"
#include "tool/import/reader_arguments.h"
#include "tool/json.h"
#include "tool/progress.h"
#include "tool/view/time_slice.h"

namespace bcc4 {
namespace {

struct CompareArguments {
  std::vector<std::string> files;
  std::string kernel;
  ReaderArguments reader;
  std::optional<double> tolerance;
  bool frames = false;
  CommonOptions common;
};

bool is_volume(const std::string& path) { return lower(path).ends_with(".bcc4"); }

// The second file, and what keeps it open.
struct Other {
  std::optional<Volume> volume;
  std::unique_ptr<FrameReader> reader;
  std::unique_ptr<SampledSeries> series;
};

// Reads a series as the options say, or, where that is not enough for its files, as the first file's source
// was read.
std::unique_ptr<FrameReader> open_given_or_recalled(const Volume& first, const ReaderArguments& given) {
  try {
    return open_series(given.options);
  } catch (const Error& e) {
    if (exit_of(e.code()) != Exit::usage) throw;
  }
  ReaderArguments recalled = given;
  recall_reader_options(first, recalled);
  return open_series(recalled.options);
}

Other open_other(const Device& device, const Volume& first, CompareArguments& a) {
  Other other;
  if (is_volume(a.files[1])) {
    if (a.files.size() > 2) fail_usage("compare takes two .bcc4 files, or one and the files of one series");
    other.volume = open_volume(device, a.files[1], a.kernel);
    if (!a.common.quiet) warn_of_part(*other.volume, a.files[1]);
    other.series = series_of_volume(*other.volume, a.files[1]);
    return other;
  }
  a.reader.options.inputs.assign(a.files.begin() + 1, a.files.end());
  a.reader.options.max_memory = a.common.max_memory / 4;
  const ReaderOptions& options = a.reader.options;
  other.reader = open_given_or_recalled(first, a.reader);
  other.series = series_of_reader(*other.reader, a.files[1], options.spacing || options.origin);
  return other;
}

std::string place_text(const FieldDifference& d, const std::string& time_unit) {
  return concat("frame ", d.worst.frame, " at ", time_text(d.worst.time), time_unit.empty() ? "" : " ",
                time_unit, ", sample (", d.worst.sample[0], ", ", d.worst.sample[1], ", ", d.worst.sample[2],
                ")");
}

void print_difference(const std::string& name, const FieldDifference& d, const std::string& time_unit) {
  std::printf("%s: %llu samples, max %s, RMSE %s, %s\n", name.c_str(),
              static_cast<unsigned long long>(d.all.count), short_number(d.all.max).c_str(),
              short_number(d.all.rmse()).c_str(), psnr_words(d).c_str());
  if (d.all.max > 0) {
    const int digits = digits_apart(d.worst.first, d.worst.second - d.worst.first, 6);
    std::printf("  largest: %s of the second: %s, there %s\n", place_text(d, time_unit).c_str(),
                short_number(d.worst.first, digits).c_str(), short_number(d.worst.second, digits).c_str());
  }
  if (d.missing[0] > 0 || d.missing[1] > 0)
    std::printf("  missing in the first alone %llu, in the second alone %llu\n",
                static_cast<unsigned long long>(d.missing[0]), static_cast<unsigned long long>(d.missing[1]));
}

void print_compared(const std::vector<FieldDifference>& channels, const std::string& time_unit, bool frames) {
  for (const FieldDifference& d : channels) {
    print_difference(d.name, d, time_unit);
    for (const FieldDifference& f : d.frames)
      if (frames) print_difference(concat("  frame ", f.worst.frame), f, time_unit);
  }
  const FieldDifference& d = channels.front();
  if (d.samples_outside > 0 || d.frames_outside > 0)
    std::printf(
        "not compared, because the first file does not reach there: %llu samples a frame, %llu frames\n",
        static_cast<unsigned long long>(d.samples_outside),
        static_cast<unsigned long long>(d.frames_outside));
}

Json compared_json(const std::vector<FieldDifference>& channels, bool equal, double tolerance, bool frames) {
  Json j{{"equal", equal}, {"tolerance", tolerance}};
  j.update(field_difference_json(channels.front(), frames));
  j["samples_outside"] = channels.front().samples_outside;
  j["frames_outside"] = channels.front().frames_outside;
  j["channels"] = Json::array();
  for (const FieldDifference& d : channels) {
    Json entry{{"name", d.name}};
    entry.update(field_difference_json(d, frames));
    j["channels"].push_back(std::move(entry));
  }
  return j;
}

Exit run_compare(CompareArguments& a) {
  if (a.files.size() < 2 || !is_volume(a.files[0]))
    fail_usage("two files are missing, the first a .bcc4 file; for example bcc4 compare a.bcc4 b.bcc4");
  const double tolerance = a.tolerance.value_or(0);
  if (!(tolerance >= 0)) fail_usage("--tolerance ", tolerance, ": 0 or more is expected");
  const Device device = create_device(a.common.threads, a.common.max_memory - a.common.max_memory / 4);
  const Volume first = open_volume(device, a.files[0], a.kernel);
  if (!a.common.quiet) warn_of_part(first, a.files[0]);
  const Other other = open_other(device, first, a);
  Progress progress("compare", other.series->times.size(), false, !a.common.prints_text());
  const std::vector<FieldDifference> channels = compare_fields(first, a.files[0], *other.series, progress);
  progress.clear();
  const FieldDifference* worst = nullptr;
  for (const FieldDifference& d : channels)
    if (!d.within(tolerance) && (!worst || d.all.max > worst->all.max)) worst = &d;
  if (a.common.json)
    print_json(compared_json(channels, !worst, tolerance, a.frames));
  else if (!a.common.quiet)
    print_compared(channels, volume_info(first).time_unit, a.frames);
  if (!worst) return Exit::ok;
  if (worst->all.max <= tolerance)
    fail_check(a.files[0], " and ", other.series->name, ": values of ", worst->name,
               " are missing in one of them only");
  fail_check(a.files[0], " and ", other.series->name, ": ", worst->name, " differs by up to ",
             short_number(worst->all.max), a.tolerance ? concat(", more than --tolerance ", tolerance) : "");
}

} // namespace

Run add_compare(const Command& tool) {
  auto a = std::make_shared<CompareArguments>();
  const Command compare = tool.add_command(
      "compare",
      "Compare a .bcc4 file with another one or with a series. The exit code is 1 where they differ.");
  compare.set_examples({"bcc4 compare smoke.bcc4 bound.bcc4 --tolerance 0.1",
                        "bcc4 compare smoke.bcc4 smoke.nrrd --tolerance 0.1"});
  compare.add_option("FILES", a->files, "A .bcc4 file, and another one or the files of a series")
      .expected(2, -1);
  add_number(compare, "--tolerance", a->tolerance, "Largest difference that counts as none (default 0)");
  compare.add_flag("--each-frame", a->frames, "Add the difference of every frame");
  add_reader_options(compare, a->reader);
  compare.add_option("--kernel", a->kernel, "Kernel to reconstruct with (default: the file's)")
      .type_name("NAME");
  add_threads(compare, a->common);
  add_max_memory(compare, a->common);
  compare.add_flag("--json", a->common.json, "Report as JSON");
  compare.add_flag("--quiet", a->common.quiet, "Print errors only");
  return [a] { return run_compare(*a); };
}

} // namespace bcc4

// SPDX-License-Identifier: Apache-2.0
// bcc4 verify: checksums of a file, and its field against the source it was made from.
#include <algorithm>
#include <cstdio>
#include <memory>

#include "readers/open_series.h"
#include "tool/cli.h"
#include "tool/commands/commands.h"
#include "tool/compare/compare_fields.h"
#include "tool/import/comparison.h"
#include "tool/import/reader_arguments.h"
#include "tool/json.h"

namespace bcc4 {
namespace {

struct VerifyArguments {
  std::string file, kernel;
  ReaderArguments reader;
  CommonOptions common;
};

// Reads the source as it was read at import, or, where that makes no sense of a file of another format, as
// the file itself says.
std::unique_ptr<FrameReader> open_as_imported(const Volume& volume, const ReaderArguments& given) {
  ReaderArguments recalled = given;
  recall_reader_options(volume, recalled);
  ReaderOptions& o = recalled.options;
  // Listed, be it in a file that may be gone.
  if (!o.dt && !o.times && told(volume, "import.times") == "--times")
    o.dt = 1; // values are compared, whatever their times
  try {
    return open_series(o);
  } catch (const Error& e) {
    if (exit_of(e.code()) != Exit::usage) throw;
  }
  return open_series(given.options);
}

// Refuses a source that is not the one the file was made from, by what its description tells.
std::unique_ptr<FrameReader> open_source(const Volume& volume, VerifyArguments& a) {
  a.reader.options.max_memory = a.common.max_memory / 4;
  std::unique_ptr<FrameReader> reader = open_as_imported(volume, a.reader);
  const SeriesDescription& s = reader->description();
  const bccsplat_volume_info v = volume_info(volume);
  if (!std::equal(s.dims.begin(), s.dims.end(), v.dims) || s.channels.size() != v.channel_count)
    fail_input("the source has ", s.dims[0], " x ", s.dims[1], " x ", s.dims[2], " x ", s.dims[3],
               " samples in ", s.channels.size(), " channel(s), but ", a.file, " was made from ", v.dims[0],
               " x ", v.dims[1], " x ", v.dims[2], " x ", v.dims[3], " in ", v.channel_count);
  const ReaderOptions& o = a.reader.options;
  const auto source = series_of_reader(*reader, "the source", o.spacing || o.origin);
  const bool by_options = told(volume, "import.times").starts_with("--"); // as the files do not tell them
  source->has_times = source->has_times && !by_options && !o.dt && !o.times;
  require_same_grid(volume, a.file, *source);
  return reader;
}

// A file too damaged to be opened has failed the check like any other; one that is no .bcc4 file is bad
// input.
Volume open_checked(const Device& device, const VerifyArguments& a) {
  try {
    return open_volume(device, a.file, a.kernel);
  } catch (const Error& e) {
    if (e.code() != Code::corrupt && e.code() != Code::truncated && e.code() != Code::checksum_mismatch)
      throw;
    if (a.common.json) print_json({{"ok", false}, {"error", e.what()}});
    fail_check(e.what());
  }
}

Json verify_json(const Volume& volume, const VerifyArguments& a, const bccsplat_verify_report& report,
                 const std::vector<Comparison>& comparisons) {
  const bool ok = report.damages == 0;
  Json j{{"ok", ok},
         {"chunks", report.chunks},
         {"chunks_damaged", report.chunks_damaged},
         {"damages", report.damages},
         {"bytes_checked", report.bytes_checked}};
  j["first_damaged_offset"] = ok ? Json() : Json(report.first_damaged_offset);
  if (!comparisons.empty()) {
    const auto bound = [&](uint32_t c) { return a.kernel.empty() ? channel_info(volume, c).error_bound : 0; };
    j.update(comparison_json(comparisons[0], bound(0)));
    j["channels"] = Json::array();
    for (uint32_t c = 0; c < comparisons.size(); ++c) {
      Json entry{{"name", channel_info(volume, c).name}};
      entry.update(comparison_json(comparisons[c], bound(c)));
      j["channels"].push_back(std::move(entry));
    }
  }
  return j;
}

void print_verified(const Volume& volume, const VerifyArguments& a, const bccsplat_verify_report& report,
                    const std::vector<Comparison>& comparisons) {
  std::printf(
      "%s: %llu chunks, %s checked, %s\n", a.file.c_str(), static_cast<unsigned long long>(report.chunks),
      byte_text(static_cast<double>(report.bytes_checked)).c_str(),
      report.damages == 0
          ? "no damage"
          : concat(report.damages, " damages, the first at offset ", report.first_damaged_offset).c_str());
  for (uint32_t c = 0; c < comparisons.size(); ++c)
    print_comparison(channel_info(volume, c).name, comparisons[c]);
}

// A damaged file, or one that does not keep the error it promises, fails the check.
void refuse_failed(const Volume& volume, const VerifyArguments& a, const bccsplat_verify_report& report,
                   const std::vector<Comparison>& comparisons) {
  if (report.damages > 0)
    fail_check(a.file, ": ", report.damages, " damages (", report.chunks_damaged, " of ", report.chunks,
               " chunks), the first at offset ", report.first_damaged_offset,
               ": make the file again from its source");
  for (uint32_t c = 0; c < comparisons.size() && a.kernel.empty(); ++c) {
    const bccsplat_channel_info info = channel_info(volume, c);
    if (info.error_bound > 0 && comparisons[c].all.max > info.error_bound)
      fail_check(a.file, ": channel ", info.name, " promises an error of at most ", info.error_bound,
                 ", but differs by ", comparisons[c].all.max, " from this source");
  }
}

Exit run_verify(VerifyArguments& a) {
  require_option(a.file, "FILE", "bcc4 verify smoke.bcc4");
  const Device device = create_device(a.common.threads, a.common.max_memory - a.common.max_memory / 4);
  const Volume volume = open_checked(device, a);
  if (volume_info(volume).part_end > 0 && !a.reader.options.inputs.empty())
    fail_usage(a.file, ": a part of a series; bcc4 concat joins all parts to what can be compared");
  auto report = sized<bccsplat_verify_report>();
  check(bccsplat_volume_verify(volume.get(), nullptr, nullptr, &report), a.file);
  std::vector<Comparison> comparisons;
  if (report.damages == 0 && !a.reader.options.inputs.empty())
    comparisons = compare_series(volume, *open_source(volume, a), a.common.prints_text());

  if (a.common.json)
    print_json(verify_json(volume, a, report, comparisons));
  else if (!a.common.quiet)
    print_verified(volume, a, report, comparisons);
  refuse_failed(volume, a, report, comparisons);
  return Exit::ok;
}

} // namespace

Run add_verify(const Command& tool) {
  auto a = std::make_shared<VerifyArguments>();
  const Command verify = tool.add_command(
      "verify",
      "Check a .bcc4 file for damage, or against its source. The exit code is 1 where it is damaged.");
  verify.set_examples({"bcc4 verify smoke.bcc4", "bcc4 verify smoke.bcc4 --against smoke.*.raw"});
  verify.add_option("FILE", a->file, "A .bcc4 file");
  verify
      .add_option("--against", a->reader.options.inputs,
                  "Compare every sample with the source. The options of the import are remembered")
      .type_name("INPUT...")
      .expected(1, -1);
  add_reader_options(verify, a->reader);
  verify.add_option("--kernel", a->kernel, "Kernel to reconstruct with (default: the file's)")
      .type_name("NAME");
  add_threads(verify, a->common);
  add_max_memory(verify, a->common);
  verify.add_flag("--json", a->common.json, "Report as JSON");
  verify.add_flag("--quiet", a->common.quiet, "Print errors only");
  return [a] { return run_verify(*a); };
}

} // namespace bcc4

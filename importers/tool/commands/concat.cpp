// SPDX-License-Identifier: Apache-2.0
// bcc4 concat: parts of a series -> one .bcc4 file.
#include <cstdio>
#include <memory>

#include "tool/cli.h"
#include "tool/commands/commands.h"
#include "tool/handles.h"
#include "tool/import/summary.h"
#include "tool/interrupt.h"
#include "tool/json.h"
#include "tool/output/output_file.h"
#include "tool/progress.h"

namespace bcc4 {
namespace {

struct ConcatArguments {
  std::vector<std::string> parts;
  std::string output;
  bool overwrite = false;
  CommonOptions common;
};

Exit run_concat(const ConcatArguments& a) {
  if (a.parts.empty()) fail_usage("PART... is missing, such as bcc4 concat part.*.bcc4 -o whole.bcc4");
  require_option(a.output, "-o", "-o whole.bcc4");
  refuse_existing(a.output, a.overwrite);
  for (const std::string& part : a.parts) refuse_source_as_output(a.output, part);
  const Device device = create_device(1, 0);
  Progress progress("join  parts", Progress::fraction_steps, false, a.common.quiet || a.common.json);
  auto options = sized<bccsplat_join_options>();
  options.overwrite = a.overwrite ? 1 : 0;
  options.compare_levels = 1;
  options.progress = Progress::show_fraction;
  options.cancel_token = interrupt_token();
  options.progress_user = &progress;
  std::vector<const char*> paths;
  for (const std::string& part : a.parts) paths.push_back(part.c_str());
  auto report = sized<bccsplat_writer_report>();
  const bccsplat_status status =
      bccsplat_join_parts(device.get(), paths.size(), paths.data(), a.output.c_str(), &options, &report);
  progress.clear();
  if (status == BCCSPLAT_ERROR_BOUND_NOT_MET)
    fail_check(
        bccsplat_last_error(),
        "; one process would write the series again with corrections, parts cannot: make the plan with "
        "--abs");
  const std::string said = status == BCCSPLAT_OK ? "" : bccsplat_last_error();
  if (said.find("a whole file") != std::string::npos)
    throw Error(static_cast<Code>(status),
                concat(said, "; bcc4 import --append adds the frames of other files to it"));
  check(status, "");
  if (a.common.json) {
    print_json({{"parts", a.parts.size()},
                {"frames", report.frames},
                {"sites_total", report.sites_total},
                {"sites_kept", report.sites_kept},
                {"bytes", bytes_json(report)},
                {"output", a.output}});
  } else if (!a.common.quiet) {
    std::printf("%s: %zu parts, %llu frames, %s of values -> %s\n", a.output.c_str(), a.parts.size(),
                static_cast<unsigned long long>(report.frames),
                byte_text(static_cast<double>(report.bytes_source)).c_str(),
                byte_text(static_cast<double>(report.bytes_file)).c_str());
  }
  return Exit::ok;
}

} // namespace

Run add_concat(const Command& tool) {
  auto a = std::make_shared<ConcatArguments>();
  const Command concat = tool.add_command("concat", "Join the parts of a series that import --part made.");
  concat.set_examples({"bcc4 import smoke.*.raw --dims 64,64,64 --dtype f32 --dry-run --plan plan.json",
                       "bcc4 import --plan plan.json --part 1/2 -o part.1.bcc4",
                       "bcc4 import --plan plan.json --part 2/2 -o part.2.bcc4",
                       "bcc4 concat part.1.bcc4 part.2.bcc4 -o joined.bcc4"});
  concat.add_option("PART", a->parts, "Files of import --part, in any order");
  concat.add_option("-o,--output,--out", a->output, "The .bcc4 file to write").type_name("OUT.bcc4");
  concat.add_flag("--overwrite", a->overwrite, "Replace an existing output");
  concat.add_flag("--json", a->common.json, "Report as JSON");
  concat.add_flag("--quiet", a->common.quiet, "Print nothing but warnings and errors");
  return [a] { return run_concat(*a); };
}

} // namespace bcc4

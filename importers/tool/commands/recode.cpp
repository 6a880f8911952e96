// SPDX-License-Identifier: Apache-2.0
// bcc4 recode: one .bcc4 file made of another, without the source.
#include <cstdio>
#include <memory>

#include "tool/cli.h"
#include "tool/commands/commands.h"
#include "tool/handles.h"
#include "tool/import/summary.h"
#include "tool/import/writer_choices.h"
#include "tool/interrupt.h"
#include "tool/json.h"
#include "tool/output/output_file.h"
#include "tool/progress.h"

namespace bcc4 {
namespace {

struct RecodeArguments {
  std::string file, output, kernel;
  int32_t store = BCCSPLAT_STORE_DEFAULT, value_type = BCCSPLAT_TYPE_DEFAULT, format = 0;
  double step = 0;
  bool overwrite = false;
  CommonOptions common;
};

bool has_planes_outside(const bccsplat_volume_info& info) {
  bool any = false;
  for (int a = 0; a < 3; ++a) any = any || info.planes_before[a] > 0 || info.planes_behind[a] > 0;
  return any;
}

Exit run_recode(const RecodeArguments& a) {
  if (a.file.empty())
    fail_usage("FILE is missing, such as bcc4 recode in.bcc4 -o out.bcc4 --store coefficients");
  require_option(a.output, "-o", "-o out.bcc4");
  if (!(a.step >= 0)) fail_usage("--step ", a.step, ": a positive number is expected");
  refuse_existing(a.output, a.overwrite);
  refuse_source_as_output(a.output, a.file);
  const Device device = create_device(a.common.threads, a.common.max_memory);
  const Volume volume = open_volume(device, a.file, "");
  Progress progress("recode  layers", Progress::fraction_steps, false, a.common.quiet || a.common.json);
  auto options = sized<bccsplat_recode_options>();
  options.overwrite = a.overwrite ? 1 : 0;
  options.store = a.store;
  options.value_type = a.value_type;
  options.value_step = a.step;
  // What gives a grid's own samples back has no coefficients.
  const bool exact = volume_info(volume).recommended_kernel == std::string_view("exact");
  const std::string kernel =
      a.kernel.empty() && exact && a.store == BCCSPLAT_STORE_COEFFICIENTS ? "default" : a.kernel;
  options.kernel = kernel.empty() ? nullptr : kernel.c_str();
  options.format = a.format;
  options.progress = Progress::show_fraction;
  options.cancel_token = interrupt_token();
  options.progress_user = &progress;
  if (volume_info(volume).level_count > 0)
    std::fprintf(stderr, "bcc4: warning: %s: its coarser levels are not recoded, they are made of frames\n",
                 a.file.c_str());
  for (uint32_t c = 0; c < volume_info(volume).channel_count; ++c)
    if (const bccsplat_channel_info info = channel_info(volume, c); info.error_bound > 0)
      std::fprintf(stderr,
                   "bcc4: warning: %s: the bound of channel %s, %g, is not kept, nor its corrections\n",
                   a.file.c_str(), info.name, info.error_bound);
  if (a.format == 2 && has_planes_outside(volume_info(volume)))
    std::fprintf(
        stderr,
        "bcc4: warning: %s: version 2 has no planes outside the faces, which make the field right up to "
        "them: it is less exact there\n",
        a.file.c_str());
  auto report = sized<bccsplat_writer_report>();
  const bccsplat_status status = bccsplat_volume_recode(volume.get(), a.output.c_str(), &options, &report);
  progress.clear();
  check(status, a.file);
  if (a.common.json) {
    print_json({{"frames", report.frames},
                {"sites_total", report.sites_total},
                {"sites_kept", report.sites_kept},
                {"clamped", report.clamped},
                {"bytes", bytes_json(report)},
                {"output", a.output}});
  } else if (!a.common.quiet) {
    std::printf("%s: %llu of %llu sites -> %s\n", a.output.c_str(),
                static_cast<unsigned long long>(report.sites_kept),
                static_cast<unsigned long long>(report.sites_total + report.sites_outside),
                byte_text(static_cast<double>(report.bytes_file)).c_str());
  }
  return Exit::ok;
}

} // namespace

Run add_recode(const Command& tool) {
  auto a = std::make_shared<RecodeArguments>();
  const Command recode = tool.add_command(
      "recode",
      "Write a .bcc4 file anew without its source. It gets another store, kernel, step or format version.");
  recode.set_examples({"bcc4 recode smoke.bcc4 --store coefficients -o play.bcc4"});
  recode.add_option("FILE", a->file, "A .bcc4 file");
  recode.add_option("-o,--output,--out", a->output, "The .bcc4 file to write").type_name("OUT.bcc4");
  add_choice<int32_t>(
      recode, "--store", a->store, kStoreChoices,
      "Store samples or the kernel's coefficients (default: as in FILE; wavelets are made of a "
      "source, by bcc4 import, and become samples)");
  recode
      .add_option("--kernel", a->kernel,
                  "Kernel of the coefficients (default: as in FILE, or of a grid's own samples: default)")
      .type_name("NAME");
  add_choice<int32_t>(recode, "--quantize", a->value_type, kTypeChoices,
                      "Type of the stored values (default: as in FILE)");
  recode.add_option("--step", a->step,
                    "Difference of neighbouring integers in the file's values (default: as in FILE)");
  recode.add_option("--format", a->format, "Newest format version that the file may use (default: any)")
      .type_name("VERSION");
  recode.add_flag("--overwrite", a->overwrite, "Replace an existing output");
  add_threads(recode, a->common);
  add_max_memory(recode, a->common);
  recode.add_flag("--json", a->common.json, "Report as JSON");
  recode.add_flag("--quiet", a->common.quiet, "Print nothing but warnings and errors");
  return [a] { return run_recode(*a); };
}

} // namespace bcc4

// SPDX-License-Identifier: Apache-2.0
// bcc4 import: a series of frames -> one .bcc4 file.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>

#include "readers/open_series.h"
#include "tool/cli.h"
#include "tool/commands/commands.h"
#include "tool/import/air.h"
#include "tool/import/append.h"
#include "tool/import/estimate.h"
#include "tool/import/plan.h"
#include "tool/import/plan_file.h"
#include "tool/import/reader_arguments.h"
#include "tool/import/resume.h"
#include "tool/import/settle.h"
#include "tool/import/sources.h"
#include "tool/import/summary.h"
#include "tool/import/write_series.h"
#include "tool/import/writer_choices.h"
#include "tool/json.h"
#include "tool/output/output_file.h"
#include "tool/progress.h"

namespace bcc4 {
namespace {

struct ImportArguments {
  ReaderArguments reader;
  WriterSettings settings;
  CommonOptions common;
  std::optional<double> air, air_threshold, abs, psnr;
  std::string scale;      // a number, or one for each axis
  std::string time_scale; // a number, or auto
  std::string lattice;    // a name, or auto
  std::string levels;     // a number, auto or none; empty: auto
  std::optional<double> density;
  bool exact = false;
  std::string output;
  bool dry_run = false;
  std::string plan, part; // file; frames as typed
  ResumeArguments resume;
  ImportArguments() { settings.measure = BCCSPLAT_MEASURE_SOME; }
  [[nodiscard]] bool follows_plan() const { return !plan.empty() && !dry_run; }
  [[nodiscard]] bool auto_levels() const { return levels.empty() || levels == "auto"; }
};

// What cannot be written is said before the work.
void check_outputs(const ImportArguments& a) {
  if (!a.dry_run) {
    require_option(a.output, "-o", "-o out.bcc4");
    refuse_existing(a.output, a.settings.overwrite || a.resume.append);
    require_writable_folder(a.output);
    if (!a.part.empty() && a.plan.empty())
      fail_usage("--part needs the --plan that all parts share; --dry-run --plan FILE makes one");
  } else if (!a.part.empty()) {
    fail_usage("--part with --dry-run: a plan is made of the whole series");
  } else if (!a.plan.empty()) {
    refuse_existing(a.plan, a.settings.overwrite);
    require_writable_folder(a.plan);
  }
}

// --scale S, X,Y,Z or X,Y,Z,T. What space is left with is the mean, for those who ask for one number.
void read_scale(const std::string& text, const std::string& time_scale, WriterSettings& settings) {
  if (text.empty()) return;
  const std::vector<double> scale = option_numbers("--scale", text, 0);
  for (const double s : scale)
    if (!(s > 0)) fail_usage("--scale must be positive");
  if (scale.size() == 1) {
    settings.scale = scale[0];
    return;
  }
  if (scale.size() != 3 && scale.size() != 4)
    fail_usage("--scale ", text, ": one number, or those along x,y,z or x,y,z,t");
  if (scale.size() == 4 && !time_scale.empty())
    fail_usage("--scale ", text, " has a distance along time, and so has --time-scale: choose one");
  std::copy(scale.begin(), scale.end(), settings.scales.begin());
  settings.scale = std::cbrt(scale[0] * scale[1] * scale[2]);
  if (scale.size() == 4) settings.time_scale = scale[3];
}

// --lattice and --density. A lattice by name has the distances that are given, or 1.
void read_lattice(const ImportArguments& a, WriterSettings& settings) {
  if (!a.lattice.empty() && a.lattice != "auto")
    settings.lattice = option_choice("--lattice", a.lattice, kLatticeChoices);
  if (!a.density) return;
  if (!(*a.density > 0 && *a.density <= 4)) fail_usage("--density ", *a.density, ": more than 0, at most 4");
  if (!a.scale.empty() || !a.time_scale.empty())
    fail_usage("--density chooses the distances that --scale and --time-scale give: one or the other");
}

// --levels N, auto or none.
uint32_t read_levels(const ImportArguments& a, const std::array<uint64_t, 4>& dims) {
  if (a.auto_levels()) return levels_for(dims);
  return a.levels == "none" ? 0 : option_number<uint32_t>("--levels", a.levels);
}

// Is the lattice, or its shape, to be chosen?
bool chooses_lattice(const ImportArguments& a) {
  if (a.density) return true;
  if (!a.scale.empty() || !a.time_scale.empty()) return false;
  return a.settings.lattice == BCCSPLAT_LATTICE_DEFAULT;
}

// Checks what was typed about the writer and completes its settings.
ErrorBound read_settings(ImportArguments& a) {
  a.settings.air = a.air;
  a.settings.air_threshold = a.air_threshold.value_or(0);
  read_scale(a.scale, a.time_scale, a.settings);
  read_lattice(a, a.settings);
  if (!a.time_scale.empty() && a.time_scale != "auto") {
    a.settings.time_scale = option_number<double>("--time-scale", a.time_scale);
    if (!(a.settings.time_scale > 0)) fail_usage("--time-scale must be positive, or auto");
  }
  const auto finite = [](const std::optional<double>& number, double most, const char* option) {
    if (number && !(std::fabs(*number) <= most)) fail_usage(option, " ", *number, ": must be finite");
  };
  finite(a.abs, std::numeric_limits<double>::max(), "--abs"), finite(a.psnr, 1e6, "--psnr");
  finite(a.air, std::numeric_limits<float>::max(), "--air");
  finite(a.air_threshold, std::numeric_limits<float>::max(), "--air-threshold");
  if (a.abs && a.psnr) fail_usage("--abs and --psnr: choose one");
  if (a.abs && !(*a.abs > 0))
    fail_usage(
        "--abs must be positive: the largest error allowed at any source sample, in units of the values");
  if (a.psnr && !(*a.psnr > 0)) fail_usage("--psnr must be positive, in dB: 50 is good, 70 is next to exact");
  if (!(a.settings.air_threshold >= 0)) fail_usage("--air-threshold must not be negative");
  return {a.abs.value_or(0), a.psnr.value_or(0)};
}

// The plan's options in the place of those typed; inputs that were typed replace the plan's.
PlanFile recall_plan(ImportArguments& a) {
  if (a.resume.append) fail_usage("--append reads a series without a plan");
  PlanFile plan = read_plan_file(a.plan);
  if (a.reader.options.inputs.empty()) a.reader.options.inputs = plan.inputs;
  for (const auto& [key, text] : plan.options) set_reader_option(a.reader, key, text);
  const WriterSettings typed = a.settings;
  a.settings = plan.settings;
  a.settings.overwrite = typed.overwrite, a.settings.partial = typed.partial, a.settings.live = typed.live;
  return plan;
}

std::unique_ptr<FrameReader> open_input(const ImportArguments& a) {
  std::unique_ptr<FrameReader> reader = open_series(a.reader.options);
  const SeriesDescription& s = reader->description();
  for (const std::string& warning : s.warnings) std::fprintf(stderr, "bcc4: warning: %s\n", warning.c_str());
  if (s.sparse && a.settings.air)
    for (const Channel& c : s.channels)
      if (*a.settings.air != c.air)
        fail_usage("--air ", *a.settings.air, ": outside its active voxels grid \"", c.name,
                   "\" has its background, ", c.air);
  return reader;
}

void refuse_sources_as_output(const ImportArguments& a, const SeriesDescription& s) {
  for (const SourceFile& f : s.files) {
    if (!a.dry_run) refuse_source_as_output(a.output, f.path);
    if (a.dry_run && !a.plan.empty()) refuse_source_as_output(a.plan, f.path);
  }
}

bool appends_to_file(const ImportArguments& a) {
  std::error_code ignored;
  return a.resume.append && std::filesystem::exists(a.output, ignored);
}

void report_nothing_new(const ImportArguments& a, uint64_t frames) {
  if (a.common.json)
    print_json({{"output", a.output}, {"frames", frames}, {"appended", nullptr}});
  else if (!a.common.quiet)
    std::printf("%s: it has all %llu frames already\n", a.output.c_str(),
                static_cast<unsigned long long>(frames));
}

// What remains to be decided about a series, after what the file has that it is appended to.
Unsettled find_unsettled(ImportArguments& a, const Device& device, const SeriesDescription& s,
                         const ErrorBound& bound) {
  Unsettled u;
  u.bound = bound;
  u.auto_time_scale = a.time_scale == "auto";
  u.auto_lattice = chooses_lattice(a);
  u.density = a.density.value_or(0);
  u.exact = a.exact;
  u.everything = a.dry_run, u.progress = a.common.prints_text();
  if (!appends_to_file(a) || bound.any()) return u;
  if (u.auto_lattice && !a.density) {
    adopt_lattice(device, a.output, a.settings);
    u.auto_lattice = false;
  }
  if (!a.exact && a.settings.quantize == BCCSPLAT_TYPE_DEFAULT) {
    adopt_steps(device, a.output, s, a.settings);
    u.exact = true;
  }
  return u;
}

// The part of a planned series that was asked for, none for all of it.
void take_part(const ImportArguments& a, const Device& device, const SeriesDescription& s,
               const std::vector<ChannelScan>& scans, ImportScope& scope) {
  if (a.part.empty()) return;
  scope.part = parse_part(a.part, s.dims[3]);
  scope.lead = lead_of(scans, part_frames(device, s, a.settings, scans, *scope.part).first);
}

void save_plan(const ImportArguments& a, const ImportPlan& plan) {
  const SeriesDescription& s = plan.series;
  PlanFile file;
  file.inputs = a.reader.options.inputs;
  file.options = a.reader.texts;
  file.settings = a.settings;
  file.dims = s.dims;
  file.times = s.times.values;
  for (const Channel& c : s.channels) file.channels.push_back(c.name);
  file.sources = sources_of(s);
  file.scans = plan.scans;
  make_absolute(file);
  write_plan_file(a.plan, file, a.settings.overwrite);
}

void report_import(const ImportArguments& a, const ImportPlan& plan, const ImportScope& scope,
                   const ImportResult& result, double seconds, const std::string& command_line) {
  if (a.common.json) {
    Json j = summary_json(plan.series, result, seconds);
    if (scope.part) {
      const char* const key = a.resume.append ? "appended" : "part";
      j[key] = {{"first", scope.part->first}, {"last", scope.part->end - 1}};
      j[key]["read"] = {result.given.first, result.given.end - 1};
    }
    j["plan"] = plan_json(plan);
    j["output"] = a.output;
    j["command"] = command_line;
    print_json(j);
  } else if (!a.common.quiet) {
    print_summary(plan.series, result, seconds, a.output, command_line);
  }
}

Exit run_import(ImportArguments& a, const std::string& command_line) {
  check_outputs(a);
  a.settings.partial = partial_mode(a.resume), a.settings.live = a.resume.live;
  std::optional<PlanFile> planned;
  ErrorBound bound;
  if (a.follows_plan())
    planned = recall_plan(a);
  else
    bound = read_settings(a);

  // A quarter of the memory for frames being read, the rest for the library.
  a.reader.options.max_memory = a.common.max_memory / 4;
  const std::unique_ptr<FrameReader> reader = open_input(a);
  const SeriesDescription& s = reader->description();
  refuse_sources_as_output(a, s);
  if (!planned) a.settings.levels = read_levels(a, s.dims);
  const Device device = create_device(a.common.threads, a.common.max_memory - a.common.max_memory / 4);

  a.settings.own_air =
      appends_to_file(a) && !a.air ? air_in_file(device, a.output) : dense_air(*reader, a.settings);
  AppendedFile appended;
  if (appends_to_file(a)) a.settings.levels = levels_in_file(device, a.output);
  if (appends_to_file(a) && !a.dry_run)
    appended = open_appended(device, a.output, s, filtering_text(a.settings));
  if (appended.frames == s.dims[3]) {
    report_nothing_new(a, appended.frames);
    return Exit::ok;
  }

  ImportPlan plan{s, a.settings, {}, {}, {}, {}, {}, {}, {}, {}};
  plan.levels.automatic = !planned && a.auto_levels() && !appends_to_file(a);
  ImportScope scope;
  scope.output = a.output;
  scope.attributes = reader_attributes(a.reader);
  if (planned) {
    check_planned(*planned, a.plan, s);
    plan.scans = planned->scans;
    scope.sources = planned->sources;
    take_part(a, device, s, plan.scans, scope);
  } else {
    settle_import(*reader, device, find_unsettled(a, device, s, bound), a.settings, plan);
    // A bound is checked on every frame.
    if (appended.frames > 1 && !bound.any() && a.settings.measure != BCCSPLAT_MEASURE_ALL)
      scope.part = FrameSpan{appended.frames, s.dims[3]};
  }

  if (a.dry_run) {
    if (!a.plan.empty()) save_plan(a, plan);
    plan.estimate = estimate_import(*reader, device, a.settings, plan.scans);
    if (!planned && a.settings.ends != BCCSPLAT_ENDS_PERIODIC && a.part.empty() && !a.resume.append)
      plan.turn = measure_turn(*reader);
    if (!planned && a.settings.periodic == 0 && a.part.empty() && !a.resume.append)
      plan.round = measure_round(*reader);
    if (a.common.json)
      print_json(plan_json(plan));
    else
      print_plan(plan);
    return Exit::ok;
  }
  if (a.common.prints_text()) print_plan(plan);
  if (!planned) scope.sources = sources_of(s, appended.sources);

  const Progress clock("", 0, false, true);
  const ImportResult result = a.resume.append && scope.part
                                  ? append_series(*reader, device, a.settings, plan.scans, scope, a.common)
                                  : write_series(*reader, device, a.settings, plan.scans, scope, a.common);
  report_import(a, plan, scope, result, clock.seconds(), command_line);
  return Exit::ok;
}

// What the plan has decided cannot be typed again.
void refuse_planned_options(const CLI::App& import) {
  static const std::vector<std::string> allowed{"output", "plan",   "part",      "threads", "max-mem",
                                                "live",   "resume", "overwrite", "json",    "quiet"};
  for (const CLI::Option* option : import.get_options()) {
    if (option->count() == 0 || option->get_lnames().empty()) continue;
    const std::string& name = option->get_lnames().front();
    if (std::find(allowed.begin(), allowed.end(), name) == allowed.end())
      fail_usage("--", name, ": the plan decides that; make another plan for other options");
  }
}

} // namespace

Run add_import(CLI::App& app, std::string command_line) {
  auto a = std::make_shared<ImportArguments>();
  CLI::App& import = *app.add_subcommand("import", "Convert a series of volumes to a .bcc4 file");
  import.add_option("INPUT", a->reader.options.inputs,
                    "Files, a pattern such as smoke.%04d.vdb or smoke.####.vdb, a glob, or @LIST");
  import.add_option("-o,--output", a->output, "The .bcc4 file to write")->type_name("OUT.bcc4");
  add_reader_options(import, a->reader);
  add_number(import, "--air", a->air,
             "Value of empty space (default: the background of OpenVDB grids, else 0, and for floats of "
             "which next to none are 0 a value in their midst: near air constants ripple least)");
  add_number(import, "--air-threshold", a->air_threshold,
             "Samples within this of air are not stored (default 0: integers that equal air, and floats "
             "within 1/512 "
             "of what is near, the filter's ringing)");
  add_choice<int32_t>(import, "--on-nonfinite", a->settings.nonfinite, kNonfiniteChoices,
                      "NaN and infinities: stop, missing data, or air and the largest value");
  import
      .add_option(
          "--lattice", a->lattice,
          "auto (default): of a series D4* or the Cartesian lattice, with the distances along x, y, z and t "
          "that lose least; d4star, bcc (one frame) or cc: this one, with the distances of --scale")
      ->type_name("auto|d4star|bcc|cc");
  add_number(import, "--density", a->density,
             "Sites per source sample (default .5; bcc and cc as they have at distance 1)");
  import.add_flag(
      "--exact", a->exact,
      "Store samples as precisely as the source has its values (default: rounded where that adds next to "
      "nothing to the lattice's own error)");
  add_choice<int32_t>(import, "--filter", a->settings.filter, kFilterChoices,
                      "Resampling filter (default kaiser8)");
  import.add_flag("--lowpass", a->settings.lowpass,
                  "First remove the frequencies the lattice cannot hold (outside_cell of --dry-run)");
  add_choice<int32_t>(
      import, "--ends", a->settings.ends, kEndsChoices,
      "Before the first frame and after the last: as they foretell, with two layers more at "
      "each end (default on D4* from 14 frames on, at distance 1), the mirror image, or periodic: "
      "the last frame leads to the first, as of heart beats and climatologies");
  add_choice<int32_t>(
      import, "--faces", a->settings.faces, kFacesChoices,
      "Beyond the first and last sample along x, y and z: as those inside foretell, with two "
      "planes of the lattice more at each face, along all axes that are not short, or along these at "
      "any cost; or the mirror image (default: what does best on a sample, else as they foretell along "
      "axes of 43 samples or more)");
  add_choice<int32_t>(import, "--periodic", a->settings.periodic, kPeriodicChoices,
                      "Axes that go round, as longitude does: behind the last sample comes the first one "
                      "again, and there are "
                      "no faces (of time: --ends periodic)");
  import
      .add_option("--scale", a->scale,
                  "Lattice distance in source samples (default 1): of x, y and z, or one for each, and for t "
                  "in frames")
      ->type_name("S|X,Y,Z|X,Y,Z,T");
  import
      .add_option(
          "--time-scale", a->time_scale,
          "The same along time, in frames (default 1); auto: as coarse as the measured spectrum allows")
      ->type_name("X|auto");
  add_number(
      import, "--abs", a->abs,
      "No source sample is off by more than this: finds the coarsest coding, checks every frame, corrects "
      "what misses");
  add_number(import, "--psnr", a->psnr,
             "The same for a peak signal-to-noise ratio of the series in dB, such as 50");
  add_choice<int32_t>(import, "--measure", a->settings.measure, kMeasureChoices,
                      "Frames whose error against the source is reported (default some: three, evenly "
                      "spread; all with a bound)");
  add_choice<int32_t>(import, "--quantize", a->settings.quantize, kTypeChoices,
                      "Type of the stored values (default: the source's own precision)");
  add_choice<int32_t>(import, "--store", a->settings.store, kStoreChoices,
                      "Store samples, or coefficients of the kernel (default samples)");
  import
      .add_option("--levels", a->levels,
                  "Store coarser levels as well, each at twice the distance in space, for small pictures "
                  "(bcc4 render takes what is enough): so many, or auto (default): of frames of 192^3 and "
                  "more, but not of labels, until one is "
                  "below 96^3; --append keeps those of the file")
      ->type_name("auto|none|N");
  import.add_option("--kernel", a->settings.kernel, "Kernel recommended to readers")->type_name("NAME");
  add_threads(import, a->common);
  add_max_memory(import, a->common);
  import.add_flag("--dry-run", a->dry_run, "Only print how the input is read and what would come out");
  import
      .add_option(
          "--plan", a->plan,
          "With --dry-run: write what was decided to FILE. Else: import by that file, which also names "
          "the input")
      ->type_name("FILE.json");
  import
      .add_option("--part", a->part,
                  "With --plan: only frames A-B, counted from 0, or the K-th of N parts; bcc4 concat joins "
                  "the parts to the file that one process writes, byte for byte")
      ->type_name("A-B|K/N");
  import.add_flag("--overwrite", a->settings.overwrite, "Replace an existing output");
  add_resume_options(import, a->resume);
  import.add_flag("--json", a->common.json, "Report as JSON");
  import.add_flag("--quiet", a->common.quiet, "Print nothing but warnings and errors");
  return [a, &import, command_line = std::move(command_line)] {
    if (a->follows_plan()) refuse_planned_options(import);
    return run_import(*a, command_line);
  };
}

} // namespace bcc4

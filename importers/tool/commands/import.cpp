// SPDX-License-Identifier: Apache-2.0
// bcc4 import: a series of frames -> one .bcc4 file.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string_view>

#include "readers/open_series.h"
#include "readers/system.h"
#include "tool/cli.h"
#include "tool/commands/commands.h"
#include "tool/import/air_in_file.h"
#include "tool/import/append.h"
#include "tool/import/block.h"
#include "tool/import/estimate.h"
#include "tool/import/import_arguments.h"
#include "tool/import/part_argument.h"
#include "tool/import/part_frames.h"
#include "tool/import/plan.h"
#include "tool/import/plan_file.h"
#include "tool/import/plan_series.h"
#include "tool/import/precision.h"
#include "tool/import/sources.h"
#include "tool/import/summary.h"
#include "tool/json.h"
#include "tool/output/output_file.h"
#include "tool/progress.h"
#include "tool/run_watch.h"

namespace bcc4 {
namespace {

// The plan's options in the place of those typed; inputs that were typed replace the plan's.
PlanFile recall_plan(ImportArguments& a) {
  if (a.resume.append) fail_usage("--append reads a series without a plan");
  PlanFile plan = read_plan_file(a.plan);
  if (a.reader.options.inputs.empty()) a.reader.options.inputs = plan.inputs;
  for (const auto& [key, text] : plan.options) set_reader_option(a.reader, key, text);
  for (WriterSettings& s : plan.attempts) {
    s.overwrite = a.settings.overwrite, s.partial = a.settings.partial, s.live = a.settings.live;
    s.cancel_token = a.settings.cancel_token;
  }
  return plan;
}

std::unique_ptr<FrameReader> open_input(const ImportArguments& a) {
  std::unique_ptr<FrameReader> reader = open_series(a.reader.options);
  const SeriesDescription& s = reader->description();
  for (const std::string& warning : s.warnings) std::fprintf(stderr, "bcc4: warning: %s\n", warning.c_str());
  if (s.sparse && a.air)
    for (const Channel& c : s.channels)
      if (*a.air != c.air)
        fail_usage("--air ", *a.air, ": outside its active voxels grid \"", c.name, "\" has its background, ",
                   c.air);
  return reader;
}

void warn_of_precision(FrameReader& reader, Watch& watch) {
  for (const std::string& warning : precision_warnings(reader, watch))
    std::fprintf(stderr, "bcc4: warning: %s\n", warning.c_str());
}

void warn_of_scattered(const SeriesDescription& s) {
  std::fprintf(
      stderr,
      "bcc4: warning: next to nothing of a frame of %s is active: its parts lie far apart, and the work "
      "grows with the box around them; a file for each part is faster\n",
      concat(s.dims[0], " x ", s.dims[1], " x ", s.dims[2], " samples").c_str());
}

void refuse_sources_as_output(const ImportArguments& a, const SeriesDescription& s) {
  for (const SourceFile& f : s.files) {
    if (!a.dry_run) refuse_source_as_output(a.output, f.path);
    if (a.dry_run && !a.plan.empty()) refuse_source_as_output(a.plan, f.path);
  }
}

// A turn of an axis that goes round ends where it begins: files often have that place twice.
void refuse_place_twice(const ImportArguments& a, const SeriesDescription& s) {
  constexpr double turn = 360, rounding = 1e-3; // degrees; of a step
  for (size_t axis = 0; axis < 3; ++axis) {
    const std::string& own = s.places[axis].unit;
    const double step = std::abs(s.affine[5 * axis]), last = static_cast<double>(s.dims[axis] - 1);
    if ((a.periodic >> axis & 1) == 0 || !(own.empty() ? s.spatial_unit : own).starts_with("degree"))
      continue;
    if (std::abs(step * last - turn) <= rounding * step)
      fail_usage("--periodic: the last sample along ", "xyz"[axis],
                 " is 360 degrees from the first, and so the ",
                 "first once more: leave it out of the files (ncks -d lon,0,", s.dims[axis] - 2,
                 "), or leave out --periodic");
  }
}

bool appends_to_file(const ImportArguments& a) {
  std::error_code ignored;
  return a.resume.append && std::filesystem::exists(to_path(a.output), ignored);
}

void report_nothing_new(const ImportArguments& a, uint64_t frames) {
  if (a.common.json)
    print_json({{"output", a.output}, {"frames", frames}, {"appended", nullptr}});
  else if (!a.common.quiet)
    std::printf("%s: it has all %llu frames already\n", a.output.c_str(),
                static_cast<unsigned long long>(frames));
}

// A series that goes on has the lattice and the error of its file, which would not be found anew.
void refuse_other_choices(const ImportArguments& a) {
  const char* const option = a.abs ? "--abs" : a.psnr ? "--psnr" : a.density ? "--density" : nullptr;
  if (option && chooses_lattice(a))
    fail_usage(option, ": ", a.output,
               " goes on as it was made, with its own lattice and error: leave it out");
}

// Names the options that make a series unlike its file, where it could not go on so.
[[noreturn]] void refuse_unlike_file(const Command& import, const Error& e) {
  static constexpr const char* options[] = {"--lattice", "--scale",   "--time-scale", "--exact",   "--abs",
                                            "--psnr",    "--store",   "--quantize",   "--ends",    "--faces",
                                            "--levels",  "--lowpass", "--filter",     "--periodic"};
  std::vector<std::string> given;
  for (const OptionText& option : import.options())
    for (const char* const name : options)
      if (option.given && option.names.back() == name) given.emplace_back(name);
  throw Error(e.code(), concat(e.what(), given.empty() ? "" : ", or leave out ", join(given),
                               given.empty() ? "" : ": --append goes on as the file was made"));
}

// Returns what a plan is asked for, after what the file has that goes on; old: null for none.
PlanWish find_wish(ImportArguments& a, const Device& device, const Volume& old, const SeriesDescription& s,
                   bool bound) {
  PlanWish wish;
  wish.auto_time_scale = a.time_scale == "auto", wish.auto_levels = a.auto_levels() && !old;
  wish.density = a.density.value_or(0);
  wish.exact = a.exact;
  wish.everything = a.dry_run, wish.any_memory = a.common.max_memory > 0;
  for (const Channel& c : s.channels)
    wish.kinds.push_back(!c.labels ? 0 : *c.labels ? BCCSPLAT_CHANNEL_LABELS : BCCSPLAT_CHANNEL_QUANTITIES);
  if (!old || bound) return wish;
  if (a.settings.store != BCCSPLAT_STORE_WAVELETS) adopt_error(old, a.settings);
  if (chooses_lattice(a) && !a.density) adopt_lattice(device, old, a.settings, wish);
  if (!a.exact && a.quantize == BCCSPLAT_TYPE_DEFAULT) {
    adopt_steps(old, s, a.settings);
    wish.exact = true;
  }
  return wish;
}

// Frames that are means of others have labels of neither.
void refuse_blended_labels(const ImportPlan& plan) {
  const Json labels = plan.found.value("labels", Json::array());
  if (plan.series.blended && std::find(labels.begin(), labels.end(), Json(true)) != labels.end())
    fail_usage(plan.series.files.front().path,
               ": it has labels, and --gaps interpolate blends them: hold or skip");
}

// The part of a planned series that was asked for, none for all of it.
void take_part(const ImportArguments& a, const Device& device, const ImportPlan& plan, ImportScope& scope) {
  const SeriesDescription& s = plan.series;
  if (!a.block.empty()) scope.block = parse_block(a.block, s.dims);
  if (plan.settings().fixed_predictions && a.block.empty()) scope.block = parse_block_number(a.part, s.dims);
  if (a.part.empty() || (scope.block && a.block.empty())) return;
  scope.part = parse_part(a.part, s.dims[3]);
  scope.lead = lead_of(plan.found, part_frames(device, s, plan.settings(), *scope.part).first);
}

uint64_t memory_of_library(const ImportArguments& a) { return a.common.max_memory - a.common.max_memory / 4; }

// What an import may hold: without a limit half of what the machine has.
uint64_t memory_of_import(const ImportArguments& a) {
  return a.common.max_memory > 0 ? memory_of_library(a) : memory_limit({});
}

// Says how to go on where memory does not do, if blocks of space would.
[[noreturn]] void refuse_memory(const ImportArguments& a, bccsplat_store store, const Error& e) {
  WriterSettings typed = a.settings;
  typed.store = store;
  const bool open =
      a.block.empty() && a.part.empty() && a.plan.empty() && !a.resume.append && a.resume.live == 0;
  const std::string why = needs_whole_frames(typed);
  fail_resources(e.what(), advice_on(e.code()),
                 !open || a.blocks ? ""
                 : why.empty()     ? ", or give --blocks, which takes less at a time"
                                   : concat("; --blocks would take less at a time, but ", why));
}

// Frames are imported in blocks of space where that is asked for, where they do not fit the memory for
// reading, and where frames beyond 400^3 would not fit that of the library, if nothing needs whole ones.
void settle_blocks(const ImportArguments& a, const FrameReader& reader, WriterSettings& settings) {
  constexpr uint64_t small = 1 << 26; // samples
  const SeriesDescription& s = reader.description();
  WriterSettings whole = settings;
  if (a.auto_levels()) whole.levels = 1; // or more, of frames so large
  const bool large = !s.sparse && s.dims[0] * s.dims[1] * s.dims[2] > small &&
                     memory_of_frames(s, whole) > memory_of_import(a);
  const bool open = !a.resume.append && a.resume.live == 0;
  if (!a.blocks && reader.frames_fit() && !(large && open)) return;
  std::string why = needs_whole_frames(settings);
  if (why.empty() && !open && !a.blocks) why = "a series that goes on takes whole frames";
  if (a.blocks && !why.empty()) fail_usage("--blocks: ", why, "; divide the series by --part instead");
  if (!reader.frames_fit() && !why.empty())
    fail_resources(reader.frame_name(0), ": a frame is more than a quarter of the memory allowed, ",
                   "and blocks of it do not do, as ", why, ": raise --max-mem");
  if (why.empty()) settle_for_blocks(settings);
}

// The boxes that the series is imported in, one after the other: where frames do not fit the memory more than
// one; none where frames are imported as they are.
std::vector<SampleBox> blocks_of(const ImportArguments& a, const Device& device, const ImportPlan& plan,
                                 const ImportScope& scope) {
  if (!plan.settings().fixed_predictions || scope.part || scope.block || a.resume.append) return {};
  return blocks_that_fit(device, plan.series, plan.settings(), memory_of_import(a));
}

void save_plan(const ImportArguments& a, const ImportPlan& plan) {
  const SeriesDescription& s = plan.series;
  PlanFile file;
  file.inputs = a.reader.options.inputs;
  file.options = a.reader.texts;
  file.attempts = plan.attempts, file.found = plan.found;
  file.dims = s.dims;
  file.times = s.times.values;
  for (const Channel& c : s.channels) file.channels.push_back(c.name);
  file.sources = sources_of(s);
  make_absolute(file);
  write_plan_file(a.plan, file, a.overwrite);
}

// Ends a dry run: the plan is saved, completed by what is only told, and told.
Exit report_plan(const ImportArguments& a, FrameReader& reader, const Device& device, bool planned,
                 const ImportPlan& plan, Watch& watch) {
  if (!a.plan.empty()) save_plan(a, plan);
  DryRun run;
  // What is imported in blocks is not estimated: the sample would have to be, too.
  if (reader.frames_fit() && blocks_of(a, device, plan, {}).size() < 2)
    run.estimate = estimate_import(reader, device, plan);
  const bool whole = !planned && a.part.empty() && !a.resume.append;
  if (whole && plan.settings().ends != BCCSPLAT_ENDS_PERIODIC) run.turn = measure_turn(reader, watch);
  if (whole && a.periodic == 0 && plan.settings().periodic_axes == 0)
    run.round = measure_round(reader, watch);
  if (a.common.json)
    print_json(plan_json(plan, run));
  else
    print_plan(plan, run);
  return Exit::ok;
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
  a.settings.overwrite = a.overwrite ? 1 : 0, a.settings.cancel_token = interrupt_token();
  std::optional<PlanFile> planned;
  if (a.follows_plan())
    planned = recall_plan(a);
  else
    read_settings(a);
  const bool bound = a.abs || a.psnr || a.settings.store == BCCSPLAT_STORE_WAVELETS;
  RunWatch watch(a.common.prints_text());

  // A quarter of the memory for frames being read, the rest for the library.
  a.reader.options.max_memory = a.common.max_memory / 4;
  const Device device = create_device(a.common.threads, memory_of_library(a));
  std::unique_ptr<FrameReader> reader = open_input(a);
  Volume old; // the file that goes on
  if (appends_to_file(a)) {
    refuse_other_choices(a);
    old = open_volume(device, a.output, "");
    reader = continue_series(old, a.output, std::move(reader));
  }
  const SeriesDescription& s = reader->description();
  refuse_sources_as_output(a, s);
  refuse_place_twice(a, s);
  const bool scattered = is_scattered(s);
  if (!planned) warn_of_precision(*reader, watch);
  if (!planned) settle_blocks(a, *reader, a.settings);
  if (scattered && !a.common.quiet) warn_of_scattered(s);

  a.settings.values = read_channels(a, s);
  AppendedFile appended;
  if (old) {
    a.settings.levels = volume_info(old).level_count;
    if (told(old, kPredictions) == "fixed") a.settings.fixed_predictions = 1;
    if (!a.air) adopt_air(old, s, a.settings);
    if (!a.dry_run) appended = read_appended(old, a.output, s, filtering_text(a.settings));
    refuse_other_ends(device, old, a.output, a.settings);
  }
  if (appended.frames == s.dims[3]) {
    report_nothing_new(a, appended.frames);
    return Exit::ok;
  }

  ImportPlan plan{s};
  ImportScope scope;
  scope.output = a.output;
  scope.attributes = reader_attributes(a.reader);
  scope.kept = appended.attributes;
  if (planned) {
    check_planned(*planned, a.plan, s);
    plan.attempts = planned->attempts, plan.found = planned->found;
    scope.sources = planned->sources;
    take_part(a, device, plan, scope);
  } else {
    const PlanWish wish = find_wish(a, device, old, s, bound);
    old.reset(); // before it is replaced
    watch.clear();
    plan_series(*reader, device, a.settings, wish, a.dry_run ? "" : a.output, a.common.prints_text(), plan);
    refuse_blended_labels(plan);
    // A bound is checked on every frame.
    if (appended.frames > 1 && !bound && plan.settings().abs_error == 0 &&
        a.settings.measure != BCCSPLAT_MEASURE_ALL)
      scope.part = FrameSpan{appended.frames, s.dims[3]};
  }

  if (a.dry_run) return report_plan(a, *reader, device, planned.has_value(), plan, watch);
  if (a.common.prints_text()) print_plan(plan);
  if (!planned) scope.sources = sources_of(s, appended.sources);

  const Progress clock("", 0, false, true);
  const std::vector<SampleBox> blocks = blocks_of(a, device, plan, scope);
  const ImportResult result =
      !blocks.empty()                 ? write_blocks(*reader, device, plan.attempts, scope, a.common, blocks)
      : a.resume.append && scope.part ? append_series(*reader, device, plan.settings(), scope, a.common)
                                      : write_series(*reader, device, plan.attempts, scope, a.common);
  report_import(a, plan, scope, result, clock.seconds(), command_line);
  return Exit::ok;
}

// What the plan has decided cannot be typed again.
void refuse_planned_options(const Command& import) {
  static const std::vector<std::string> allowed{"--output",    "--plan",    "--part", "--block",
                                                "--threads",   "--max-mem", "--live", "--resume",
                                                "--overwrite", "--json",    "--quiet"};
  for (const OptionText& option : import.options()) {
    if (!option.given || option.is_argument()) continue;
    const auto is_allowed = [](const std::string& name) {
      return std::find(allowed.begin(), allowed.end(), name) != allowed.end();
    };
    if (std::none_of(option.names.begin(), option.names.end(), is_allowed))
      fail_usage(option.names.back(), ": the plan decides that; make another plan for other options");
  }
}

} // namespace

Run add_import(const Command& tool, std::string command_line) {
  auto a = std::make_shared<ImportArguments>();
  const Command import = tool.add_command(
      "import", "Convert a series of volumes to a .bcc4 file. Reads OpenVDB, NRRD, NIfTI, NetCDF, VTI, "
                "MetaImage, TIFF and raw files, and chooses the lattice that fits the data.");
  import.set_examples(
      {"bcc4 import smoke.*.raw --dims 64,64,64 --dtype f32 --dt 0.04 -o smoke.bcc4",
       "bcc4 import smoke.*.raw --dims 64,64,64 --dtype f32 --dt 0.04 --psnr 50 -o bound.bcc4",
       "bcc4 import smoke.*.raw --dims 64,64,64 --dtype f32 --dry-run"});
  add_import_options(import, *a);
  return [a, import, command_line = std::move(command_line)] {
    if (a->follows_plan()) refuse_planned_options(import);
    const bccsplat_store store = a->settings.store; // as typed
    try {
      return run_import(*a, command_line);
    } catch (const Error& e) {
      if (e.code() == Code::memory_budget) refuse_memory(*a, store, e);
      if (!a->kernel.empty()) refuse_kernel(e.code(), a->kernel);
      if (appends_to_file(*a) && std::string_view(e.what()).ends_with("import all anew"))
        refuse_unlike_file(import, e);
      throw;
    }
  };
}

} // namespace bcc4

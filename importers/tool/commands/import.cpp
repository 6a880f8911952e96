// bcc4 import: a series of frames -> one .bcc4 file.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>

#include "readers/open_series.h"
#include "readers/read_ahead.h"
#include "tool/commands/commands.h"
#include "tool/import/air.h"
#include "tool/import/append.h"
#include "tool/import/plan.h"
#include "tool/import/plan_file.h"
#include "tool/import/reader_arguments.h"
#include "tool/import/report.h"
#include "tool/import/resume.h"
#include "tool/import/sources.h"
#include "tool/import/summary.h"
#include "tool/import/writer_choices.h"
#include "tool/interrupt.h"
#include "tool/output/output_file.h"
#include "tool/progress.h"

namespace bcc4 {
namespace {

constexpr uint64_t kSampledFrames = 8; // go through the writer for an estimate

struct ImportArguments {
  ReaderArguments reader;
  WriterSettings settings;
  CommonOptions common;
  std::optional<double> air, air_threshold, scale, abs, psnr;
  std::string time_scale; // a number, or auto
  std::string output;
  bool dry_run = false;
  std::string plan, part; // file; frames as typed
  ResumeArguments resume;
  ImportArguments() { settings.measure = BCCSPLAT_MEASURE_SOME; }
};

std::vector<ChannelScan> scan_series(FrameReader& reader, const ImportArguments& a) {
  const SeriesDescription& s = reader.description();
  std::vector<ChannelScan> scans(s.channels.size());
  Progress progress("scan", source_bytes(s), true, a.common.quiet || a.common.json);
  ReadAhead frames(reader);
  uint64_t done = 0;
  for (uint64_t f = 0; f < s.dims[3]; ++f)
    for (size_t c = 0; c < s.channels.size(); ++c) {
      stop_if_interrupted();
      scan_frame(frames.next(), f, s.dims, air_of(s.channels[c], a.settings), a.settings.air_threshold,
                 scans[c]);
      progress.update(done += frame_bytes(s, c), concat("frame ", f + 1, "/", s.dims[3]));
    }
  return scans;
}

ImportEstimate estimate(FrameReader& reader, const Device& device, const ImportArguments& a,
                        const std::vector<ChannelScan>& scans) {
  const SeriesDescription& s = reader.description();
  ImportEstimate e;
  // As a part that is the whole, whose layers are known beforehand, whatever becomes of what is not finite.
  WriterSettings settings = a.settings;
  settings.nonfinite = BCCSPLAT_NONFINITE_DEFAULT;
  auto whole = sized<bccsplat_series_part>();
  whole.end = s.dims[3], whole.times = s.times.values.data();
  e.sites = lattice_sites(
                create_writer(device, "", s, settings, scans, s.dims[3], s.dims[3] > 1 ? &whole : nullptr)) *
            s.channels.size();
  e.sampled_frames = std::min(s.dims[3], kSampledFrames);
  // The middle frames: the first ones of a simulation are often empty. Too many of them not finite is no
  // reason to stop before the plan has been shown.
  settings.nonfinite =
      a.settings.nonfinite == BCCSPLAT_NONFINITE_DEFAULT ? BCCSPLAT_NONFINITE_HOLE : a.settings.nonfinite;
  settings.psnr = 0; // a goal of the series
  if (settings.abs_error == 0) settings.measure = BCCSPLAT_MEASURE_SOME;
  const Writer writer = create_writer(device, "", s, settings, scans, e.sampled_frames);
  const uint64_t first = (s.dims[3] - e.sampled_frames) / 2;
  const Progress clock("", 0, false, true);
  uint64_t frame_peak = 0;
  for (uint64_t f = 0; f < e.sampled_frames; ++f)
    for (size_t c = 0; c < s.channels.size(); ++c) {
      stop_if_interrupted();
      const Frame frame = reader.read(first + f, c);
      uint64_t bytes = 0;
      for (const auto& storage : frame.storage) bytes += storage->size();
      frame_peak = std::max(frame_peak, bytes);
      add_frame(writer, static_cast<uint32_t>(c), s.times.values[first + f], frame,
                reader.frame_name(first + f));
    }
  auto report = sized<bccsplat_writer_report>();
  check(bccsplat_writer_finish(writer.get(), &report), "");
  e.errors = measured_errors(writer, s.channels.size(), report.frames_measured).series;
  auto info = sized<bccsplat_device_info>();
  check(bccsplat_device_get_info(device.get(), &info), "");
  const double share = static_cast<double>(s.dims[3]) / static_cast<double>(e.sampled_frames);
  e.seconds = clock.seconds() * share;
  e.bytes_file = static_cast<double>(report.bytes_file) * share;
  e.bytes_memory = static_cast<double>(info.memory_peak + 2 * frame_peak); // one frame in use, one read ahead
  return e;
}

// How frames become layers, where it is not the usual way; nothing else in a file tells.
std::string filtering_text(const WriterSettings& settings) {
  std::string text;
  for (const auto& [name, filter] : kFilterChoices)
    if (filter == settings.filter && filter != BCCSPLAT_FILTER_KAISER8) text = name;
  return settings.lowpass ? text + (text.empty() ? "lowpass" : ", lowpass") : text;
}

void record_origin(const Writer& writer, const SeriesDescription& s, const ImportArguments& a,
                   const std::vector<PlannedSource>& sources) {
  const auto attribute = [&](const std::string& key, const std::string& value) {
    check(bccsplat_writer_set_attribute(writer.get(), key.c_str(), value.c_str()), key);
  };
  attribute("import.format", s.format);
  attribute("import.times", s.times.origin);
  if (const std::string filtering = filtering_text(a.settings); !filtering.empty())
    attribute("import.filtering", filtering);
  for (const auto& [key, value] : s.attributes) attribute(key, value);
  for (const auto& [key, value] : reader_attributes(a.reader)) attribute(key, value);
  for (const PlannedSource& f : sources)
    check(bccsplat_writer_add_source(writer.get(), f.name.c_str(), f.bytes, f.crc32), f.name);
}

// What a run reads and writes: all of the series, or a part of it.
struct ImportScope {
  const std::vector<PlannedSource>& sources;
  std::optional<FrameSpan> part;
  uint64_t lead = 0;
};

Import write_series(FrameReader& reader, const Device& device, const ImportArguments& a,
                    const std::vector<ChannelScan>& scans, const ImportScope& scope) {
  const SeriesDescription& s = reader.description();
  auto part = sized<bccsplat_series_part>();
  if (scope.part) {
    part.first = scope.part->first, part.end = scope.part->end;
    part.lead = scope.lead;
    part.times = s.times.values.data();
  }
  UnfinishedImport unfinished(a.output, a.common.quiet);
  const Writer writer =
      create_writer(device, a.output, s, a.settings, scans, s.dims[3], scope.part ? &part : nullptr);
  record_origin(writer, s, a, scope.sources);
  FrameSpan given;
  check(bccsplat_writer_get_part_frames(writer.get(), &given.first, &given.end), "");
  Progress progress("import", source_bytes(s) / s.dims[3] * (given.end - given.first), true,
                    a.common.quiet || a.common.json);
  ReadAhead frames(reader, given.first, given.end);
  uint64_t done = 0;
  for (uint64_t f = given.first; f < given.end; ++f)
    for (size_t c = 0; c < s.channels.size(); ++c) {
      stop_if_interrupted();
      add_frame(writer, static_cast<uint32_t>(c), s.times.values[f], frames.next(), reader.frame_name(f));
      progress.update(done += frame_bytes(s, c), concat("frame ", f + 1, "/", s.dims[3]));
    }
  Import done_import;
  done_import.given = given;
  check(bccsplat_writer_finish(writer.get(), &done_import.report), a.output);
  unfinished.finished();
  done_import.errors = measured_errors(writer, s.channels.size(), done_import.report.frames_measured);
  return done_import;
}

// A file that does not tell all that its continuation needs to know is made anew from all frames.
Import append_series(FrameReader& reader, const Device& device, const ImportArguments& a,
                     const std::vector<ChannelScan>& scans, const ImportScope& scope) {
  try {
    return write_series(reader, device, a, scans, scope);
  } catch (const StatusError& e) {
    if (e.status() != BCCSPLAT_ERROR_WRONG_STATE) throw;
    if (!a.common.quiet && !a.common.json) std::printf("  %s\n  reading all frames\n", e.what());
  }
  return write_series(reader, device, a, scans, {scope.sources, std::nullopt, 0});
}

// The sample may have promised a PSNR that the series does not keep: then its samples are corrected.
Import write_bounded(FrameReader& reader, const Device& device, ImportArguments& a,
                     const std::vector<ChannelScan>& scans, const ImportScope& scope) {
  try {
    return write_series(reader, device, a, scans, scope);
  } catch (const StatusError& e) {
    if (e.status() != BCCSPLAT_ERROR_BOUND_NOT_MET || a.settings.psnr == 0 || a.settings.abs_error > 0 ||
        peak_of(scans) == 0)
      throw;
    if (!a.common.quiet && !a.common.json) std::printf("  %s; again with corrections\n", e.what());
  }
  a.settings.abs_error = 1.5 * peak_of(scans) * std::pow(10, -a.settings.psnr / 20);
  return write_series(reader, device, a, scans, scope);
}

// Checks what was typed about the writer and completes its settings.
ErrorBound read_settings(ImportArguments& a) {
  a.settings.air = a.air;
  a.settings.air_threshold = a.air_threshold.value_or(0);
  a.settings.scale = a.scale.value_or(0);
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
  if (a.scale && !(*a.scale > 0)) fail_usage("--scale must be positive");
  return {a.abs.value_or(0), a.psnr.value_or(0)};
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

// Scans the series as far as the settings leave something to find out, and completes them.
void settle(FrameReader& reader, const Device& device, ImportArguments& a, const ErrorBound& bound,
            ImportPlan& plan) {
  const SeriesDescription& s = reader.description();
  const bool auto_time = a.time_scale == "auto";
  const bool ranged = std::any_of(s.channels.begin(), s.channels.end(),
                                  [&](const Channel& c) { return needs_range(c, a.settings); });
  if (a.dry_run || ranged || bound.any() || auto_time) plan.scans = scan_series(reader, a);
  std::vector<double> air;
  for (const Channel& c : s.channels) air.push_back(air_of(c, a.settings));
  if (a.dry_run || auto_time) plan.spectrum.emplace(sample_series(reader, air, {64, 32, 1}), air);
  if (auto_time)
    a.settings.time_scale = proven_time_scale(device, s, sample_series(reader, air, {48, 32, 1}), a.settings,
                                              advise(*plan.spectrum, s.dims[3]).time_scale, plan.scans);
  if (!bound.any()) return;
  plan.search = search_coding(device, s, sample_series(reader, air, {}), a.settings, bound, plan.scans);
  a.settings = apply_coding(a.settings, plan.search->chosen(), bound);
}

std::string absolute(const std::string& path) {
  if (path.starts_with("@")) return "@" + absolute(path.substr(1));
  return std::filesystem::absolute(path).string();
}

void save_plan(const ImportArguments& a, const ImportPlan& plan) {
  const SeriesDescription& s = plan.series;
  PlanFile file;
  for (const std::string& input : a.reader.options.inputs) file.inputs.push_back(absolute(input));
  file.options = a.reader.texts;
  std::error_code ignored;
  for (auto& [key, text] : file.options)
    if (key == "times" && std::filesystem::exists(text, ignored)) text = absolute(text);
  file.settings = a.settings;
  file.dims = s.dims;
  file.times = s.times.values;
  for (const Channel& c : s.channels) file.channels.push_back(c.name);
  file.sources = sources_of(s);
  file.scans = plan.scans;
  write_plan_file(a.plan, file, a.settings.overwrite);
}

// The plan's options in the place of those typed; inputs that were typed stand for the plan's.
PlanFile recall_plan(ImportArguments& a) {
  PlanFile plan = read_plan_file(a.plan);
  if (a.reader.options.inputs.empty()) a.reader.options.inputs = plan.inputs;
  for (const auto& [key, text] : plan.options) set_reader_option(a.reader, key, text);
  const WriterSettings typed = a.settings;
  a.settings = plan.settings;
  a.settings.overwrite = typed.overwrite, a.settings.partial = typed.partial;
  return plan;
}

Exit run_import(ImportArguments& a, const std::string& command_line) {
  if (!a.dry_run) {
    require(a.output, "-o", "-o out.bcc4");
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
  a.settings.partial = partial_mode(a.resume);
  std::optional<PlanFile> planned;
  ErrorBound bound;
  if (!a.plan.empty() && !a.dry_run) {
    if (a.resume.append) fail_usage("--append reads a series without a plan");
    planned = recall_plan(a);
  } else {
    bound = read_settings(a);
  }
  // A quarter of the memory for frames being read, the rest for the library.
  a.reader.options.max_memory = a.common.max_memory / 4;
  const std::unique_ptr<FrameReader> reader = open_input(a);
  const SeriesDescription& s = reader->description();
  for (const SourceFile& f : s.files) {
    if (!a.dry_run) refuse_source_as_output(a.output, f.path);
    if (a.dry_run && !a.plan.empty()) refuse_source_as_output(a.plan, f.path);
  }
  const Device device = create_device(a.common.threads, a.common.max_memory - a.common.max_memory / 4);
  if (a.resume.append && !a.air && std::filesystem::exists(a.output))
    a.settings.own_air = air_in_file(device, a.output);
  else
    a.settings.own_air = dense_air(*reader, a.settings);
  std::error_code none;
  AppendedFile appended;
  if (a.resume.append && !a.dry_run && std::filesystem::exists(a.output, none)) {
    appended = open_appended(device, a.output, s, filtering_text(a.settings));
    if (appended.frames == s.dims[3]) {
      if (a.common.json)
        print_json({{"output", a.output}, {"frames", appended.frames}, {"appended", nullptr}});
      else if (!a.common.quiet)
        std::printf("%s: it has all %llu frames already\n", a.output.c_str(),
                    static_cast<unsigned long long>(appended.frames));
      return Exit::ok;
    }
  }
  ImportPlan plan{s, a.settings, {}, {}, {}, {}};
  std::vector<PlannedSource> sources;
  ImportScope scope{sources, {}, 0};
  if (planned) {
    check_planned(*planned, a.plan, s);
    plan.scans = planned->scans;
    sources = planned->sources;
    if (!a.part.empty()) {
      scope.part = parse_part(a.part, s.dims[3]);
      const auto [first, end] = *scope.part;
      scope.lead = lead_of(*planned, part_frames(device, s, a.settings, plan.scans, first, end).first);
    }
  } else {
    settle(*reader, device, a, bound, plan);
    // A bound is checked on every frame, and coefficients hang on more of them.
    if (appended.frames > 1 && !bound.any() && a.settings.measure != BCCSPLAT_MEASURE_ALL &&
        a.settings.store != BCCSPLAT_STORE_COEFFICIENTS)
      scope.part = FrameSpan{appended.frames, s.dims[3]};
  }
  if (a.dry_run) {
    if (!a.plan.empty()) save_plan(a, plan);
    plan.estimate = estimate(*reader, device, a, plan.scans);
    if (a.common.json)
      print_json(plan_json(plan));
    else
      print_plan(plan);
    return Exit::ok;
  }
  if (!a.common.json && !a.common.quiet) print_plan(plan);
  if (!planned) sources = sources_of(s, appended.sources);
  const Progress clock("", 0, false, true);
  const Import import = a.resume.append && scope.part ? append_series(*reader, device, a, plan.scans, scope)
                                                      : write_bounded(*reader, device, a, plan.scans, scope);
  if (a.common.json) {
    Json j = summary_json(s, import, clock.seconds());
    if (scope.part) {
      const char* const key = a.resume.append ? "appended" : "part";
      j[key] = {{"first", scope.part->first}, {"last", scope.part->end - 1}};
      j[key]["read"] = {import.given.first, import.given.end - 1};
    }
    j["plan"] = plan_json(plan);
    j["output"] = a.output;
    j["command"] = command_line;
    print_json(j);
  } else if (!a.common.quiet) {
    print_summary(s, import, clock.seconds(), a.output, command_line);
  }
  return Exit::ok;
}

// What the plan has decided cannot be typed again.
void refuse_planned_options(const CLI::App& import) {
  static const std::vector<std::string> allowed{"output", "plan",      "part", "threads", "max-mem",
                                                "resume", "overwrite", "json", "quiet"};
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
             "Samples within this of air are not stored (default 0: exact)");
  add_choice<int32_t>(import, "--on-nonfinite", a->settings.nonfinite, kNonfiniteChoices,
                      "NaN and infinities: stop, missing data, or air and the largest value");
  add_choice<int32_t>(import, "--lattice", a->settings.lattice, kLatticeChoices,
                      "Lattice (default d4star, bcc for one frame)");
  add_choice<int32_t>(import, "--filter", a->settings.filter, kFilterChoices,
                      "Resampling filter (default kaiser8)");
  import.add_flag("--lowpass", a->settings.lowpass,
                  "First remove the frequencies the lattice cannot hold (outside_cell of --dry-run)");
  add_choice<int32_t>(import, "--ends", a->settings.ends,
                      {{"predict", BCCSPLAT_ENDS_PREDICT}, {"mirror", BCCSPLAT_ENDS_MIRROR}},
                      "Before the first frame and after the last: as they foretell, with four layers more at "
                      "each end (default from 23 frames on), or the mirror image");
  add_number(import, "--scale", a->scale, "Lattice distance in source samples (default 1)");
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
  add_choice<int32_t>(
      import, "--measure", a->settings.measure, kMeasureChoices,
      "Frames whose error against the source is reported (default some: three; all with a bound)");
  add_choice<int32_t>(import, "--quantize", a->settings.quantize, kTypeChoices,
                      "Type of the stored values (default: the source's own precision)");
  add_choice<int32_t>(import, "--store", a->settings.store, kStoreChoices,
                      "Store samples, or coefficients of the kernel (default samples)");
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
    if (!a->plan.empty() && !a->dry_run) refuse_planned_options(import);
    return run_import(*a, command_line);
  };
}

} // namespace bcc4

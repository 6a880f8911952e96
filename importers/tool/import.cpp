// bcc4 import: a series of frames -> one .bcc4 file.
#include <sys/resource.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>

#include "readers/byte_stream.h"
#include "readers/open_series.h"
#include "readers/read_ahead.h"
#include "tool/commands.h"
#include "tool/import_plan.h"
#include "tool/interrupt.h"
#include "tool/progress.h"
#include "tool/reader_arguments.h"
#include "tool/resume.h"

namespace bcc4 {
namespace {

constexpr uint64_t kSampledFrames = 8;               // go through the writer for an estimate
constexpr uint64_t kHashedBytes = uint64_t{1} << 32; // sources in all up to this size get a CRC-32

struct ImportArguments {
  ReaderArguments reader;
  WriterSettings settings;
  CommonOptions common;
  std::optional<double> air, air_threshold, scale, time_scale;
  std::string output;
  bool dry_run = false;
  ResumeArguments resume;
};

// Of this program alone. ru_maxrss would do, but on Linux it starts from the memory of the process that
// started us.
uint64_t peak_memory() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    const auto words = split(line);
    if (words.size() > 1 && words[0] == "VmHWM:") return parse_number<uint64_t>(words[1]).value_or(0) * 1024;
  }
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<uint64_t>(usage.ru_maxrss) * 1024;
}

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
  e.sites = lattice_sites(create_writer(device, "", s, a.settings, scans, s.dims[3])) * s.channels.size();
  e.sampled_frames = std::min(s.dims[3], kSampledFrames);
  // The middle frames: the first ones of a simulation are often empty. Too many of them not finite is no
  // reason to stop before the plan has been shown.
  WriterSettings settings = a.settings;
  if (settings.nonfinite == BCCSPLAT_NONFINITE_DEFAULT) settings.nonfinite = BCCSPLAT_NONFINITE_HOLE;
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
  auto info = sized<bccsplat_device_info>();
  check(bccsplat_device_get_info(device.get(), &info), "");
  const double share = static_cast<double>(s.dims[3]) / static_cast<double>(e.sampled_frames);
  e.seconds = clock.seconds() * share;
  e.bytes_file = static_cast<double>(report.bytes_file) * share;
  e.bytes_memory = static_cast<double>(info.memory_peak + 2 * frame_peak); // one frame in use, one read ahead
  return e;
}

uint32_t file_crc(const std::string& path) {
  InputFile file(path);
  Bytes chunk(1 << 20);
  uLong crc = crc32(0, nullptr, 0);
  for (uint64_t at = 0; at < file.size();) {
    stop_if_interrupted();
    const size_t got = file.read_some(at, chunk);
    if (got == 0) break;
    crc = crc32(crc, reinterpret_cast<const Bytef*>(chunk.data()), static_cast<uInt>(got));
    at += got;
  }
  return static_cast<uint32_t>(crc);
}

void record_origin(const Writer& writer, const SeriesDescription& s, const ImportArguments& a) {
  const auto attribute = [&](const std::string& key, const std::string& value) {
    check(bccsplat_writer_set_attribute(writer.get(), key.c_str(), value.c_str()), key);
  };
  attribute("import.format", s.format);
  attribute("import.times", s.times.origin);
  for (const auto& [key, value] : s.attributes) attribute(key, value);
  for (const auto& [key, value] : reader_attributes(a.reader)) attribute(key, value);
  uint64_t total = 0;
  for (const SourceFile& f : s.files) total += f.bytes;
  for (const SourceFile& f : s.files) {
    const std::string name = std::filesystem::path(f.path).filename().string();
    check(bccsplat_writer_add_source(writer.get(), name.c_str(), f.bytes,
                                     total <= kHashedBytes ? file_crc(f.path) : 0),
          name);
  }
}

bccsplat_writer_report write_series(FrameReader& reader, const Device& device, const ImportArguments& a,
                                    const std::vector<ChannelScan>& scans) {
  const SeriesDescription& s = reader.description();
  UnfinishedImport unfinished(a.output, a.common.quiet);
  const Writer writer = create_writer(device, a.output, s, a.settings, scans, s.dims[3]);
  record_origin(writer, s, a);
  Progress progress("import", source_bytes(s), true, a.common.quiet || a.common.json);
  ReadAhead frames(reader);
  uint64_t done = 0;
  for (uint64_t f = 0; f < s.dims[3]; ++f)
    for (size_t c = 0; c < s.channels.size(); ++c) {
      stop_if_interrupted();
      add_frame(writer, static_cast<uint32_t>(c), s.times.values[f], frames.next(), reader.frame_name(f));
      progress.update(done += frame_bytes(s, c), concat("frame ", f + 1, "/", s.dims[3]));
    }
  auto report = sized<bccsplat_writer_report>();
  check(bccsplat_writer_finish(writer.get(), &report), a.output);
  unfinished.finished();
  return report;
}

void print_report(const SeriesDescription& s, const bccsplat_writer_report& r, double seconds,
                  const std::string& output, const std::string& command_line) {
  uint64_t in = 0;
  for (const SourceFile& f : s.files) in += f.bytes;
  const auto ratio = [](uint64_t a, uint64_t b) {
    return static_cast<double>(a) / static_cast<double>(std::max<uint64_t>(1, b));
  };
  std::printf("%s: %s of values (%s on disk) -> %s, ratio %s (%s to the source files)\n", output.c_str(),
              byte_text(static_cast<double>(r.bytes_source)).c_str(),
              byte_text(static_cast<double>(in)).c_str(),
              byte_text(static_cast<double>(r.bytes_file)).c_str(),
              short_number(ratio(r.bytes_source, r.bytes_file), 3).c_str(),
              short_number(ratio(in, r.bytes_file), 3).c_str());
  std::printf("  %llu samples -> %llu sites (%s), %llu stored (%s %%)\n",
              static_cast<unsigned long long>(r.cc_samples), static_cast<unsigned long long>(r.sites_total),
              short_number(ratio(r.sites_total, r.cc_samples), 4).c_str(),
              static_cast<unsigned long long>(r.sites_kept),
              short_number(100 * ratio(r.sites_kept, r.sites_total), 4).c_str());
  if (r.nonfinite > 0)
    std::printf("  %llu source values were not finite\n", static_cast<unsigned long long>(r.nonfinite));
  if (r.clamped > 0)
    std::printf("  %llu values clamped to the range of the stored type\n",
                static_cast<unsigned long long>(r.clamped));
  std::printf("  %s s, %s MB/s, peak memory %s\n", short_number(seconds, 3).c_str(),
              short_number(static_cast<double>(r.bytes_source) / std::max(seconds, 1e-9) / 1e6, 3).c_str(),
              byte_text(static_cast<double>(peak_memory())).c_str());
  std::printf("  again: %s\n", command_line.c_str());
}

Json report_json(const bccsplat_writer_report& r, double seconds) {
  return {{"frames", r.frames},
          {"cc_samples", r.cc_samples},
          {"cc_relevant", r.cc_relevant},
          {"sites_total", r.sites_total},
          {"sites_kept", r.sites_kept},
          {"holes", r.holes},
          {"clamped", r.clamped},
          {"nonfinite", r.nonfinite},
          {"bytes",
           {{"source", r.bytes_source},
            {"file", r.bytes_file},
            {"runs", r.bytes_runs},
            {"values", r.bytes_values},
            {"index", r.bytes_index}}},
          {"seconds", seconds},
          {"peak_memory", peak_memory()}};
}

Exit run_import(ImportArguments& a, const std::string& command_line) {
  if (!a.dry_run) {
    require(a.output, "-o", "-o out.bcc4");
    std::error_code ignored;
    if (!a.settings.overwrite && !a.resume.append && std::filesystem::exists(a.output, ignored))
      fail_usage(a.output, ": exists already; --overwrite replaces it");
  }
  a.settings.partial = partial_mode(a.resume);
  a.settings.air = a.air;
  a.settings.air_threshold = a.air_threshold.value_or(0);
  a.settings.scale = a.scale.value_or(0);
  a.settings.time_scale = a.time_scale.value_or(0);
  if (!(a.settings.air_threshold >= 0)) fail_usage("--air-threshold must not be negative");
  if (a.scale && !(*a.scale > 0)) fail_usage("--scale must be positive");
  if (a.time_scale && !(*a.time_scale > 0)) fail_usage("--time-scale must be positive");
  // A quarter of the memory for frames being read, the rest for the library.
  a.reader.options.max_memory = a.common.max_memory / 4;

  const std::unique_ptr<FrameReader> reader = open_series(a.reader.options);
  const SeriesDescription& s = reader->description();
  for (const std::string& warning : s.warnings) std::fprintf(stderr, "bcc4: warning: %s\n", warning.c_str());
  if (s.sparse && a.air)
    for (const Channel& c : s.channels)
      if (*a.air != c.air)
        fail_usage("--air ", *a.air, ": outside its active voxels grid \"", c.name, "\" has its background, ",
                   c.air);

  const Device device = create_device(a.common.threads, a.common.max_memory - a.common.max_memory / 4);
  ImportPlan plan{s, a.settings, {}, {}};
  const bool ranged = std::any_of(s.channels.begin(), s.channels.end(),
                                  [&](const Channel& c) { return needs_range(c, a.settings); });
  if (a.dry_run || ranged) plan.scans = scan_series(*reader, a);
  if (a.dry_run) {
    plan.estimate = estimate(*reader, device, a, plan.scans);
    if (a.common.json)
      print_json(plan_json(plan));
    else
      print_plan(plan);
    return Exit::ok;
  }
  if (!a.common.json && !a.common.quiet) print_plan(plan);
  const Progress clock("", 0, false, true);
  const bccsplat_writer_report report = write_series(*reader, device, a, plan.scans);
  if (a.common.json) {
    Json j = report_json(report, clock.seconds());
    j["plan"] = plan_json(plan);
    j["output"] = a.output;
    j["command"] = command_line;
    print_json(j);
  } else if (!a.common.quiet) {
    print_report(s, report, clock.seconds(), a.output, command_line);
  }
  return Exit::ok;
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
             "Value of empty space (default: the background of OpenVDB grids, else 0)");
  add_number(import, "--air-threshold", a->air_threshold,
             "Samples within this of air are not stored (default 0: exact)");
  add_choice<int32_t>(import, "--on-nonfinite", a->settings.nonfinite,
                      {{"error", BCCSPLAT_NONFINITE_ERROR},
                       {"hole", BCCSPLAT_NONFINITE_HOLE},
                       {"clamp", BCCSPLAT_NONFINITE_CLAMP}},
                      "NaN and infinities: stop, missing data, or air and the largest value");
  add_choice<int32_t>(
      import, "--lattice", a->settings.lattice,
      {{"d4star", BCCSPLAT_LATTICE_D4STAR}, {"bcc", BCCSPLAT_LATTICE_BCC}, {"cc", BCCSPLAT_LATTICE_CC}},
      "Lattice (default d4star, bcc for one frame)");
  add_choice<int32_t>(import, "--filter", a->settings.filter,
                      {{"kaiser8", BCCSPLAT_FILTER_KAISER8},
                       {"kaiser6", BCCSPLAT_FILTER_KAISER6},
                       {"bspline3", BCCSPLAT_FILTER_BSPLINE3}},
                      "Resampling filter (default kaiser8)");
  add_number(import, "--scale", a->scale, "Lattice distance in source samples (default 1)");
  add_number(import, "--time-scale", a->time_scale, "The same along time, in frames (default 1)");
  add_choice<int32_t>(import, "--quantize", a->settings.quantize,
                      {{"u8", BCCSPLAT_TYPE_U8},
                       {"u16", BCCSPLAT_TYPE_U16},
                       {"f16", BCCSPLAT_TYPE_F16},
                       {"f32", BCCSPLAT_TYPE_F32}},
                      "Type of the stored values (default: the source's own precision)");
  add_choice<int32_t>(import, "--store", a->settings.store,
                      {{"samples", BCCSPLAT_STORE_SAMPLES}, {"coefficients", BCCSPLAT_STORE_COEFFICIENTS}},
                      "Store samples, or coefficients of the kernel (default samples)");
  import.add_option("--kernel", a->settings.kernel, "Kernel recommended to readers")->type_name("NAME");
  add_threads(import, a->common);
  add_max_memory(import, a->common);
  import.add_flag("--dry-run", a->dry_run, "Only print how the input is read and what would come out");
  import.add_flag("--overwrite", a->settings.overwrite, "Replace an existing output");
  add_resume_options(import, a->resume);
  import.add_flag("--json", a->common.json, "Report as JSON");
  import.add_flag("--quiet", a->common.quiet, "Print nothing but warnings and errors");
  return [a, command_line = std::move(command_line)] { return run_import(*a, command_line); };
}

} // namespace bcc4

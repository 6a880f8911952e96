// SPDX-License-Identifier: Apache-2.0
// bcc4 export: frames back on the source grid, as files of other formats.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>

#include "readers/sequence.h"
#include "readers/system.h"
#include "tool/cli.h"
#include "tool/commands/commands.h"
#include "tool/interrupt.h"
#include "tool/output/exporter.h"
#include "tool/output/output_file.h"
#include "tool/output/vti_output.h"
#include "tool/progress.h"
#include "tool/view/slice_choice.h"
#include "tool/view/time_slice.h"

namespace bcc4 {
namespace {

struct ExportArguments {
  std::string file, output, kernel, channel;
  SliceChoiceArguments which;
  bool all = false, salvage = false;
  ExportOptions options;
  CommonOptions common;
};

constexpr const char* kCollection = ".pvd";

bool names_collection(const std::string& output) { return lower(output).ends_with(kCollection); }

// One file per frame goes into a folder or to a pattern; a plain name is one file for all.
std::string output_pattern(const ExportArguments& a, const std::string& suffix) {
  std::error_code ignored;
  if (has_frame_pattern(a.output)) return a.output;
  const std::filesystem::path out = to_path(a.output);
  const bool folder =
      a.output.ends_with('/') || std::filesystem::is_directory(out, ignored) || out.extension().empty();
  if (!folder) return "";
  std::filesystem::create_directories(out, ignored);
  return to_text(out / to_path(concat(to_text(to_path(a.file).stem()), ".%04d", suffix)));
}

ExportFormat format_of(const ExportArguments& a) {
  if (a.options.format != ExportFormat::unset) return a.options.format;
  const ExportFormat format = format_of_suffix(a.output);
  if (format == ExportFormat::unset)
    fail_usage(
        "-o ", a.output,
        ": its suffix names no format that export writes (.nrrd, .vdb, .nii, .nii.gz, .nc, .vti, .pvd, "
        ".tif, .raw); --format chooses one of a name without suffix, such as a folder");
  return format;
}

// Opens the file with what is damaged as missing data, and warns of that.
Volume open_salvaged(const Device& device, const ExportArguments& a) {
  auto options = sized<bccsplat_volume_options>();
  options.kernel = a.kernel.empty() ? nullptr : a.kernel.c_str();
  options.salvage = 2; // a disk with bad sectors as well
  bccsplat_volume* raw = nullptr;
  check_kernel(bccsplat_volume_open_file(device.get(), a.file.c_str(), &options, &raw), a.file, a.kernel);
  Volume volume(raw);
  auto report = sized<bccsplat_verify_report>();
  check(bccsplat_volume_verify(raw, nullptr, nullptr, &report), a.file);
  if (report.damages == 0) std::fprintf(stderr, "bcc4: %s: no damage\n", a.file.c_str());
  return volume;
}

// Exports every frame into a file of its own.
void export_files(Exporter& exporter, const Volume& volume, const std::string& pattern, bool overwrite,
                  Progress& progress) {
  const uint64_t frames = volume_info(volume).dims[3];
  for (uint64_t f = 0; f < frames; ++f) refuse_existing(apply_frame_pattern(pattern, f), overwrite);
  for (uint64_t f = 0; f < frames; ++f) {
    stop_if_interrupted();
    exporter.write_frame(apply_frame_pattern(pattern, f), cut_at_index(volume, static_cast<double>(f)));
    progress.update(f + 1, concat("frame ", f + 1, "/", frames));
  }
}

// Writes the collection of a series of .vti files.
void write_collection(const Volume& volume, const std::string& path, const std::string& pattern,
                      bool overwrite) {
  std::vector<double> times(volume_info(volume).dims[3]);
  check(bccsplat_volume_get_times(volume.get(), times.data(), times.size(), nullptr), "");
  std::vector<std::pair<std::string, double>> files;
  for (size_t f = 0; f < times.size(); ++f)
    files.emplace_back(to_text(to_path(apply_frame_pattern(pattern, f)).filename()), times[f]);
  OutputFile file(path, overwrite);
  const std::string text = collection_text(files);
  file.write(std::as_bytes(std::span(text)));
  file.finish();
}

// smoke.pvd: smoke.0000.vti and so on beside it.
std::string pattern_of_collection(const std::string& path) {
  return concat(path.substr(0, path.size() - std::strlen(kCollection)), ".%04d.vti");
}
// smoke.%04d.vti: smoke.pvd.
std::string collection_of_pattern(const std::string& pattern) {
  std::string name = apply_frame_pattern(pattern, 0);
  const std::string other = apply_frame_pattern(pattern, 1);
  const size_t last = std::mismatch(name.begin(), name.end(), other.begin()).first - name.begin();
  size_t begin = last;
  while (begin > 0 && is_digit(name[begin - 1])) --begin;
  const size_t end = last + 1;
  while (begin > 0 && (name[begin - 1] == '.' || name[begin - 1] == '_' || name[begin - 1] == '-')) --begin;
  const size_t suffix = lower(name).ends_with(".vti") ? name.size() - std::strlen(".vti") : name.size();
  return concat(name.substr(0, begin), name.substr(end, std::max(suffix, end) - end), kCollection);
}

// Exports all frames into one file.
void export_file(Exporter& exporter, const Volume& volume, const ExportArguments& a, Progress& progress) {
  if (holds_series(a.options.format)) return exporter.write_series(a.output, progress);
  const bool vdb = a.options.format == ExportFormat::vdb;
  if (volume_info(volume).dims[3] > 1)
    fail_usage("-o ", a.output, vdb ? ": an OpenVDB" : ": a .vti",
               " file holds one frame; write a pattern such as ",
               vdb ? "smoke.%04d.vdb" : "smoke.%04d.vti, or smoke.pvd for a series of them");
  exporter.write_frame(a.output, cut_at_index(volume, 0));
}

// Exports all frames to where -o says; `pattern` is that of files of one frame each, "" for one file.
void export_all(Exporter& exporter, const Volume& volume, const ExportArguments& a,
                const std::string& pattern) {
  Progress progress("export", volume_info(volume).dims[3], false, a.common.quiet);
  if (pattern.empty()) return export_file(exporter, volume, a, progress);
  const bool collected = a.options.format == ExportFormat::vti;
  const std::string collection = !collected                   ? ""
                                 : names_collection(a.output) ? a.output
                                                              : collection_of_pattern(pattern);
  if (collected) refuse_existing(collection, a.options.overwrite);
  export_files(exporter, volume, pattern, a.options.overwrite, progress);
  if (collected) write_collection(volume, collection, pattern, a.options.overwrite);
}

// Exports the frame at the moment asked for.
void export_moment(Exporter& exporter, const Volume& volume, const ExportArguments& a,
                   const std::string& pattern) {
  if (names_collection(a.output))
    fail_usage("-o ", a.output, ": a collection is of several frames: --all, or -o smoke.vti for one");
  Cut where = resolve_cut(volume, a.which);
  if (const double frame = exporter.written_index(where.index); frame != where.index) {
    where.index = frame; // its time stays that asked for
    if (!a.common.quiet)
      std::fprintf(stderr,
                   "bcc4: %s: labels: those of frame %s, the nearest, are written; bcc4 slice has the "
                   "field between frames\n",
                   a.file.c_str(), concat(frame).c_str());
  }
  exporter.write_frame(pattern.empty() ? a.output : apply_frame_pattern(pattern, std::llround(where.index)),
                       where);
}

Exit run_export(ExportArguments& a) {
  require_option(a.file, "FILE", "bcc4 export smoke.bcc4 --all -o smoke.%04d.vdb");
  require_option(a.output, "-o", "-o smoke.%04d.vdb");
  a.options.format = format_of(a);
  require_format(a.options.format, concat("-o ", a.output));
  a.options.quiet = a.common.quiet;
  if (a.all && (a.which.time || a.which.index)) fail_usage("--all and --time exclude each other");
  const Device device = create_device(a.common.threads, a.common.max_memory);
  const Volume volume = a.salvage ? open_salvaged(device, a) : open_volume(device, a.file, a.kernel);
  if (!a.common.quiet) warn_of_part(volume, a.file);
  const uint32_t channel = find_channel(volume, a.channel);
  // What moves goes beyond the sites that are stored around its moment.
  const bool keeps_small_values = a.salvage || a.options.motion == BCCSPLAT_MOTION_ON;
  Exporter exporter(volume, channel, a.options,
                    keeps_small_values ? StoredSites() : StoredSites(device, a.file, channel));
  const bccsplat_volume_info v = volume_info(volume);
  if (!a.all && !a.which.time && v.dims[3] > 1) fail_usage("--time T or --all is missing");
  if (a.options.region) check_region(*a.options.region, v);
  const std::string pattern = names_collection(a.output) ? pattern_of_collection(a.output)
                                                         : output_pattern(a, suffix_of(a.options.format));
  if (pattern.empty()) refuse_source_as_output(a.output, a.file);
  if (a.all)
    export_all(exporter, volume, a, pattern);
  else
    export_moment(exporter, volume, a, pattern);

  if (has_coordinates(volume)) warn_of_uneven_samples(a.options.format);
  if (exporter.holes() > 0) {
    const bool vdb = a.options.format == ExportFormat::vdb;
    std::fprintf(stderr, "bcc4: warning: %llu missing values were written as %s: %s has no code for them\n",
                 static_cast<unsigned long long>(exporter.holes()), vdb ? "background" : "0",
                 vdb ? "OpenVDB" : type_name(exporter.type()));
  }
  if (!a.common.quiet)
    std::printf("%s: %llu file(s), %s\n", pattern.empty() ? a.output.c_str() : pattern.c_str(),
                static_cast<unsigned long long>(a.all && !pattern.empty() ? v.dims[3] : 1),
                a.options.format == ExportFormat::vdb ? "f32" : type_name(exporter.type()));
  return Exit::ok;
}

} // namespace

Run add_export(const Command& tool) {
  auto a = std::make_shared<ExportArguments>();
  const Command ex = tool.add_command(
      "export", "Write frames on the grid of the source. The suffix of the output names the format.");
  ex.set_examples({"bcc4 export smoke.bcc4 --all -o smoke.nrrd",
                   "bcc4 export smoke.bcc4 --all --roi 0-31,0-31,10-20 -o box.nrrd",
                   "bcc4 export smoke.bcc4 --time 0.06 -o between.nrrd"});
  ex.add_option("FILE", a->file, "A .bcc4 file");
  ex.add_option("-o,--output,--out", a->output,
                "A file, a pattern such as smoke.%04d.vdb, or a folder. Suffixes: .nrrd, .vdb, .nii, "
                ".nii.gz, .nc, .vti, .pvd, .tif, .raw")
      .type_name("OUT");
  ex.add_flag("--all", a->all, "All frames");
  add_number(ex, "--time", a->which.time,
             "One moment, in the file's unit of time. Labels: the nearest frame");
  ex.add_flag("--index", a->which.index, "Take --time as a frame number; fractions are allowed");
  add_motion(ex, a->options.motion);
  add_region(ex, a->options.region, "Write only this box of samples, counted from 0, both ends included");
  add_choice<ExportFormat>(ex, "--format", a->options.format, export_formats(),
                           "Format (default: by the name of the output)");
  ex.add_flag("--salvage", a->salvage, "Read a damaged file: lost values become missing data");
  ex.add_option("--channel", a->channel, "Channel, by name or number (default: the first)").type_name("NAME");
  ex.add_option("--kernel", a->kernel, "Reconstruction kernel (default: the file's)").type_name("NAME");
  add_threads(ex, a->common);
  add_max_memory(ex, a->common);
  ex.add_flag("--overwrite", a->options.overwrite, "Replace existing outputs");
  ex.add_flag("--quiet", a->common.quiet, "Print warnings and errors only");
  return [a] { return run_export(*a); };
}

} // namespace bcc4

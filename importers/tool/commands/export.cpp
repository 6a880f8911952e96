// bcc4 export: frames back on the source grid, as raw, NRRD or OpenVDB files.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>

#include "readers/affine.h"
#include "readers/sequence.h"
#include "tool/cli.h"
#include "tool/commands/commands.h"
#include "tool/interrupt.h"
#include "tool/output/nrrd_output.h"
#include "tool/output/output_file.h"
#include "tool/progress.h"
#include "tool/view/slice_choice.h"
#include "tool/view/time_slice.h"
#if BCCSPLAT_WITH_OPENVDB
#include "tool/output/vdb_output.h"
#endif

namespace bcc4 {
namespace {

enum class Format { unset, raw, nrrd, vdb };

struct ExportArguments {
  std::string file, output, kernel, channel;
  SliceChoiceArguments which;
  std::optional<SampleBox> region;
  bool all = false, salvage = false;
  Format format = Format::unset;
  CommonOptions common;
  bool overwrite = false;
};

// Narrow integers go back as such, everything else as f32.
Type output_type(const bccsplat_channel_info& channel) {
  switch (channel.source_type) {
  case BCCSPLAT_TYPE_U8:
    return Type::u8;
  case BCCSPLAT_TYPE_I8:
    return Type::i8;
  case BCCSPLAT_TYPE_U16:
    return Type::u16;
  case BCCSPLAT_TYPE_I16:
    return Type::i16;
  default:
    return Type::f32;
  }
}

// Little-endian values; NaN (missing data) becomes 0 in integers and is counted.
void append_values(OutputFile& file, std::span<const float> values, Type type, uint64_t& holes) {
  std::vector<std::byte> bytes(values.size() * type_size(type));
  visit_type(type, [&](auto zero) {
    using T = decltype(zero);
    if constexpr (std::is_same_v<T, float> || (std::is_integral_v<T> && sizeof(T) <= 2))
      for (size_t i = 0; i < values.size(); ++i)
        store_as<T>(static_cast<double>(values[i]), bytes.data() + i * sizeof(T));
  });
  if (!is_float(type))
    holes += static_cast<uint64_t>(
        std::count_if(values.begin(), values.end(), [](float v) { return std::isnan(v); }));
  if constexpr (std::endian::native != std::endian::little) swap_bytes(bytes, type_size(type));
  file.write(bytes);
}

// "X0-X1,Y0-Y1,Z0-Z1": samples of the source grid from 0, both ends included.
SampleBox parse_region(const std::string& text) {
  SampleBox box;
  const auto parts = split_commas(text);
  if (parts.size() != 3)
    fail_usage("--roi ", text, ": X0-X1,Y0-Y1,Z0-Z1 is expected, such as 0-31,0-31,10-20");
  for (size_t a = 0; a < 3; ++a) {
    const std::string part(parts[a]);
    const size_t dash = part.find('-');
    box.begin[a] = option_number<uint64_t>("--roi", part.substr(0, dash));
    const uint64_t last =
        dash == std::string::npos ? box.begin[a] : option_number<uint64_t>("--roi", part.substr(dash + 1));
    if (last < box.begin[a] || last > INT32_MAX) fail_usage("--roi ", text, ": ", part, " does not rise");
    box.dims[a] = last - box.begin[a] + 1;
  }
  return box;
}

struct Exporter {
  const ExportArguments& a;
  const Volume& volume;
  uint32_t channel = 0;
  bccsplat_channel_info info = channel_info(volume, channel);
  Type type = output_type(info);
  uint64_t holes = 0; // written as 0

  [[nodiscard]] Slice slice(double index) const { return cut_frame(volume, index, {.channel = channel}); }

  [[nodiscard]] NrrdOutput header(bool series) const {
    const bccsplat_volume_info v = volume_info(volume);
    NrrdOutput n;
    n.type = type;
    const SampleBox box = region(v);
    n.sizes.assign(box.dims.begin(), box.dims.end());
    if (series) n.sizes.push_back(v.dims[3]);
    n.affine = affine(v);
    n.spatial_unit = v.spatial_unit;
    n.time_unit = v.time_unit;
    const char* space = nullptr;
    if (bccsplat_volume_find_attribute(volume.get(), "space", &space) == BCCSPLAT_OK) n.space = space;
    if (series) {
      n.times.resize(v.dims[3]);
      check(bccsplat_volume_get_times(volume.get(), n.times.data(), n.times.size(), nullptr), "");
    }
    return n;
  }

  // What is exported, and where its first sample stands.
  [[nodiscard]] SampleBox region(const bccsplat_volume_info& v) const {
    return a.region.value_or(SampleBox{{0, 0, 0}, {v.dims[0], v.dims[1], v.dims[2]}});
  }
  [[nodiscard]] Affine affine(const bccsplat_volume_info& v) const {
    Affine whole;
    std::copy(v.affine, v.affine + 16, whole.begin());
    if (!a.region) return whole;
    std::array<double, 3> begin{};
    for (size_t i = 0; i < 3; ++i) begin[i] = static_cast<double>(a.region->begin[i]);
    return moved_origin(whole, begin);
  }

  void append(OutputFile& file, double index) {
    sample_planes(
        slice(index),
        [&](uint64_t, std::span<const float> values) { append_values(file, values, type, holes); }, a.region);
  }

  void one_frame(const std::string& path, const Cut& where) {
    if (a.format == Format::vdb) {
      vdb(path, where);
      return;
    }
    OutputFile file(path, a.overwrite);
    if (a.format == Format::nrrd) {
      NrrdOutput n = header(false);
      n.keys = {{"time", concat(where.time)}};
      const std::string text = nrrd_header_text(n);
      file.write(std::as_bytes(std::span(text)));
    }
    append(file, where.index);
    file.finish();
  }

  void vdb([[maybe_unused]] const std::string& path, [[maybe_unused]] const Cut& where) {
#if BCCSPLAT_WITH_OPENVDB
    const bccsplat_volume_info v = volume_info(volume);
    VdbOutput o;
    o.grid = info.name;
    o.dims = region(v).dims;
    o.affine = affine(v);
    o.air = static_cast<float>(info.air);
    o.time = where.time;
    o.overwrite = a.overwrite;
    std::vector<float> values;
    values.reserve(o.dims[0] * o.dims[1] * o.dims[2]);
    sample_planes(
        slice(where.index),
        [&](uint64_t, std::span<const float> planes) {
          values.insert(values.end(), planes.begin(), planes.end());
        },
        a.region);
    write_vdb(path, o, values);
#endif
  }

  // All frames in one file, time slowest.
  void series(const std::string& path, Progress& progress) {
    const uint64_t frames = volume_info(volume).dims[3];
    OutputFile file(path, a.overwrite);
    if (a.format == Format::nrrd) {
      const std::string text = nrrd_header_text(header(true));
      file.write(std::as_bytes(std::span(text)));
    }
    for (uint64_t f = 0; f < frames; ++f) {
      stop_if_interrupted();
      append(file, static_cast<double>(f));
      progress.update(f + 1, concat("frame ", f + 1, "/", frames));
    }
    file.finish();
  }
};

// One file per frame goes into a folder or to a pattern; a plain name is one file for all.
std::string output_pattern(const ExportArguments& a, const std::string& suffix) {
  std::error_code ignored;
  if (has_frame_pattern(a.output)) return a.output;
  const std::filesystem::path out(a.output);
  const bool folder =
      a.output.ends_with('/') || std::filesystem::is_directory(out, ignored) || out.extension().empty();
  if (!folder) return "";
  std::filesystem::create_directories(out, ignored);
  return (out / concat(std::filesystem::path(a.file).stem().string(), ".%04d", suffix)).string();
}

Format format_of(const ExportArguments& a) {
  if (a.format != Format::unset) return a.format;
  const std::string out = lower(a.output);
  if (out.ends_with(".nrrd")) return Format::nrrd;
  if (out.ends_with(".vdb")) return Format::vdb;
  if (out.ends_with(".raw")) return Format::raw;
  fail_usage("--format raw, nrrd or vdb is missing: -o ", a.output, " does not say");
}

// With what is damaged as missing data, after a word on what that is.
Volume open_salvaged(const Device& device, const ExportArguments& a) {
  auto options = sized<bccsplat_volume_options>();
  options.kernel = a.kernel.empty() ? nullptr : a.kernel.c_str();
  options.salvage = 1;
  bccsplat_volume* raw = nullptr;
  check_kernel(bccsplat_volume_open_file(device.get(), a.file.c_str(), &options, &raw), a.file, a.kernel);
  Volume volume(raw);
  auto report = sized<bccsplat_verify_report>();
  check(bccsplat_volume_verify(raw, Progress::cancel_only, nullptr, &report), a.file);
  if (report.damages == 0) std::fprintf(stderr, "bcc4: %s: no damage\n", a.file.c_str());
  return volume;
}

Exit run_export(ExportArguments& a) {
  require(a.file, "FILE", "bcc4 export smoke.bcc4 --all -o smoke.%04d.vdb");
  require(a.output, "-o", "-o smoke.%04d.vdb");
  a.format = format_of(a);
#if !BCCSPLAT_WITH_OPENVDB
  if (a.format == Format::vdb)
    fail_usage("--format vdb: this bcc4 was built without OpenVDB (BCCSPLAT_WITH_OPENVDB)");
#endif
  if (a.all && (a.which.time || a.which.index)) fail_usage("--all and --time exclude each other");
  const Device device = create_device(a.common.threads, a.common.max_memory);
  const Volume volume = a.salvage ? open_salvaged(device, a) : open_volume(device, a.file, a.kernel);
  Exporter exporter{.a = a, .volume = volume, .channel = find_channel(volume, a.channel)};
  const bccsplat_volume_info v = volume_info(volume);
  const uint64_t frames = v.dims[3];
  if (!a.all && !a.which.time && frames > 1) fail_usage("--time T or --all is missing");
  for (size_t i = 0; i < 3 && a.region; ++i)
    if (a.region->begin[i] + a.region->dims[i] > v.dims[i])
      fail_usage("--roi: samples ", a.region->begin[i], " to ", a.region->begin[i] + a.region->dims[i] - 1,
                 " along ", "xyz"[i], ", the file has 0 to ", v.dims[i] - 1);
  static constexpr const char* suffixes[] = {"", ".raw", ".nrrd", ".vdb"};
  const std::string pattern = output_pattern(a, suffixes[static_cast<int>(a.format)]);
  if (pattern.empty()) refuse_source_as_output(a.output, a.file);
  uint64_t files = 1;
  if (!a.all) {
    const Cut where = resolve(volume, a.which);
    exporter.one_frame(pattern.empty() ? a.output : apply_frame_pattern(pattern, std::llround(where.index)),
                       where);
  } else {
    Progress progress("export", frames, false, a.common.quiet);
    if (!pattern.empty()) {
      files = frames;
      for (uint64_t f = 0; f < frames; ++f)
        refuse_existing(apply_frame_pattern(pattern, static_cast<int64_t>(f)), a.overwrite);
      for (uint64_t f = 0; f < frames; ++f) {
        stop_if_interrupted();
        exporter.one_frame(apply_frame_pattern(pattern, static_cast<int64_t>(f)),
                           cut_at_index(volume, static_cast<double>(f)));
        progress.update(f + 1, concat("frame ", f + 1, "/", frames));
      }
    } else {
      if (a.format == Format::vdb && frames > 1)
        fail_usage("-o ", a.output,
                   ": an OpenVDB file holds one frame; write a pattern such as smoke.%04d.vdb");
      if (a.format == Format::vdb)
        exporter.one_frame(a.output, cut_at_index(volume, 0));
      else
        exporter.series(a.output, progress);
    }
  }
  if (exporter.holes > 0)
    std::fprintf(stderr, "bcc4: warning: %llu missing values were written as 0: %s has no code for them\n",
                 static_cast<unsigned long long>(exporter.holes), type_name(exporter.type));
  if (!a.common.quiet)
    std::printf("%s: %llu file(s), %s\n", pattern.empty() ? a.output.c_str() : pattern.c_str(),
                static_cast<unsigned long long>(files),
                a.format == Format::vdb ? "f32" : type_name(exporter.type));
  return Exit::ok;
}

} // namespace

Run add_export(CLI::App& app) {
  auto a = std::make_shared<ExportArguments>();
  CLI::App& ex = *app.add_subcommand("export", "Write frames back on the source grid");
  ex.add_option("FILE", a->file, "A .bcc4 file");
  ex.add_option("-o,--output", a->output, "A file, a pattern such as smoke.%04d.vdb, or a folder")
      ->type_name("OUT");
  ex.add_flag("--all", a->all, "All frames");
  add_number(ex, "--time", a->which.time, "One time, in the file's unit");
  ex.add_flag("--index", a->which.index, "--time is a frame number, fractions allowed");
  ex.add_option_function<std::string>(
        "--roi", [a](const std::string& text) { a->region = parse_region(text); },
        "Only this box of the source grid: samples from 0, both ends included")
      ->type_name("X0-X1,Y0-Y1,Z0-Z1");
  add_choice<Format>(ex, "--format", a->format,
                     {{"raw", Format::raw}, {"nrrd", Format::nrrd}, {"vdb", Format::vdb}},
                     "Format (default: by the name of the output)");
  ex.add_flag("--salvage", a->salvage, "Of a damaged file: what is lost becomes missing data");
  ex.add_option("--channel", a->channel, "Channel, by name or number (default: the first)")
      ->type_name("NAME");
  ex.add_option("--kernel", a->kernel, "Reconstruction kernel (default: the file's)")->type_name("NAME");
  add_threads(ex, a->common);
  add_max_memory(ex, a->common);
  ex.add_flag("--overwrite", a->overwrite, "Replace existing outputs");
  ex.add_flag("--quiet", a->common.quiet, "Print warnings and errors only");
  return [a] { return run_export(*a); };
}

} // namespace bcc4

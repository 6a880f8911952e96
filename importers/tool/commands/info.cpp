// SPDX-License-Identifier: Apache-2.0
// bcc4 info: what is in a .bcc4 file.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

#include "series/data_kind.h"
#include "tool/cli.h"
#include "tool/commands/commands.h"
#include "tool/handles.h"
#include "tool/json.h"
#include "tool/view/dates.h"
#include "tool/view/time_slice.h"

namespace bcc4 {
namespace {

struct InfoArguments {
  std::string file;
  bool json = false;
  bool histogram = false;
  bool frames = false;
  bool gpu = false;
};

// Returns the ranges of the source, frame by frame; empty where the file does not tell.
std::vector<std::array<double, 2>> frame_ranges(const Volume& volume, uint32_t channel) {
  uint64_t count = 0;
  check(bccsplat_volume_get_frame_ranges(volume.get(), channel, nullptr, 0, &count), "");
  std::vector<std::array<double, 2>> ranges(count);
  double* const numbers = count > 0 ? ranges.front().data() : nullptr;
  check(bccsplat_volume_get_frame_ranges(volume.get(), channel, numbers, count, nullptr), "");
  return ranges;
}

// What a channel is of, as its file says it or as it is found: "ct", "field" ...
std::string kind_of(const Volume& volume, const bccsplat_channel_info& c) {
  const std::string kind = told(volume, kind_attribute(c.name).c_str());
  return kind.empty() ? std::string(name_of(DataKind::unknown)) : kind;
}

Json channel_json(const Volume& volume, const bccsplat_channel_info& c, bool histogram) {
  Json j{{"name", c.name},
         {"kind", kind_of(volume, c)},
         {"unit", c.unit},
         {"source_type", value_type_name(c.source_type)},
         {"value_type", value_type_name(c.value_type)},
         {"labels", c.labels != 0},
         {"air", c.air},
         {"air_threshold", c.air_threshold},
         {"value_scale", c.value_scale},
         {"value_offset", c.value_offset},
         {"range", {c.range[0], c.range[1]}},
         {"kept_range", {c.kept_range[0], c.kept_range[1]}},
         {"percentiles", {{"2", c.percentile_2}, {"99.8", c.percentile_998}}},
         {"sites_kept", c.sites_kept},
         {"cc_relevant", c.cc_relevant},
         {"holes", c.holes},
         {"missing", c.missing}};
  if (c.error_bound > 0)
    j["errors"] = {{"bound", c.error_bound},
                   {"corrections", c.corrections},
                   {"lattice", {{"rmse", c.lattice_rmse}, {"max", c.lattice_max_abs}}},
                   {"corrected", {{"rmse", c.rmse}, {"max", c.max_abs}}}};
  if (histogram) j["histogram"] = c.histogram;
  return j;
}

// "xz": the axes of space that go round.
std::string periodic_axes(const bccsplat_volume_info& v) {
  std::string text;
  for (size_t a = 0; a < 3; ++a)
    if (v.periodic_axes >> a & 1) text += "xyz"[a];
  return text;
}

Json axis_json(const bccsplat_axis& axis) {
  return {{"unit", axis.unit},
          {"down", (axis.flags & BCCSPLAT_AXIS_DOWN) != 0},
          {"coordinates", std::vector<double>(axis.coordinates, axis.coordinates + axis.count)}};
}

const char* store_name(const bccsplat_volume_info& v) {
  return v.store == BCCSPLAT_STORE_WAVELETS ? "wavelets" : "samples";
}

Json info_json(const Volume& volume, const InfoArguments& a) {
  const bccsplat_volume_info v = volume_info(volume);
  const bccsplat_channel_info first = channel_info(volume, 0);
  uint64_t kept = 0;
  for (uint32_t c = 0; c < v.channel_count; ++c) kept += channel_info(volume, c).sites_kept;
  Json j;
  j["dims"] = v.dims;
  j["lattice"] = lattice_name(v.lattice);
  j["cc_samples"] = v.cc_samples;
  j["sites_total"] = v.sites_total;
  j["sites_outside"] = v.sites_outside;
  j["sites_kept"] = v.channel_count == 1 ? first.sites_kept : kept;
  j["layers"] = v.layer_count;
  j["scale"] = v.scale;
  j["time_scale"] = v.time_scale;
  j["scales"] = v.scales;
  j["periodic_axes"] = periodic_axes(v);
  j["planes_outside"] = {{"before", v.planes_before}, {"behind", v.planes_behind}};
  j["value_type"] = value_type_name(first.value_type);
  j["range"] = {first.range[0], first.range[1]};
  j["times"] = {{"count", v.dims[3]},  {"first", v.time_first},          {"last", v.time_last},
                {"unit", v.time_unit}, {"uniform", v.time_uniform != 0}, {"periodic", v.time_periodic != 0},
                {"end", v.time_end}};
  if (const Dates dates(volume); !dates.of(v.time_first).empty())
    j["times"]["dates"] = {{"first", dates.of(v.time_first)},
                           {"last", dates.of(v.time_last)},
                           {"calendar", dates.calendar().empty() ? "standard" : dates.calendar()}};
  if (v.frames_expected > 0) j["unfinished"] = {{"frames", v.dims[3]}, {"expected", v.frames_expected}};
  if (v.part_end > 0) j["part"] = {{"first", v.part_first}, {"last", v.part_end - 1}};
  j["affine"] = matrix_json(v.affine);
  j["spatial_unit"] = v.spatial_unit;
  if (has_coordinates(volume))
    for (uint32_t axis = 0; axis < 3; ++axis) j["axes"].push_back(axis_json(axis_info(volume, axis)));
  j["air"] = first.air;
  j["bytes"] = {
      {"file", v.bytes_file}, {"runs", v.bytes_runs}, {"values", v.bytes_values}, {"index", v.bytes_index}};
  j["kernel"] = v.kernel;
  j["recommended_kernel"] = v.recommended_kernel;
  j["store"] = store_name(v);
  j["holes"] = v.has_holes != 0;
  j["levels"] = Json::array();
  for (uint32_t l = 1; l <= v.level_count; ++l) {
    const bccsplat_level_info level = level_info(volume, l);
    j["levels"].push_back({{"scales", level.scales},
                           {"layers", level.layer_count},
                           {"sites_total", level.sites_total},
                           {"sites_kept", level.sites_kept},
                           {"bytes", level.bytes},
                           {"relative_rmse", level.relative_rmse}});
  }
  j["channels"] = Json::array();
  for (uint32_t c = 0; c < v.channel_count; ++c) {
    j["channels"].push_back(channel_json(volume, channel_info(volume, c), a.histogram));
    if (a.frames) j["channels"].back()["frames"] = frame_ranges(volume, c);
  }
  j["attributes"] = Json::object();
  for (uint64_t i = 0; i < v.attribute_count; ++i) {
    const char *key = nullptr, *value = nullptr;
    check(bccsplat_volume_get_attribute(volume.get(), i, &key, &value), "");
    j["attributes"][key] = value;
  }
  j["sources"] = Json::array();
  const char* name = nullptr;
  uint64_t bytes = 0;
  uint32_t crc = 0;
  for (uint64_t i = 0; bccsplat_volume_get_source(volume.get(), i, &name, &bytes, &crc) == BCCSPLAT_OK; ++i)
    j["sources"].push_back({{"name", name}, {"bytes", bytes}, {"crc32", crc}});
  return j;
}

std::string share(uint64_t part, uint64_t whole) {
  return whole == 0
             ? ""
             : concat(" (", short_number(static_cast<double>(part) / static_cast<double>(whole), 4), ")");
}

template<class... Parts> void line(const char* key, const Parts&... parts) {
  std::printf("  %-10s %s\n", key, concat(parts...).c_str());
}

// 16 bars of 16 bins each, the longest 50 marks; bins next to air usually dwarf the others, so roots are
// drawn.
void print_histogram(const bccsplat_channel_info& c) {
  uint64_t bars[16]{}, highest = 1;
  for (size_t b = 0; b < 256; ++b) highest = std::max(highest, bars[b / 16] += c.histogram[b]);
  const double magnitude = std::max(std::abs(c.kept_range[0]), std::abs(c.kept_range[1]));
  const int digits = digits_apart(magnitude, (c.kept_range[1] - c.kept_range[0]) / 16, 5);
  for (size_t b = 0; b < 16; ++b) {
    const double low = c.kept_range[0] + (c.kept_range[1] - c.kept_range[0]) * static_cast<double>(b) / 16;
    const double length = 50 * std::sqrt(static_cast<double>(bars[b]) / static_cast<double>(highest));
    std::printf("  %12s  %-50s %llu\n", short_number(low, digits).c_str(),
                std::string(static_cast<size_t>(length), '#').c_str(),
                static_cast<unsigned long long>(bars[b]));
  }
}

// Planes of the lattice outside the first and the last sample, where there are some.
std::string outside_text(const bccsplat_volume_info& v) {
  std::string text;
  for (size_t a = 0; a < 3; ++a)
    if (const uint32_t before = v.planes_before[a], behind = v.planes_behind[a]; before + behind > 0)
      text += concat(text.empty() ? ", planes outside " : ", ", "xyz"[a], " ", before, " + ", behind);
  if (v.periodic_axes != 0) text += concat(", periodic along ", periodic_axes(v));
  return text;
}

std::string distances_text(const bccsplat_volume_info& v, const double* scales) {
  std::string text;
  for (size_t a = 0; a < (v.dims[3] > 1 ? 4 : 3); ++a)
    text += (a == 0 ? "" : " x ") + short_number(scales[a], 3);
  return text;
}

// Returns what one step means where integer codes are not the values themselves.
std::string steps_text(const bccsplat_channel_info& c) {
  const bool integers = c.value_type == BCCSPLAT_TYPE_U8 || c.value_type == BCCSPLAT_TYPE_U16;
  return integers && c.value_scale != 1 ? concat(" in steps of ", short_number(c.value_scale, 6)) : "";
}

// dB, the range of the values the peak.
std::string psnr_text(double peak, double rmse) {
  return rmse > 0 && peak > 0 ? concat(short_number(20 * std::log10(peak / rmse), 3), " dB") : "no error";
}

// Prints what a file with a bound promises, and what it takes.
void print_errors(const bccsplat_channel_info& c) {
  if (!(c.error_bound > 0)) return;
  line("error", "at most ", short_number(c.error_bound, 5), " at source samples, ", c.corrections,
       " of them corrected");
  if (!(c.lattice_max_abs > 0)) return;
  const double peak = c.range[1] - c.range[0];
  line("", "RMSE ", short_number(c.rmse, 4), ", PSNR ", psnr_text(peak, c.rmse), "; the lattice alone ",
       short_number(c.lattice_rmse, 4), ", ", psnr_text(peak, c.lattice_rmse), ", off by up to ",
       short_number(c.lattice_max_abs, 4));
}

void print_frames(const Volume& volume, uint32_t channel) {
  const auto ranges = frame_ranges(volume, channel);
  if (ranges.empty()) line("frames", "the file does not tell their ranges");
  std::vector<double> times(ranges.size());
  check(bccsplat_volume_get_times(volume.get(), times.data(), times.size(), nullptr), "");
  const Dates dates(volume);
  for (size_t f = 0; f < ranges.size(); ++f)
    line(f == 0 ? "frames" : "", f, " at ", short_number(times[f], 6), dates.known() ? ", " : "",
         dates.of(times[f]), ": ", short_number(ranges[f][0], 6), " to ", short_number(ranges[f][1], 6));
}

// Prints where the samples of unevenly spaced axes stand.
void print_axes(const Volume& volume) {
  if (!has_coordinates(volume)) return;
  for (uint32_t a = 0; a < 3; ++a) {
    const bccsplat_axis axis = axis_info(volume, a);
    std::string text = axis.count == 0 ? "evenly spaced" : "";
    for (uint64_t i = 0; i < axis.count; ++i)
      text += concat(i == 0 ? "" : " ", short_number(axis.coordinates[i], 7));
    const std::string name(1, "xyz"[a]);
    line(name.c_str(), text, *axis.unit ? concat(" ", axis.unit) : "",
         (axis.flags & BCCSPLAT_AXIS_DOWN) != 0 ? ", counted down" : "");
  }
}

void print_info(const Volume& volume, const InfoArguments& a) {
  const bccsplat_volume_info v = volume_info(volume);
  const std::string unit = *v.time_unit ? concat(" ", v.time_unit) : "";
  std::printf("%s\n", a.file.c_str());
  line("samples", v.dims[0], " x ", v.dims[1], " x ", v.dims[2], " x ", v.dims[3], " = ", v.cc_samples);
  line("lattice", lattice_name(v.lattice), ", ", v.sites_total, " sites", share(v.sites_total, v.cc_samples),
       " in ", v.layer_count, " layers", ", distances ", distances_text(v, v.scales), outside_text(v));
  for (uint32_t l = 1; l <= v.level_count; ++l) {
    const bccsplat_level_info level = level_info(volume, l);
    line(l == 1 ? "levels" : "", l, ": distances ", distances_text(v, level.scales), ", ", level.sites_total,
         " sites, ", level.bytes, " bytes",
         level.relative_rmse > 0 ? concat(", ", psnr_text(1, level.relative_rmse)) : "");
  }
  line("times", time_text(v.time_first), " to ", time_text(v.time_last), unit, ", ", v.dims[3],
       v.dims[3] == 1 ? " frame" : " frames", v.time_uniform ? "" : ", uneven",
       v.time_periodic ? concat(", periodic: ", time_text(v.time_end), unit, " is the first frame again")
                       : "");
  const Dates dates(volume);
  if (const std::string first = dates.of(v.time_first); !first.empty())
    line("dates", first, " to ", dates.of(v.time_last), dates.calendar().empty() ? "" : ", calendar ",
         dates.calendar());
  if (v.frames_expected > 0)
    line("unfinished", v.dims[3], " of ", v.frames_expected, " frames can be looked at");
  if (v.part_end > 0)
    line("part", "frames ", v.part_first, " to ", v.part_end - 1,
         ", elsewhere air; bcc4 concat joins all parts");
  for (size_t r = 0; r < 3; ++r)
    line(r == 0 ? "affine" : "", v.affine[4 * r], " ", v.affine[4 * r + 1], " ", v.affine[4 * r + 2], " ",
         v.affine[4 * r + 3], r == 0 && *v.spatial_unit ? concat(" ", v.spatial_unit) : "",
         r == 0 && has_coordinates(volume) ? ", of even positions" : "");
  print_axes(volume);
  line("kernel", v.kernel, v.store == BCCSPLAT_STORE_WAVELETS ? ", samples stored as wavelets" : "");
  line("bytes", v.bytes_file, ": values ", v.bytes_values, ", runs ", v.bytes_runs, ", index ",
       v.bytes_index);
  for (uint32_t c = 0; c < v.channel_count; ++c) {
    const bccsplat_channel_info ch = channel_info(volume, c);
    line(c == 0 ? "channels" : "", ch.name, *ch.unit ? concat(" [", ch.unit, "]") : "", ": ",
         value_type_name(ch.value_type), " from ", value_type_name(ch.source_type),
         ch.labels != 0 ? ", labels" : "", steps_text(ch), ", range ", ch.range[0], " to ", ch.range[1],
         ", air ", ch.air, ch.air_threshold > 0 ? concat(" +- ", ch.air_threshold) : "", ", ", ch.sites_kept,
         " sites stored", share(ch.sites_kept, v.sites_total + v.sites_outside),
         ch.holes > 0 ? concat(", ", ch.holes, " holes") : "",
         ch.missing > 0 ? concat(", ", ch.missing, " samples missing", share(ch.missing, v.cc_samples)) : "");
    if (const std::string kind = kind_of(volume, ch); kind != name_of(DataKind::unknown)) line("kind", kind);
    print_errors(ch);
    if (a.histogram) print_histogram(ch);
    if (a.frames) print_frames(volume, c);
  }
  for (uint64_t i = 0; i < v.attribute_count; ++i) {
    const char *key = nullptr, *value = nullptr;
    check(bccsplat_volume_get_attribute(volume.get(), i, &key, &value), "");
    line(i == 0 ? "attributes" : "", key, " = ", value);
  }
}

bccsplat_gpu_info find_gpu(const Device& device) {
  auto gpu = sized<bccsplat_gpu_info>();
  check(bccsplat_device_get_gpu_info(device.get(), &gpu), "");
  return gpu;
}

void print_gpu(const Device& device, bool json) {
  const bccsplat_gpu_info gpu = find_gpu(device);
  if (json) {
    print_json(Json{{"vendor", gpu.vendor},
                    {"renderer", gpu.renderer},
                    {"version", gpu.version},
                    {"software", gpu.software != 0},
                    {"entry", gpu.compute ? "compute" : "fragment"},
                    {"memory", gpu.memory}});
    return;
  }
  std::printf("%s\n", gpu.renderer);
  line("vendor", gpu.vendor);
  line("OpenGL", gpu.version, gpu.compute ? ", compute shaders" : ", fragment shaders");
  line("memory", gpu.memory > 0 ? concat(gpu.memory, " bytes") : "the driver does not tell");
  line("used", gpu.software ? "with --gpu on: it draws on the CPU" : "wherever it draws a picture");
}

} // namespace

Run add_info(const Command& tool) {
  auto a = std::make_shared<InfoArguments>();
  const Command info =
      tool.add_command("info", "Print what a .bcc4 file holds: size, times, channels, lattice, errors.");
  info.set_examples({"bcc4 info smoke.bcc4", "bcc4 info smoke.bcc4 --json"});
  info.add_option("FILE", a->file, "A .bcc4 file");
  info.add_flag("--gpu", a->gpu, "Print which GPU draws pictures instead");
  info.add_flag("--json", a->json, "Report as JSON");
  info.add_flag("--histogram", a->histogram, "Add the histogram of the stored values");
  info.add_flag("--frames", a->frames, "Add the range of the source's values in every frame");
  return [a] {
    const Device device = create_device(1, 0);
    if (a->gpu) {
      print_gpu(device, a->json);
      return Exit::ok;
    }
    require_option(a->file, "FILE", "bcc4 info smoke.bcc4");
    const Volume volume = open_volume(device, a->file, "");
    if (a->json)
      print_json(info_json(volume, *a));
    else
      print_info(volume, *a);
    return Exit::ok;
  };
}

} // namespace bcc4

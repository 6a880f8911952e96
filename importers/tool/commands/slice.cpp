// SPDX-License-Identifier: Apache-2.0
// bcc4 slice: a hyperplane of a volume as a dense box at the source's resolution.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <utility>

#include "tool/cli.h"
#include "tool/commands/commands.h"
#include "tool/interrupt.h"
#include "tool/json.h"
#include "tool/output/describe_volume.h"
#include "tool/output/export_format.h"
#include "tool/output/output_file.h"
#include "tool/view/even_places.h"
#include "tool/view/slice_choice.h"
#include "tool/view/slice_sweep.h"
#include "tool/view/time_slice.h"
#if BCCSPLAT_WITH_OPENVDB
#include "tool/output/vdb_origin.h"
#endif

namespace bcc4 {
namespace {

struct SliceArguments {
  std::string file, output, kernel, channel;
  SliceChoiceArguments which;
  bool overwrite = false;
  CommonOptions common;
};

std::string row(const double* v, size_t n) {
  std::string text;
  for (size_t i = 0; i < n; ++i) text += concat(i > 0 ? " " : "", v[i]);
  return text;
}

struct Range {
  float min = std::numeric_limits<float>::infinity(), max = -std::numeric_limits<float>::infinity();
  uint64_t holes = 0;
  void add(std::span<const float> values) {
    for (const float v : values) {
      if (v < min) min = v;
      if (v > max) max = v;
      holes += v != v;
    }
  }
  [[nodiscard]] bool empty() const { return min > max; }
  [[nodiscard]] std::string text() const {
    return empty() ? "no value" : concat(short_number(min, 6), " to ", short_number(max, 6));
  }
};

// Index space of the box that is written -> world. Along uneven axes even steps lead from its first sample to
// the last.
Affine box_affine(const Volume& volume, const bccsplat_slice_info& info) {
  Affine affine;
  std::copy(info.affine, info.affine + 16, affine.begin());
  std::array<double, 3> begin{info.extent[0][0], info.extent[1][0], info.extent[2][0]};
  Affine steps = affine;
  for (size_t k = 0; k < 3; ++k)
    for (uint32_t a = 0; a < 3; ++a) {
      if (info.basis[k][a] != 1 || axis_info(volume, a).count == 0) continue;
      const double origin = info.origin[a], length = info.extent[k][1] - begin[k];
      const double first = even_position(volume, a, origin + begin[k]);
      if (length > 0)
        for (size_t r = 0; r < 3; ++r)
          steps[4 * r + k] *= (even_position(volume, a, origin + info.extent[k][1]) - first) / length;
      begin[k] = first - origin;
    }
  const Affine moved = moved_origin(affine, begin);
  for (size_t r = 0; r < 3; ++r) steps[4 * r + 3] = moved[4 * r + 3];
  return steps;
}

// Says what a slice of an uneven volume does not hold.
void warn_of_uneven(const Volume& volume, const Cut& where, ExportFormat format) {
  if (!has_coordinates(volume)) return;
  warn_of_uneven_samples(format);
  if (!where.is_time_slice)
    std::fprintf(stderr,
                 "bcc4: warning: axes are unevenly spaced: the plane is one of samples, and only along "
                 "axes that it keeps are coordinates written\n");
}

// Gives axis u, which is time, the unit of time; frames where they are uneven.
void set_time_axis(const bccsplat_volume_info& v, const bccsplat_slice_info& info, size_t u,
                   VolumeOutput& output) {
  const bool even = v.time_uniform != 0 && v.dims[3] > 1;
  const double step = even ? (v.time_last - v.time_first) / static_cast<double>(v.dims[3] - 1) : 1;
  const double way = info.basis[u][3];
  size_t row = 0; // of the world, along which it runs
  for (size_t r = 1; r < 3; ++r)
    if (std::fabs(output.affine[4 * r + u]) > std::fabs(output.affine[4 * row + u])) row = r;
  for (size_t r = 0; r < 3; ++r) output.affine[4 * r + u] = 0;
  output.affine[4 * row + u] = way * step;
  double begin = info.origin[3] + way * info.extent[u][0]; // a frame, up to rounding
  if (const double whole = std::nearbyint(begin); std::fabs(begin - whole) < 1e-9) begin = whole;
  output.affine[4 * row + 3] = (even ? v.time_first : 0) + step * begin;
  output.axis_units[u] = even ? v.time_unit : "frames";
  if (!even) output.axis_records[u].clear();
}

// Names the axes of a slice over time and their units where each is one of x, y, z and t.
void name_axes(const Volume& volume, const bccsplat_slice_info& info, VolumeOutput& output) {
  const std::array<std::string, 3> units = output.axis_units;
  const std::array<std::string, 4> records = std::exchange(output.axis_records, {});
  for (size_t u = 0; u < 3; ++u) {
    const double* const direction = info.basis[u];
    const auto axis =
        std::find_if(direction, direction + 4, [](double d) { return std::abs(d) == 1; }) - direction;
    if (axis == 4) {
      output.axis_names = output.axis_units = {}; // lengths and times together
      output.axis_records = {};
      return;
    }
    output.axis_names[u] = std::string(1, "xyzt"[axis]);
    output.axis_records[u] = records[axis];
    if (axis < 3)
      output.axis_units[u] = units[axis];
    else
      set_time_axis(volume_info(volume), info, u, output);
  }
}

const char* slab_name(int32_t slab) {
  return slab == BCCSPLAT_SLAB_SUM ? "sum" : slab == BCCSPLAT_SLAB_MAXIMUM ? "max" : "mean";
}

// Tells where the samples stand along axes that run along unevenly spaced ones of the volume.
void add_coordinates(const Volume& volume, const bccsplat_slice_info& info, VolumeOutput& n) {
  for (size_t k = 0; k < 3; ++k)
    for (uint32_t a = 0; a < 3; ++a) {
      const bccsplat_axis axis = axis_info(volume, a);
      if (axis.count == 0 || info.basis[k][a] != 1) continue;
      constexpr double rounding = 1e-6;
      const double at = info.origin[a] + info.extent[k][0], whole = std::nearbyint(at);
      const auto first = static_cast<uint64_t>(std::max(whole, 0.0));
      if (std::fabs(at - static_cast<double>(first)) > rounding || first + info.dims[k] > axis.count)
        continue;
      n.coordinates[k].assign(axis.coordinates + first, axis.coordinates + first + info.dims[k]);
      n.coordinates_down[k] = (axis.flags & BCCSPLAT_AXIS_DOWN) != 0;
    }
}

VolumeOutput slice_output(const Volume& volume, uint32_t channel, const bccsplat_slice_info& info,
                          const Cut& where) {
  VolumeOutput n = describe_volume(volume, channel);
  // A sum along the normal is in another unit.
  if (where.thickness > 0 && where.slab == BCCSPLAT_SLAB_SUM) n.unit.clear(), n.record.clear();
  std::copy(info.dims, info.dims + 3, n.dims.begin());
  n.affine = box_affine(volume, info);
  add_coordinates(volume, info, n);
  if (where.is_time_slice)
    n.times = {where.time};
  else // some axis is none of lengths
    n.space.clear(), name_axes(volume, info, n), n.spatial_unit.clear();
  n.keys = {
      {"bccsplat hyperplane", row(info.hyperplane, 5)},
      {"bccsplat origin", row(info.origin, 4)},
      {"bccsplat basis u", row(info.basis[0], 4)},
      {"bccsplat basis v", row(info.basis[1], 4)},
      {"bccsplat basis w", row(info.basis[2], 4)},
      {"bccsplat first sample", concat(info.extent[0][0], " ", info.extent[1][0], " ", info.extent[2][0])},
      {"bccsplat spacing", "1 1 1"},
      {"bccsplat kernel", info.kernel}};
  if (where.thickness > 0)
    n.keys.emplace_back("bccsplat slab", concat(slab_name(where.slab), " ", where.thickness));
  return n;
}

Json slice_json(const Volume& volume, const bccsplat_slice_info& info, const Cut& where,
                const std::string& output, const Range& range) {
  Json basis = Json::array();
  for (const auto& b : info.basis) basis.push_back({b[0], b[1], b[2], b[3]});
  Json j{{"output", output}, {"dims", info.dims}};
  j["hyperplane"] = info.hyperplane;
  j["origin"] = info.origin;
  j["basis"] = basis;
  j["first_sample"] = {info.extent[0][0], info.extent[1][0], info.extent[2][0]};
  j["spacing"] = {1, 1, 1};
  j["affine"] = matrix_json(box_affine(volume, info).data());
  j["lattice"] = lattice_name(info.lattice);
  j["level"] = info.level;
  j["points"] = info.points;
  j["range"] = range.empty() ? Json() : Json{range.min, range.max};
  j["nan"] = range.holes;
  j["air"] = info.air;
  j["kernel"] = info.kernel;
  if (where.thickness > 0) j["slab"] = {{"kind", slab_name(where.slab)}, {"thickness", where.thickness}};
  j["bytes_read"] = info.bytes_read;
  j["milliseconds"] = info.milliseconds;
  return j;
}

#if BCCSPLAT_WITH_OPENVDB
Range write_vdb_slice(const Volume& volume, uint32_t channel, const Slice& slice, const Cut& where,
                      const std::string& path) {
  const bccsplat_slice_info info = slice_info(slice);
  std::vector<float> values;
  values.reserve(info.dims[0] * info.dims[1] * info.dims[2]);
  Range range;
  sample_planes(slice, [&](uint64_t, std::span<const float> planes) {
    values.insert(values.end(), planes.begin(), planes.end());
    range.add(planes);
  });
  VdbOutput o = vdb_like_source(volume, channel);
  if (where.is_time_slice && where.thickness == 0) {
    for (size_t a = 0; a < 3 && where.region; ++a) o.begin[a] += static_cast<int32_t>(where.region->begin[a]);
    if (!where.region) keep_sparsity(volume, channel, where.index, values, o);
  } else { // of another kind than the source's frames
    o.grid_class = VdbOutput{}.grid_class;
    o.begin = {};
    o.air = static_cast<float>(info.air);
    o.range = {-HUGE_VALF, HUGE_VALF};
    if (where.slab == BCCSPLAT_SLAB_SUM) o.told.value_unit.clear();
  }
  if (where.is_time_slice) tell_time(volume, where.time, o);
  std::copy(info.dims, info.dims + 3, o.dims.begin());
  o.affine = box_affine(volume, info);
  o.overwrite = true;
  write_vdb(path, o, values);
  return range;
}
#endif

Range write_samples(const Slice& slice, VolumeFile& file) {
  Range range;
  sample_planes(slice, [&](uint64_t, std::span<const float> planes) {
    range.add(planes);
    file.write(std::as_bytes(planes));
  });
  file.finish();
  return range;
}

// Cuts, writes and reports one slice; its line of JSON.
Json write_slice(const Volume& volume, const SliceArguments& a, uint32_t channel, const Cut& where,
                 const std::string& path) {
  const Slice slice = cut_slice(volume, where, channel);
  const bccsplat_slice_info info = slice_info(slice);
  Range range;
  const ExportFormat format = format_of_suffix(path);
  if (format == ExportFormat::vdb) {
#if BCCSPLAT_WITH_OPENVDB
    range = write_vdb_slice(volume, channel, slice, where, path);
#endif
  } else {
    const VolumeOutput output = slice_output(volume, channel, info, where);
    range = write_samples(slice, *create_volume_file(format, path, output, true, a.common.quiet));
  }
  if (!a.common.json && !a.common.quiet)
    std::printf("%s: %llu x %llu x %llu samples, %s%s, from %llu lattice points in %s ms\n", path.c_str(),
                static_cast<unsigned long long>(info.dims[0]), static_cast<unsigned long long>(info.dims[1]),
                static_cast<unsigned long long>(info.dims[2]), range.text().c_str(),
                range.holes > 0 ? concat(", ", range.holes, " NaN").c_str() : "",
                static_cast<unsigned long long>(info.points), short_number(info.milliseconds, 3).c_str());
  return slice_json(volume, info, where, path, range);
}

Exit run_slice(const SliceArguments& a) {
  require_option(a.file, "FILE", "bcc4 slice smoke.bcc4 --time 10 -o slice.nrrd");
  require_option(a.output, "-o", "-o slice.nrrd");
  const ExportFormat format = format_of_suffix(a.output);
  if (format == ExportFormat::unset || format == ExportFormat::raw || lower(a.output).ends_with(".pvd"))
    fail_usage("-o ", a.output, ": must end in .nrrd, .vdb, .nii, .nii.gz, .nc, .vti or .tif");
  require_format(format, concat("-o ", a.output));
  const Device device = create_device(a.common.threads, a.common.max_memory);
  const Volume volume = open_volume(device, a.file, a.kernel);
  if (!a.common.quiet) warn_of_part(volume, a.file);
  const uint32_t channel = find_channel(volume, a.channel);
  std::vector<Cut> cuts = sweep(volume, a.which);
  cuts.front().once = cuts.size() == 1;
  const std::vector<std::string> names = sweep_names(a.output, cuts.size());
  for (const std::string& name : names) refuse_existing(name, a.overwrite);
  if (!a.common.quiet) warn_of_uneven(volume, cuts.front(), format);
  Json written = Json::array();
  for (size_t i = 0; i < cuts.size(); ++i) {
    stop_if_interrupted();
    written.push_back(write_slice(volume, a, channel, cuts[i], names[i]));
  }
  if (a.common.json) print_json(a.which.sweep ? Json{{"slices", written}} : written[0]);
  return Exit::ok;
}

} // namespace

Run add_slice(const Command& tool) {
  auto a = std::make_shared<SliceArguments>();
  const Command slice =
      tool.add_command("slice", "Cut a 3D slice out of space and time and write its samples. A slice is a "
                                "moment, a plane over time, or any other hyperplane.");
  slice.set_examples({"bcc4 slice smoke.bcc4 --time 0.06 -o moment.nrrd",
                      "bcc4 slice smoke.bcc4 --plane 1,0,0,0,-40 -o x40.nrrd"});
  slice.add_option("FILE", a->file, "A .bcc4 file");
  slice
      .add_option("-o,--output,--out", a->output,
                  "The file to write: .nrrd, .vdb, .nii, .nii.gz, .nc, .vti or .tif")
      .type_name("OUT");
  add_slice_choice(slice, a->which);
  add_sweep(slice, a->which);
  slice.add_option("--channel", a->channel, "Channel, by name or number (default: the first)")
      .type_name("NAME");
  slice.add_option("--kernel", a->kernel, "Reconstruction kernel (default: the file's)").type_name("NAME");
  add_threads(slice, a->common);
  add_max_memory(slice, a->common);
  slice.add_flag("--overwrite", a->overwrite, "Replace existing outputs");
  slice.add_flag("--json", a->common.json, "Report as JSON");
  slice.add_flag("--quiet", a->common.quiet, "Print errors only");
  return [a] { return run_slice(*a); };
}

} // namespace bcc4

// SPDX-License-Identifier: Apache-2.0
// bcc4 slice: a hyperplane of a volume as a dense NRRD or OpenVDB box at the source's resolution.
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>

#include "tool/cli.h"
#include "tool/commands/commands.h"
#include "tool/interrupt.h"
#include "tool/json.h"
#include "tool/output/nrrd_output.h"
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
      const double first = even_position(volume, a, begin[k]), length = info.extent[k][1] - begin[k];
      if (length > 0)
        for (size_t r = 0; r < 3; ++r)
          steps[4 * r + k] *= (even_position(volume, a, info.extent[k][1]) - first) / length;
      begin[k] = first;
    }
  const Affine moved = moved_origin(affine, begin);
  for (size_t r = 0; r < 3; ++r) steps[4 * r + 3] = moved[4 * r + 3];
  return steps;
}

// Says what a slice of an uneven volume does not hold.
void warn_of_uneven(const Volume& volume, const Cut& where, bool vdb) {
  if (!has_coordinates(volume)) return;
  if (vdb)
    std::fprintf(stderr,
                 "bcc4: warning: samples are unevenly spaced along an axis, which OpenVDB cannot say: "
                 "they stand evenly in it; NRRD keeps their coordinates\n");
  else if (!where.is_time_slice)
    std::fprintf(stderr,
                 "bcc4: warning: axes are unevenly spaced: the plane is one of samples, and only along "
                 "axes that it keeps are coordinates written\n");
}

const char* slab_name(int32_t slab) {
  return slab == BCCSPLAT_SLAB_SUM ? "sum" : slab == BCCSPLAT_SLAB_MAXIMUM ? "max" : "mean";
}

// Tells where the samples stand along axes that run along unevenly spaced ones of the volume.
void add_coordinates(const Volume& volume, const bccsplat_slice_info& info, NrrdOutput& n) {
  for (size_t k = 0; k < 3; ++k)
    for (uint32_t a = 0; a < 3; ++a) {
      const bccsplat_axis axis = axis_info(volume, a);
      const auto first = static_cast<uint64_t>(std::llround(info.extent[k][0]));
      if (axis.count == 0 || info.basis[k][a] != 1 || first + info.dims[k] > axis.count) continue;
      n.coordinates[k].assign(axis.coordinates + first, axis.coordinates + first + info.dims[k]);
      n.coordinate_units[k] = axis.unit;
      n.coordinates_down[k] = (axis.flags & BCCSPLAT_AXIS_DOWN) != 0;
    }
}

NrrdOutput nrrd_output(const Volume& volume, uint32_t channel, const bccsplat_slice_info& info,
                       const Cut& where) {
  const bccsplat_volume_info v = volume_info(volume);
  const bccsplat_channel_info c = channel_info(volume, channel);
  NrrdOutput n;
  n.content = c.name;
  // A sum along the normal is in another unit.
  if (where.thickness == 0 || where.slab != BCCSPLAT_SLAB_SUM) n.sample_unit = c.unit;
  n.sizes.assign(info.dims, info.dims + 3);
  n.affine = box_affine(volume, info);
  n.spatial_unit = v.spatial_unit;
  add_coordinates(volume, info, n);
  const char* space = nullptr;
  if (where.is_time_slice && bccsplat_volume_find_attribute(volume.get(), "space", &space) == BCCSPLAT_OK)
    n.space = space;
  if (where.is_time_slice) n.keys = time_keys(where.time, v.time_unit);
  const std::vector<std::pair<std::string, std::string>> cut{
      {"bccsplat hyperplane", row(info.hyperplane, 5)},
      {"bccsplat origin", row(info.origin, 4)},
      {"bccsplat basis u", row(info.basis[0], 4)},
      {"bccsplat basis v", row(info.basis[1], 4)},
      {"bccsplat basis w", row(info.basis[2], 4)},
      {"bccsplat first sample", concat(info.extent[0][0], " ", info.extent[1][0], " ", info.extent[2][0])},
      {"bccsplat spacing", "1 1 1"},
      {"bccsplat kernel", info.kernel}};
  n.keys.insert(n.keys.end(), cut.begin(), cut.end());
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
    if (!where.region) keep_sparsity(volume, channel, where.index, values, o);
  } else { // of another kind than the source's frames
    o.grid_class = VdbOutput{}.grid_class;
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

Range write_nrrd_slice(const Slice& slice, const std::string& path, const NrrdOutput& header) {
  OutputFile file(path, true);
  const std::string text = nrrd_header_text(header);
  file.write(std::as_bytes(std::span(text)));
  Range range;
  std::vector<std::byte> bytes;
  sample_planes(slice, [&](uint64_t, std::span<const float> planes) {
    range.add(planes);
    if constexpr (std::endian::native == std::endian::little) {
      file.write(std::as_bytes(planes));
    } else {
      bytes.assign(std::as_bytes(planes).begin(), std::as_bytes(planes).end());
      swap_bytes(bytes, sizeof(float));
      file.write(bytes);
    }
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
  if (lower(path).ends_with(".vdb")) {
#if BCCSPLAT_WITH_OPENVDB
    range = write_vdb_slice(volume, channel, slice, where, path);
#endif
  } else {
    range = write_nrrd_slice(slice, path, nrrd_output(volume, channel, info, where));
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
  const bool vdb = lower(a.output).ends_with(".vdb");
  if (!vdb && !lower(a.output).ends_with(".nrrd")) fail_usage("-o ", a.output, ": must end in .nrrd or .vdb");
#if !BCCSPLAT_WITH_OPENVDB
  if (vdb)
    fail_usage("-o ", a.output, ": this bcc4 was built without OpenVDB (BCCSPLAT_WITH_OPENVDB); .nrrd works");
#endif
  const Device device = create_device(a.common.threads, a.common.max_memory);
  const Volume volume = open_volume(device, a.file, a.kernel);
  if (!a.common.quiet) warn_of_part(volume, a.file);
  const uint32_t channel = find_channel(volume, a.channel);
  const std::vector<Cut> cuts = sweep(volume, a.which);
  const std::vector<std::string> names = sweep_names(a.output, cuts.size());
  for (const std::string& name : names) refuse_existing(name, true);
  if (!a.common.quiet) warn_of_uneven(volume, cuts.front(), vdb);
  Json written = Json::array();
  for (size_t i = 0; i < cuts.size(); ++i) {
    stop_if_interrupted();
    written.push_back(write_slice(volume, a, channel, cuts[i], names[i]));
  }
  if (a.common.json) print_json(a.which.sweep ? Json{{"slices", written}} : written[0]);
  return Exit::ok;
}

} // namespace

Run add_slice(Command tool) {
  auto a = std::make_shared<SliceArguments>();
  const Command slice = tool.add_command("slice", "Cut a hyperplane and write its samples");
  slice.add_option("FILE", a->file, "A .bcc4 file");
  slice.add_option("-o,--output", a->output, "The .nrrd or .vdb file to write").type_name("OUT");
  add_slice_choice(slice, a->which);
  add_sweep(slice, a->which);
  slice.add_option("--channel", a->channel, "Channel, by name or number (default: the first)")
      .type_name("NAME");
  slice.add_option("--kernel", a->kernel, "Reconstruction kernel (default: the file's)").type_name("NAME");
  add_threads(slice, a->common);
  add_max_memory(slice, a->common);
  slice.add_flag("--json", a->common.json, "Report as JSON");
  slice.add_flag("--quiet", a->common.quiet, "Print errors only");
  return [a] { return run_slice(*a); };
}

} // namespace bcc4

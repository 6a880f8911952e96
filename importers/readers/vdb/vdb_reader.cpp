// SPDX-License-Identifier: Apache-2.0
// Opens OpenVDB files, one per frame: unites the bounds of their active voxels, checks that their transforms
// differ by whole voxels only, and reads each grid that was asked for as a channel.
#include "readers/vdb/vdb_reader.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "readers/error.h"
#include "readers/file_times.h"
#include "readers/frame_plan.h"
#include "readers/held_file.h"
#include "readers/utf8.h"
#include "readers/vdb/vdb_grid.h"

namespace bcc4 {
namespace {

using Offset = std::array<int32_t, 3>;

class VdbReader : public FrameReader {
 public:
  VdbReader(SeriesDescription description, std::vector<Offset> origins, uint64_t memory_limit, bool fog,
            std::unique_ptr<VdbFile> first)
      : description_(std::move(description)), origins_(std::move(origins)), memory_limit_(memory_limit),
        fog_(fog), file_(std::move(first)) {}
  const SeriesDescription& description() const override { return description_; }
  std::string frame_name(uint64_t frame) const override { return description_.files[frame].path; }
  Frame read(uint64_t frame, size_t channel) override {
    const Channel& c = description_.channels[channel];
    return hold_file(file_, description_.files[frame].path)
        .read_frame(c.name, origins_[frame], description_.dims, c.air, memory_limit_, fog_);
  }

 private:
  SeriesDescription description_;
  std::vector<Offset> origins_; // grid index of voxel (0, 0, 0) of the series, per file
  uint64_t memory_limit_;
  bool fog_; // level sets
  std::unique_ptr<VdbFile> file_;
};

std::vector<std::string> chosen_grids(const ReaderOptions& options, VdbFile& file, SeriesDescription& d) {
  if (!options.grids.empty()) return options.grids;
  const std::string& path = file.path();
  const std::vector<std::string> all = file.names();
  std::vector<std::string> scalars = file.scalar_names();
  if (scalars.empty()) {
    if (all.empty()) fail_input(path, ": holds no grids");
    (void)file.read_info(all[0], false, false); // says why it cannot be read
    fail_input(path, ": no scalar grid among ", join(all));
  }
  if (scalars.size() == 1) return scalars;
  if (std::find(scalars.begin(), scalars.end(), "density") == scalars.end())
    fail_usage(path, ": several grids: choose with --grid: ", join(scalars));
  d.notes.push_back(concat("of the grids ", join(scalars), " density was taken (use --grid)"));
  return {"density"};
}

// Returns the whole voxels from the grid of `reference` to that of `other`; throws when their transforms
// differ by anything else.
Offset voxel_offset(const VdbGridInfo& reference, const VdbGridInfo& other, const std::string& path) {
  const Affine &a = reference.affine, &b = other.affine;
  const double size = std::cbrt(std::abs(determinant(a)));
  double difference = 0;
  for (size_t i = 0; i < 11; ++i)
    if (i % 4 != 3) difference = std::max(difference, std::abs(a[i] - b[i]));
  if (difference > 1e-6 * size)
    fail_input(path, ": the voxels of grid \"", other.name,
               "\" differ in size or direction from those of the first frame: "
               "resample the sequence to one transform");
  // Cramer's rule solves A * offset = difference of translations.
  const std::array<double, 3> t{b[3] - a[3], b[7] - a[7], b[11] - a[11]};
  Offset offset{};
  for (size_t column = 0; column < 3; ++column) {
    Affine m = a;
    for (size_t row = 0; row < 3; ++row) m[row * 4 + column] = t[row];
    const double voxels = determinant(m) / determinant(a);
    if (std::abs(voxels - std::round(voxels)) > 1e-3 || std::abs(voxels) > 1e9)
      fail_input(path, ": grid \"", other.name, "\" is moved by ", voxels,
                 " voxels against the first frame; only whole voxels can be followed");
    offset[column] = static_cast<int32_t>(std::round(voxels));
  }
  return offset;
}

void add_channel(SeriesDescription& d, const VdbGridInfo& info, bool fog) {
  d.channels.push_back({.name = info.name,
                        .unit = utf8_of(info.told.value_unit),
                        .type = info.type,
                        .precision = info.precision,
                        .air = info.background});
  d.notes.push_back(concat("grid ", info.name, ": ",
                           !info.level_set ? "fog volume"
                           : fog           ? "level set, read as fog"
                                           : "level set (signed distance)",
                           " of ", info.tree_type, info.precision == Type::f16 ? " saved as half" : "",
                           ", background ", info.background));
  d.attributes.emplace_back("openvdb.name." + info.name, info.own_name);
  d.attributes.emplace_back("openvdb.class." + info.name, info.grid_class);
}

VdbBounds moved(VdbBounds bounds, const Offset& by) {
  if (bounds.empty()) return bounds;
  for (size_t a = 0; a < 3; ++a) {
    bounds.begin[a] += by[a];
    bounds.end[a] += by[a];
  }
  return bounds;
}

} // namespace

std::unique_ptr<FrameReader> open_vdb(const Sequence& sequence, const ReaderOptions& options) {
  const std::string& path = sequence.files.front().path;
  refuse_raw_options(options, path, "OpenVDB", false);
  if (!options.channels.empty()) fail_usage("--channel: grids of OpenVDB files are chosen with --grid");
  SeriesDescription d;
  d.format = "OpenVDB";
  d.sparse = true;
  auto first = std::make_unique<VdbFile>(path);
  std::unique_ptr<VdbFile> other;
  const std::vector<std::string> grids = chosen_grids(options, *first, d);
  VdbBounds bounds;
  std::vector<Offset> offsets;
  VdbGridInfo reference;
  size_t empty_frames = 0;
  const bool fog = options.level_set_fog.value_or(false);
  bool level_sets = false;
  std::vector<FileTime> times;
  for (const SequenceFile& f : sequence.files) {
    d.files.push_back({f.path, std::filesystem::file_size(f.path)});
    VdbFile& file = f.path == path ? *first : hold_file(other, f.path);
    VdbBounds frame;
    for (size_t c = 0; c < grids.size(); ++c) {
      const VdbGridInfo info = file.read_info(grids[c], d.channels.size() == c, fog);
      level_sets = level_sets || info.level_set;
      if (d.channels.size() == c) {
        if (c == 0) reference = info;
        add_channel(d, info, fog);
        if (!(std::abs(determinant(info.affine)) > 0))
          fail_input(f.path, ": the transform of grid \"", info.name, "\" is singular");
      }
      Channel& channel = d.channels[c];
      if (info.active && channel.active.size() + 1 == d.files.size()) channel.active.push_back(*info.active);
      if (info.type != channel.type)
        fail_input(f.path, ": grid \"", info.name, "\" holds ", info.tree_type,
                   " values, in the first frame ", type_name(channel.type));
      const Offset offset = voxel_offset(reference, info, f.path);
      if (c == 0) times.push_back({info.told.time, info.told.time_unit});
      if (c == 0)
        offsets.push_back(offset);
      else if (offset != offsets.back())
        fail_input(f.path, ": grids \"", grids[0], "\" and \"", grids[c], "\" are moved against each other");
      frame.unite(moved(info.bounds, offset));
    }
    empty_frames += frame.empty();
    bounds.unite(frame);
  }
  for (Channel& channel : d.channels)
    if (channel.active.size() < d.files.size()) channel.active.clear();
  if (options.level_set_fog && !level_sets)
    fail_usage("--level-set: ", path, " has no level set among ", join(grids));
  if (bounds.empty()) fail_input(path, ": no active voxels in any frame");

  std::array<double, 3> begin{};
  for (size_t a = 0; a < 3; ++a) {
    const int64_t samples = int64_t{bounds.end[a]} - bounds.begin[a];
    if (samples > INT32_MAX) fail_input(path, ": the active voxels span ", samples, " voxels along one axis");
    d.dims[a] = samples;
    begin[a] = bounds.begin[a];
  }
  std::vector<Offset> origins;
  for (const Offset& o : offsets)
    origins.push_back({bounds.begin[0] - o[0], bounds.begin[1] - o[1], bounds.begin[2] - o[2]});
  d.dims[3] = sequence.files.size();
  d.affine = moved_origin(reference.affine, begin);
  d.affine_origin = "transform of the grid";
  d.spatial_unit = reference.told.space_unit;
  d.axes = "x, y, z as in the grid";
  d.notes.push_back(concat("active voxels of all frames lie in (", bounds.begin[0], ", ", bounds.begin[1],
                           ", ", bounds.begin[2], ") to (", bounds.end[0] - 1, ", ", bounds.end[1] - 1, ", ",
                           bounds.end[2] - 1, ")",
                           empty_frames > 0 ? concat("; ", empty_frames, " frames have none") : ""));
  if (!sequence.note.empty()) d.notes.push_back(sequence.note);
  take_file_times(d, times, "time");
  FramePlan plan = plan_files(sequence, options);
  return planned_series(std::make_unique<VdbReader>(std::move(d), std::move(origins), memory_limit(options),
                                                    fog, std::move(first)),
                        std::move(plan), options);
}

} // namespace bcc4

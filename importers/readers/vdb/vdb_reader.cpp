// SPDX-License-Identifier: Apache-2.0
// Opens OpenVDB files, one per frame, and reads each grid of the survey as a channel.
#include "readers/vdb/vdb_reader.h"

#include <filesystem>

#include "readers/error.h"
#include "readers/file_times.h"
#include "readers/frame_plan.h"
#include "readers/held_file.h"
#include "readers/text.h"
#include "readers/vdb/vdb_grid.h"
#include "readers/vdb/vdb_survey.h"

namespace bcc4 {
namespace {

class VdbReader : public FrameReader {
 public:
  VdbReader(SeriesDescription description, std::vector<VoxelOffset> origins, VdbSurvey survey,
            uint64_t memory_limit, std::unique_ptr<VdbFile> first)
      : description_(std::move(description)), origins_(std::move(origins)), survey_(std::move(survey)),
        memory_limit_(memory_limit), file_(std::move(first)) {}
  const SeriesDescription& description() const override { return description_; }
  std::string frame_name(uint64_t frame) const override { return description_.files[frame].path; }
  Frame read(uint64_t frame, size_t channel) override {
    const Channel& c = description_.channels[channel];
    if (!survey_.grids()[channel].present[frame]) return {};
    return hold_file(file_, description_.files[frame].path)
        .read_frame(c.name, origins_[frame], description_.dims, c.air, memory_limit_, survey_.fog());
  }

 private:
  SeriesDescription description_;
  std::vector<VoxelOffset> origins_; // grid index of voxel (0, 0, 0) of the series, per file
  VdbSurvey survey_;
  uint64_t memory_limit_;
  std::unique_ptr<VdbFile> file_;
};

std::vector<std::string> names_of(const std::vector<Channel>& channels) {
  std::vector<std::string> names;
  for (const Channel& channel : channels) names.push_back(channel.name);
  return names;
}

void add_channel(SeriesDescription& d, const SurveyedGrid& grid, bool fog) {
  const VdbGridInfo& info = *grid.info;
  d.channels.push_back({.name = info.name,
                        .unit = utf8_of(info.told.value_unit),
                        .type = info.type,
                        .precision = info.precision,
                        .air = info.background,
                        .active = grid.active});
  d.notes.push_back(concat("grid ", info.name, ": ",
                           !info.level_set ? "fog volume"
                           : fog           ? "level set, read as fog"
                                           : "level set (signed distance)",
                           " of ", info.tree_type, info.precision == Type::f16 ? " saved as half" : "",
                           ", background ", info.background));
  d.attributes.emplace_back("openvdb.name." + info.name, info.own_name);
  d.attributes.emplace_back("openvdb.class." + info.name, info.grid_class);
  if (info.tree_type == "double") d.attributes.emplace_back("openvdb.type." + info.name, info.tree_type);
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
  VdbSurvey survey(options);
  for (const SequenceFile& f : sequence.files) {
    d.files.push_back({f.path, std::filesystem::file_size(f.path)});
    survey.add(f.path == path ? *first : hold_file(other, f.path));
  }
  survey.finish(*first);
  d.notes = survey.notes();
  for (const SurveyedGrid& grid : survey.grids()) add_channel(d, grid, survey.fog());
  if (options.level_set_fog && !survey.level_sets())
    fail_usage("--level-set: ", path, " has no level set among ", join(names_of(d.channels)));
  const VdbBounds& bounds = survey.bounds();
  if (bounds.empty()) fail_input(path, ": no active voxels in any frame");

  std::array<double, 3> begin{};
  for (size_t a = 0; a < 3; ++a) {
    const int64_t samples = int64_t{bounds.end[a]} - bounds.begin[a];
    if (samples > INT32_MAX) fail_input(path, ": the active voxels span ", samples, " voxels along one axis");
    d.dims[a] = samples;
    begin[a] = bounds.begin[a];
  }
  std::vector<VoxelOffset> origins;
  for (const VoxelOffset& o : survey.offsets())
    origins.push_back({bounds.begin[0] - o[0], bounds.begin[1] - o[1], bounds.begin[2] - o[2]});
  d.dims[3] = sequence.files.size();
  d.affine = moved_origin(survey.reference().affine, begin);
  d.affine_origin = "transform of the grid";
  d.attributes.emplace_back("openvdb.begin",
                            concat(bounds.begin[0], " ", bounds.begin[1], " ", bounds.begin[2]));
  d.spatial_unit = survey.reference().told.space_unit;
  d.axes = "x, y, z as in the grid";
  d.notes.push_back(
      concat("active voxels of all frames lie in (", bounds.begin[0], ", ", bounds.begin[1], ", ",
             bounds.begin[2], ") to (", bounds.end[0] - 1, ", ", bounds.end[1] - 1, ", ", bounds.end[2] - 1,
             ")", survey.empty_frames() > 0 ? concat("; ", survey.empty_frames(), " frames have none") : ""));
  if (!sequence.note.empty()) d.notes.push_back(sequence.note);
  take_file_times(d, survey.times(), "time");
  FramePlan plan = plan_files(sequence, options);
  return planned_series(std::make_unique<VdbReader>(std::move(d), std::move(origins), std::move(survey),
                                                    memory_limit(options), std::move(first)),
                        std::move(plan), options);
}

} // namespace bcc4

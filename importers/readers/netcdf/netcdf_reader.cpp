// SPDX-License-Identifier: Apache-2.0
// Opens variables of NetCDF files as a series. Each file is described by itself: what its numbers mean, where
// its samples are and when; then it is joined to the first one, or refused.
#include "readers/netcdf/netcdf_reader.h"

#include <algorithm>

#include "readers/error.h"
#include "readers/frame_plan.h"
#include "readers/netcdf/netcdf_axes.h"
#include "readers/netcdf/netcdf_channels.h"
#include "readers/netcdf/netcdf_file.h"
#include "readers/netcdf/netcdf_frames.h"
#include "readers/netcdf/netcdf_space.h"
#include "readers/netcdf/netcdf_times.h"

namespace bcc4 {
namespace {

// Returns the frames in a file: the size of its time axis, 1 without one. Sizes are checked before anything
// is read.
uint64_t check_sizes(const NetcdfFile& file, const NetcdfVariable& v, const std::vector<AxisRole>& roles,
                     Type type, uint64_t limit) {
  uint64_t frames = 1, bytes = type_size(type);
  for (size_t a = 0; a < roles.size(); ++a) {
    const auto& [id, name, size, record] = v.dims[a];
    if (size == 0) fail_input(file.path(), ": dimension ", name, " has no samples");
    if (size > INT32_MAX || bytes > UINT64_MAX / 4 / size)
      fail_input(file.path(), ": dimension ", name, " has ", size, " samples: too many");
    (roles[a] == AxisRole::t ? frames : bytes) *= size;
  }
  if (const uint64_t held = std::max(bytes, file.chunk_bytes(v)); held > limit)
    fail_resources(file.path(), ": one frame takes ", byte_text(static_cast<double>(held)),
                   ", more than the ", byte_text(static_cast<double>(limit)), " allowed: raise --max-mem");
  return frames;
}

void describe_axes(SeriesDescription& d, const NetcdfFile& file, const NetcdfVariable& v,
                   const NetcdfAxes& axes) {
  for (size_t a = axes.roles.size(); a-- > 0;) {
    const auto r = static_cast<size_t>(axes.roles[a]);
    if (axes.roles[a] != AxisRole::t) d.dims[r] = v.dims[a].size;
    d.axes += concat(d.axes.empty() ? "" : ", ", "xyzt"[r], " ", v.dims[a].size, " (", v.dims[a].name, ")");
    const NetcdfVariable* const at = file.coordinate(v, v.dims[a]);
    const bool named = !v.dims[a].name.starts_with("phony_dim_"); // of HDF5 without scales, by the library
    keep_axis(d, r, named ? v.dims[a].name : "",
              at ? file.attributes(*at, axes.roles[a] == AxisRole::t) : Record::object());
  }
  d.axes += "; " + axes.why;
}

// Joins the files, one after the other.
class NetcdfSeries {
 public:
  NetcdfSeries(const Sequence& sequence, const ReaderOptions& options)
      : options_(options), clock_(options.dt || options.times) {
    d_.format = "NetCDF";
    for (const SequenceFile& f : sequence.files) add(std::make_unique<NetcdfFile>(f.path));
    d_.dims[3] = frames_;
    for (const NetcdfChannel& c : channels_) describe_channel(d_, c);
    clock_.describe(d_);
    if (sequence.files.size() > 1) d_.notes.push_back(sequence.note);
  }
  [[nodiscard]] uint64_t frames() const { return frames_; }

  std::unique_ptr<FrameReader> reader() {
    return netcdf_frames(std::move(d_), std::move(channels_), std::move(axes_.roles), std::move(parts_),
                         std::move(file_));
  }

 private:
  void add(std::unique_ptr<NetcdfFile> opened) {
    const NetcdfFile& file = *opened;
    const std::vector<const NetcdfVariable*> variables = add_channels(file);
    const NetcdfVariable& v = *variables[0];
    NetcdfAxes axes = find_axes(file, v, options_.axes.value_or(""));
    const Type type = channels_[0].of_files.back().value_type();
    NetcdfPart part{.path = file.path(),
                    .first = frames_,
                    .count = check_sizes(file, v, axes.roles, type, memory_limit(options_)),
                    .turned = {}};
    add_times(file, v, axes.roles, part.count);
    NetcdfSpace space = netcdf_space(file, v, axes.roles);
    if (parts_.empty()) {
      describe_axes(d_, file, v, axes);
      for (const NetcdfVariable* channel : variables)
        keep_channel(d_, channel->name, file.attributes(*channel));
      describe_space(d_, space);
      axes_ = std::move(axes);
      space_ = std::move(space);
    } else if (axes.roles != axes_.roles) {
      fail_input(file.path(), ": the axes of ", v.name, " are not those of the first file");
    } else {
      part.turned = turned_axes(d_, space_, space, file.path(), options_.spacing.has_value());
    }
    d_.files.push_back({file.path(), file_size(file.path())});
    frames_ += part.count;
    parts_.push_back(std::move(part));
    if (!file_) file_ = std::move(opened);
  }

  std::vector<const NetcdfVariable*> add_channels(const NetcdfFile& file) {
    if (channels_.empty())
      for (const std::string& name : chosen_variables(file, options_)) channels_.push_back({name, "", {}});
    std::vector<std::string> names;
    for (const NetcdfChannel& c : channels_) names.push_back(c.name);
    std::vector<const NetcdfVariable*> variables = find_variables(file, names);
    for (size_t c = 0; c < channels_.size(); ++c) add_file(channels_[c], file, *variables[c]);
    return variables;
  }

  void add_times(const NetcdfFile& file, const NetcdfVariable& v, const std::vector<AxisRole>& roles,
                 uint64_t frames) {
    const auto time = std::find(roles.begin(), roles.end(), AxisRole::t);
    const NetcdfDimension* const dim = time == roles.end() ? nullptr : &v.dims[time - roles.begin()];
    clock_.add(netcdf_times(file, v, dim), frames, file.path());
  }

  const ReaderOptions& options_;
  NetcdfClock clock_;
  SeriesDescription d_;
  std::vector<NetcdfChannel> channels_;
  std::vector<NetcdfPart> parts_;
  std::unique_ptr<NetcdfFile> file_; // the first one
  NetcdfAxes axes_;                  // of the first file, as what follows
  NetcdfSpace space_;
  uint64_t frames_ = 0;
};

} // namespace

std::unique_ptr<FrameReader> open_netcdf(const Sequence& sequence, const ReaderOptions& options) {
  const std::string& path = sequence.files.front().path;
  refuse_raw_options(options, path, "NetCDF", true);
  refuse_grid_option(options, path, "NetCDF");
  NetcdfSeries series(sequence, options);
  FramePlan plan = plan_frames(sequence, series.frames(), options);
  return planned_series(series.reader(), std::move(plan), options);
}

} // namespace bcc4

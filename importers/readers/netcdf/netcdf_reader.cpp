// SPDX-License-Identifier: Apache-2.0
// Opens variables of NetCDF files as a series: chooses the variables, tells axes, scaling, holes and times by
// the CF conventions, and joins files along time.
#include "readers/netcdf/netcdf_reader.h"

#include <algorithm>
#include <cmath>

#include <netcdf.h>

#include "readers/affine.h"
#include "readers/error.h"
#include "readers/frame_plan.h"
#include "readers/held_file.h"
#include "readers/netcdf/even_levels.h"
#include "readers/netcdf/netcdf_axes.h"
#include "readers/netcdf/netcdf_file.h"
#include "readers/stored_values.h"

namespace bcc4 {
namespace {

// A coordinate variable says where the samples of a dimension of its name are.
bool is_coordinate(const NetcdfVariable& v) { return v.dims.size() == 1 && v.dims[0].name == v.name; }

std::vector<std::string> candidates(const NetcdfFile& file) {
  std::vector<std::string> names;
  for (const NetcdfVariable& v : file.variables()) {
    const auto wide = std::count_if(v.dims.begin(), v.dims.end(), [](const auto& d) { return d.size > 1; });
    if (v.type && wide >= 3 && !is_coordinate(v)) names.push_back(v.name);
  }
  return names;
}

std::vector<std::string> chosen_variables(const NetcdfFile& file, const ReaderOptions& options) {
  std::vector<std::string> names = candidates(file);
  if (options.channels.empty()) {
    if (names.empty()) fail_input(file.path(), ": no variable of numbers over three or four dimensions");
    if (names.size() > 1)
      fail_usage(file.path(), ": ", names.size(), " variables: choose with --channel among ",
                 join(names, " and "));
    return names;
  }
  for (const std::string& name : options.channels)
    if (const NetcdfVariable* v = file.find(name); !v || !v->type)
      fail_usage(file.path(), ": no variable \"", name, "\"", did_you_mean(name, names), "; it has ",
                 join(names));
  return options.channels;
}

StoredValues stored_values(const NetcdfFile& file, const NetcdfVariable& v) {
  StoredValues s;
  s.type = *v.type;
  if (const auto n = file.numbers(v, "scale_factor"); n.size() == 1) s.slope = n[0];
  if (const auto n = file.numbers(v, "add_offset"); n.size() == 1) s.intercept = n[0];
  if (s.slope == 0 || !std::isfinite(s.slope) || !std::isfinite(s.intercept))
    fail_input(file.path(), ": ", v.name, " = ", s.slope, " x stored + ", s.intercept, " says nothing");
  for (const char* name : {"_FillValue", "missing_value"})
    for (const double fill : file.numbers(v, name))
      if (!std::isnan(fill)) s.fills.push_back(fill);
  // Integers have a default fill value as well, but marking it would turn them all into floats.
  if (s.fills.empty() && is_float(s.type))
    if (const auto fill = file.default_fill(v)) s.fills.push_back(*fill);
  const double infinity = HUGE_VAL;
  std::array<double, 2> valid{-infinity, infinity};
  if (const auto n = file.numbers(v, "valid_range"); n.size() == 2) valid = {n[0], n[1]};
  if (const auto n = file.numbers(v, "valid_min"); n.size() == 1) valid[0] = n[0];
  if (const auto n = file.numbers(v, "valid_max"); n.size() == 1) valid[1] = n[0];
  if (valid[0] > -infinity || valid[1] < infinity) s.valid = valid;
  return s;
}

struct NetcdfChannel {
  std::string variable;
  StoredValues values;
};

// Frames first .. first + count - 1 of the series.
struct NetcdfPart {
  std::string path;
  uint64_t first = 0, count = 1;
};

class NetcdfReader : public FrameReader {
 public:
  NetcdfReader(SeriesDescription description, std::vector<NetcdfChannel> channels,
               std::vector<AxisRole> roles, std::vector<NetcdfPart> parts, std::unique_ptr<NetcdfFile> first)
      : description_(std::move(description)), channels_(std::move(channels)), roles_(std::move(roles)),
        parts_(std::move(parts)), file_(std::move(first)) {}

  const SeriesDescription& description() const override { return description_; }
  std::string frame_name(uint64_t frame) const override { return part_of(frame).path; }

  Frame read(uint64_t frame, size_t channel) override {
    const NetcdfPart& part = part_of(frame);
    const NetcdfFile& file = hold_file(file_, part.path);
    const NetcdfChannel& c = channels_[channel];
    const NetcdfVariable* v = file.find(c.variable);
    if (!v || v->type != c.values.type || v->dims.size() != roles_.size())
      fail_input(part.path, ": variable ", c.variable, " is not as in the first file");
    std::vector<size_t> start(roles_.size(), 0), count(roles_.size(), 1);
    std::vector<FileAxis> axes;
    size_t bytes = type_size(c.values.type);
    for (size_t a = 0; a < roles_.size(); ++a) {
      const uint64_t size =
          roles_[a] == AxisRole::t ? part.count : description_.dims[static_cast<size_t>(roles_[a])];
      if (v->dims[a].size != size)
        fail_input(part.path, ": dimension ", v->dims[a].name, " has ", v->dims[a].size, " samples, not ",
                   size);
      if (roles_[a] == AxisRole::t)
        start[a] = frame - part.first;
      else
        bytes *= count[a] = size;
    }
    for (size_t a = roles_.size(); a-- > 0;) axes.push_back({roles_[a], count[a]});
    auto values = std::make_shared<Bytes>(bytes);
    file.read(*v, start, count, *values);
    c.values.convert(*values);
    return dense_frame(description_.channels[channel].type, std::move(values), axes);
  }

 private:
  const NetcdfPart& part_of(uint64_t frame) const {
    const auto next = std::upper_bound(parts_.begin(), parts_.end(), frame,
                                       [](uint64_t f, const NetcdfPart& p) { return f < p.first; });
    return *(next - 1);
  }

  SeriesDescription description_;
  std::vector<NetcdfChannel> channels_;
  std::vector<AxisRole> roles_;
  std::vector<NetcdfPart> parts_;
  std::unique_ptr<NetcdfFile> file_;
};

// Returns whether positions are even to a thousandth of a step.
bool evenly_spaced(const std::vector<double>& at) {
  const double step = (at.back() - at.front()) / static_cast<double>(at.size() - 1);
  bool even = step != 0 && std::isfinite(step);
  for (size_t i = 0; i < at.size(); ++i)
    even = even && std::abs(at[i] - (at[0] + static_cast<double>(i) * step)) <= 1e-3 * std::abs(step);
  return even;
}

// Makes spacing and origin of even steps, in z with depths below 0. Returns uneven levels, which are to be
// resampled unless the user gives the spacing; other axes cannot be, and a note says so.
std::optional<EvenLevels> set_affine(SeriesDescription& d, const NetcdfFile& file, const NetcdfVariable& v,
                                     const std::vector<AxisRole>& roles, bool keep_levels) {
  std::optional<EvenLevels> uneven;
  std::array<std::array<double, 3>, 3> columns{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  std::array<double, 3> origin{};
  std::vector<std::string> known, units, same;
  for (size_t a = 0; a < roles.size(); ++a) {
    if (roles[a] == AxisRole::t) continue;
    const auto r = static_cast<size_t>(roles[a]);
    const NetcdfVariable* coordinate = file.find(v.dims[a].name);
    if (!coordinate || !is_coordinate(*coordinate) || !coordinate->type || v.dims[a].size < 2) continue;
    const std::vector<double> at = file.line(*coordinate);
    double first = at[0], step = (at.back() - at.front()) / static_cast<double>(at.size() - 1);
    if (!evenly_spaced(at)) {
      if (r != 2 || keep_levels || !strictly_monotonic(at)) {
        d.warnings.push_back(concat(v.dims[a].name, " is not evenly spaced (", short_number(at[0]), " to ",
                                    short_number(at.back()),
                                    "): its index is the coordinate; --spacing sets another"));
        continue;
      }
      uneven = even_levels(at);
      step = uneven->step;
      d.notes.push_back(concat(v.dims[a].name, ": ", at.size(), " uneven levels, ", short_number(at[0]),
                               " to ", short_number(at.back()), ", are sampled at ", uneven->count,
                               " even ones, linearly between them; --spacing keeps them as they are"));
    }
    if (r == 2 && lower(file.text(*coordinate, "positive")) == "down") {
      first = -first, step = -step;
      d.notes.push_back(concat(v.dims[a].name, " counts down: z is what is above its 0"));
    }
    columns[r][r] = step;
    origin[r] = first;
    known.push_back(v.dims[a].name);
    if (const std::string unit = file.text(*coordinate, "units"); !unit.empty()) {
      // "degrees_north", "degree_E" and the like of longitude and latitude are one.
      units.push_back(unit);
      same.push_back(lower(unit).starts_with("degree") ? "degrees" : unit);
    }
  }
  d.affine = affine_from_columns(columns, origin);
  d.affine_origin = known.empty() ? "none given: one unit per voxel" : "coordinate variables " + join(known);
  const bool agree =
      !same.empty() && std::all_of(same.begin(), same.end(), [&](const auto& u) { return u == same[0]; });
  if (agree) d.spatial_unit = same[0];
  if (!agree && !same.empty())
    d.notes.push_back(concat("the axes have different units: ", join(units),
                             "; pictures take them for one: --spacing SX,SY,SZ gives the box another shape"));
  return uneven;
}

// Appends the times of the frames of one file; a file without them leaves the whole series without.
void add_times(SeriesDescription& d, const NetcdfFile& file, const NetcdfVariable& v,
               const std::vector<AxisRole>& roles, bool first) {
  const auto time = std::find(roles.begin(), roles.end(), AxisRole::t);
  if (time == roles.end()) return;
  const NetcdfDimension& dim = v.dims[time - roles.begin()];
  const NetcdfVariable* coordinate = file.find(dim.name);
  if (!coordinate || !is_coordinate(*coordinate) || !coordinate->type) return;
  const std::string units = file.text(*coordinate, "units");
  const size_t since = units.find(" since ");
  const std::string epoch = since == std::string::npos ? "" : std::string(trim(units.substr(since + 7)));
  if (first) {
    d.times.unit = std::string(trim(units.substr(0, since)));
    d.times.origin = "coordinate variable " + dim.name;
    if (!epoch.empty()) d.attributes.emplace_back("time_epoch", epoch);
  } else if (const auto old = std::find_if(d.attributes.begin(), d.attributes.end(),
                                           [](const auto& a) { return a.first == "time_epoch"; });
             std::string(trim(units.substr(0, since))) != d.times.unit ||
             epoch != (old == d.attributes.end() ? "" : old->second)) {
    fail_input(file.path(), ": its times are in \"", units,
               "\", not in the unit of the first file: give --dt or --times");
  }
  for (const double t : file.line(*coordinate)) d.times.values.push_back(t);
}

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
    fail(Exit::no_resources, file.path(), ": one frame takes ", byte_text(static_cast<double>(held)),
         ", more than the ", byte_text(static_cast<double>(limit)), " allowed: raise --max-mem");
  return frames;
}

void describe_axes(SeriesDescription& d, const NetcdfVariable& v, const NetcdfAxes& axes) {
  for (size_t a = axes.roles.size(); a-- > 0;) {
    const auto r = static_cast<size_t>(axes.roles[a]);
    if (axes.roles[a] != AxisRole::t) d.dims[r] = v.dims[a].size;
    d.axes += concat(d.axes.empty() ? "" : ", ", "xyzt"[r], " ", v.dims[a].size, " (", v.dims[a].name, ")");
  }
  d.axes += "; " + axes.why;
}

void describe_channels(SeriesDescription& d, const NetcdfFile& file, const NetcdfVariable& first,
                       const std::vector<NetcdfChannel>& channels) {
  for (const NetcdfChannel& c : channels) {
    const NetcdfVariable& own = *file.find(c.variable);
    const auto same = [](const NetcdfDimension& p, const NetcdfDimension& q) { return p.id == q.id; };
    if (!std::equal(own.dims.begin(), own.dims.end(), first.dims.begin(), first.dims.end(), same))
      fail_usage(file.path(), ": ", own.name, " and ", first.name,
                 " have different dimensions: import them one by one");
    d.channels.push_back({.name = own.name,
                          .unit = file.text(own, "units"),
                          .type = c.values.value_type(),
                          .has_fill = !c.values.fills.empty() || c.values.valid.has_value()});
    c.values.describe(d.channels.back(), d);
    if (c.values.valid)
      d.notes.push_back(concat(own.name, ": stored values outside ", short_number((*c.values.valid)[0]),
                               " to ", short_number((*c.values.valid)[1]), " are holes (valid range)"));
  }
}

} // namespace

std::unique_ptr<FrameReader> open_netcdf(const Sequence& sequence, const ReaderOptions& options) {
  const std::string& path = sequence.files.front().path;
  refuse_raw_options(options, path, "NetCDF", true);
  refuse_grid_option(options, path, "NetCDF");

  SeriesDescription d;
  d.format = "NetCDF";
  std::vector<NetcdfChannel> channels;
  NetcdfAxes axes;
  std::vector<NetcdfPart> parts;
  std::unique_ptr<NetcdfFile> first_file;
  std::optional<EvenLevels> uneven;
  uint64_t frames = 0;
  bool timed = true;
  for (const SequenceFile& f : sequence.files) {
    auto opened = std::make_unique<NetcdfFile>(f.path);
    const NetcdfFile& file = *opened;
    const bool first = parts.empty();
    if (first)
      for (const std::string& name : chosen_variables(file, options))
        channels.push_back({name, stored_values(file, *file.find(name))});
    const NetcdfVariable* v = file.find(channels[0].variable);
    if (!v) fail_input(f.path, ": no variable \"", channels[0].variable, "\" as in the first file");
    const NetcdfAxes own = find_axes(file, *v, options.axes.value_or(""));
    const uint64_t count =
        check_sizes(file, *v, own.roles, channels[0].values.value_type(), memory_limit(options));
    if (first) {
      axes = own;
      describe_axes(d, *v, axes);
      uneven = set_affine(d, file, *v, axes.roles, options.spacing.has_value());
      describe_channels(d, file, *v, channels);
    } else if (own.roles != axes.roles) {
      fail_input(f.path, ": the axes of ", v->name, " are not those of the first file");
    }
    const size_t before = d.times.values.size();
    add_times(d, file, *v, axes.roles, first);
    timed = timed && d.times.values.size() == before + count;
    d.files.push_back({f.path, file_size(f.path)});
    parts.push_back({f.path, frames, count});
    frames += count;
    if (first) first_file = std::move(opened);
  }
  if (!timed) d.times = {};
  d.dims[3] = frames;
  if (sequence.files.size() > 1) d.notes.push_back(sequence.note);
  FramePlan plan = plan_frames(sequence, frames, options);
  std::unique_ptr<FrameReader> reader = std::make_unique<NetcdfReader>(
      std::move(d), std::move(channels), std::move(axes.roles), std::move(parts), std::move(first_file));
  if (uneven) reader = resample_levels(std::move(reader), *uneven);
  return planned_series(std::move(reader), std::move(plan), options);
}

} // namespace bcc4

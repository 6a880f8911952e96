// SPDX-License-Identifier: Apache-2.0
// Opens MetaImage files as one dense array: roles of the axes, affine and times from the header, frames by
// DenseSeries. It is the model for new readers of dense formats.
#include "readers/metaimage/metaimage_reader.h"

#include <algorithm>
#include <cmath>

#include "readers/affine.h"
#include "readers/components.h"
#include "readers/dense_reader.h"
#include "readers/error.h"
#include "readers/file_times.h"
#include "readers/frame_plan.h"
#include "readers/metaimage/metaimage_header.h"
#include "readers/records.h"
#include "readers/same_place.h"

namespace bcc4 {
namespace {

// The field of a frame in a file that holds a sequence, as Plus and IGSIO write them.
std::string frame_field(uint64_t frame, const char* name) {
  std::string digits = concat(frame);
  if (digits.size() < 4) digits.insert(0, 4 - digits.size(), '0');
  return concat("Seq_Frame", digits, "_", name);
}

std::optional<double> timestamp(const MetaImageHeader& h, uint64_t frame) {
  const auto found = h.other.find(frame_field(frame, "Timestamp"));
  return found == h.other.end() ? std::nullopt : parse_number<double>(found->second);
}

// Whether the last axis counts frames: fields of its last one are there, and none behind.
bool ends_in_frames(const MetaImageHeader& h) {
  return timestamp(h, h.sizes.back() - 1) && !timestamp(h, h.sizes.back());
}

std::vector<AxisRole> find_roles(const MetaImageHeader& h, const std::optional<std::string>& letters) {
  if (letters) return roles_from_letters(*letters, h.sizes.size(), h.path);
  std::vector<AxisRole> roles;
  for (size_t a = 0; a < h.sizes.size(); ++a) {
    if (a > 3 && h.sizes[a] > 1) fail_input(h.path, ": ", h.sizes.size(), " axes; four can be read");
    roles.push_back(static_cast<AxisRole>(std::min<size_t>(a, 3)));
  }
  roles.resize(std::min<size_t>(roles.size(), 4));
  if (roles.size() == 3 && h.sizes[2] > 1 && ends_in_frames(h)) roles[2] = AxisRole::t; // of pictures
  return roles;
}

DenseLayout layout_of(const MetaImageHeader& h, const std::vector<AxisRole>& roles) {
  DenseLayout layout;
  layout.type = h.type, layout.slope = h.slope, layout.intercept = h.intercept;
  layout.swap = h.encoding != Encoding::ascii && needs_swap(h.big_endian);
  if (h.channels > 1) layout.axes.push_back({AxisRole::component, h.channels});
  for (size_t a = 0; a < roles.size(); ++a) layout.axes.push_back({roles[a], h.sizes[a]});
  return layout;
}

// Whether the letters name the sides that the axes of space begin at, of a world to the left, back and up.
bool fits_world(const std::string& letters, const std::vector<AxisRole>& roles, const Affine& m) {
  for (size_t a = 0; a < roles.size(); ++a) {
    if (roles[a] == AxisRole::t) continue;
    if (a >= letters.size()) return false;
    const size_t low = std::string_view("RAI").find(letters[a]),
                 high = std::string_view("LPS").find(letters[a]);
    const size_t row = std::min(low, high); // of the world axis between the two sides
    if (row > 2) return false;
    const double step = m[4 * row + static_cast<size_t>(roles[a])];
    if (low == row ? step <= 0 : step >= 0) return false;
  }
  return true;
}

// The world of MetaImage is that of ITK, LPS. Files of other fields than medicine have no orientation.
void set_space(SeriesDescription& d, const MetaImageHeader& h, const std::vector<AxisRole>& roles) {
  const auto found = h.other.find("AnatomicalOrientation");
  if (found == h.other.end() || found->second.find_first_not_of('?') == std::string::npos) return;
  d.attributes.emplace_back("anatomical_orientation", found->second);
  if (fits_world(found->second, roles, d.affine))
    d.attributes.emplace_back("space", "left-posterior-superior");
  else
    d.notes.push_back(concat("AnatomicalOrientation ", found->second,
                             " is not that of the axes: where left, back and up are stays open"));
}

void set_affine(SeriesDescription& d, const MetaImageHeader& h, const std::vector<AxisRole>& roles,
                const ReaderOptions& options) {
  std::array<std::array<double, 3>, 3> columns{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  std::array<double, 3> origin{};
  const size_t n = h.sizes.size();
  for (size_t a = 0; a < roles.size(); ++a) {
    if (roles[a] == AxisRole::t) continue;
    const auto r = static_cast<size_t>(roles[a]);
    if (!h.direction.empty())
      for (size_t i = 0; i < 3; ++i) columns[r][i] = i < n ? h.direction[a * n + i] : i == r;
    for (double& c : columns[r]) c *= h.spacing.empty() ? 1 : h.spacing[a];
  }
  for (size_t i = 0; i < std::min<size_t>(3, h.origin.size()); ++i) origin[i] = h.origin[i];
  d.affine = affine_from_columns(columns, origin);
  require_volume(d.affine, options, h.path, "its affine (TransformMatrix and ElementSpacing)");
  d.affine_origin = h.spacing.empty()     ? "none given: one unit per voxel"
                    : h.direction.empty() ? "ElementSpacing and Offset"
                                          : "ElementSpacing, TransformMatrix and Offset";
  if (const auto unit = h.other.find("DistanceUnits"); unit != h.other.end() && unit->second != "?")
    d.spatial_unit = unit->second;
  set_space(d, h, roles);
}

// Keeps what made the data, where that is a scanner.
void keep_modality(SeriesDescription& d, const MetaImageHeader& h) {
  const auto found = h.other.find("Modality");
  if (found == h.other.end() || (found->second != "MET_MOD_CT" && found->second != "MET_MOD_MR")) return;
  for (const Channel& c : d.channels)
    keep_kind(d, c.name, found->second == "MET_MOD_CT" ? DataKind::ct : DataKind::mr);
}

// Takes the times that the frames of one file tell; returns whether they do.
bool take_timestamps(SeriesDescription& d, const MetaImageHeader& h, uint64_t frames) {
  std::vector<FileTime> told;
  for (uint64_t f = 0; f < frames; ++f) told.push_back({timestamp(h, f), "s"});
  if (!told[0].time && !told.back().time) return false;
  take_file_times(d, told, "Seq_FrameNNNN_Timestamp");
  if (!d.times.values.empty()) d.times.origin = "Seq_FrameNNNN_Timestamp of the header";
  return !d.times.values.empty();
}

void set_times(SeriesDescription& d, const MetaImageHeader& h, const std::vector<AxisRole>& roles) {
  const auto time = std::find(roles.begin(), roles.end(), AxisRole::t);
  if (time == roles.end()) return;
  const size_t a = time - roles.begin();
  if (take_timestamps(d, h, h.sizes[a]) || h.spacing.empty()) return;
  const double step = h.spacing[a], first = a < h.origin.size() ? h.origin[a] : 0;
  if (!(step > 0)) return;
  for (uint64_t i = 0; i < h.sizes[a]; ++i) d.times.values.push_back(first + static_cast<double>(i) * step);
  d.times.origin = concat("ElementSpacing ", step, " of axis ", a);
}

} // namespace

bool is_metaimage(std::string_view start) {
  for (const std::string_view key : {"ObjectType", "NDims", "Comment"})
    if (start.starts_with(key) && start.find('=') != std::string_view::npos) return true;
  return false;
}

std::unique_ptr<FrameReader> open_metaimage(const Sequence& sequence, const ReaderOptions& options) {
  const std::string& path = sequence.files.front().path;
  refuse_raw_options(options, path, "MetaImage", true);
  refuse_grid_option(options, path, "MetaImage");
  const bool file_per_frame = sequence.files.size() > 1;
  const MetaImageHeader first = read_metaimage_header(path);
  const std::vector<AxisRole> roles = find_roles(first, options.axes);
  DenseLayout layout = layout_of(first, roles);
  uint64_t frames = layout.size_of(AxisRole::t);

  SeriesDescription d;
  std::vector<Segment> segments;
  const auto add_file = [&](const MetaImageHeader& h, size_t number) {
    if (file_per_frame && frames > 1) fail_usage(h.path, " is a series of its own: give it alone");
    if (h.type != first.type || h.big_endian != first.big_endian || h.sizes != first.sizes ||
        h.channels != first.channels)
      refuse_unlike(sequence, number, "sizes or type");
    if (h.slope != first.slope || h.intercept != first.intercept)
      fail_input(h.path, ": its values are ", h.slope, " x stored + ", h.intercept, ", those of ", path, " ",
                 first.slope, " x stored + ", first.intercept,
                 ": convert the files to one scaling, such as to floats without any");
    std::vector<Segment> own = metaimage_segments(h, layout_bytes(layout, h.path));
    check_segments(own, layout, options.frames);
    segments.insert(segments.end(), own.begin(), own.end());
    d.files.push_back({h.path, file_size(h.path)});
    for (const std::string& data : h.data_files)
      if (data != h.path) d.files.push_back({data, file_size(data)});
  };
  add_file(first, 0);
  set_affine(d, first, roles, options);
  const std::array samples{layout.size_of(AxisRole::x), layout.size_of(AxisRole::y),
                           layout.size_of(AxisRole::z)};
  std::vector<FileTime> times{{timestamp(first, 0), "s"}};
  for (size_t i = 1; i < sequence.files.size(); ++i) {
    const MetaImageHeader next = read_metaimage_header(sequence.files[i].path);
    add_file(next, i);
    SeriesDescription place;
    set_affine(place, next, roles, options);
    require_same_place(d, place, samples, options, next.path);
    times.push_back({timestamp(next, 0), "s"});
  }

  d.format = "MetaImage";
  d.axes = layout_text(layout);
  if (file_per_frame) {
    frames = sequence.files.size();
    stack_files(layout, sequence);
    d.notes.push_back(sequence.note);
    take_file_times(d, times, "Seq_Frame0000_Timestamp");
  } else {
    check_frame_count(frames, path);
    set_times(d, first, roles);
  }
  d.dims = {samples[0], samples[1], samples[2], frames};
  Channel kind;
  layout.describe(kind, d);
  const std::vector<uint64_t> wanted = add_channels(d, options, path, first.channels, kind);
  keep_modality(d, first);
  if (first.encoding != Encoding::raw)
    d.notes.push_back(first.encoding == Encoding::gzip ? "zlib compression" : "values as text");

  FramePlan plan = plan_frames(sequence, frames, options);
  DenseSeries series(std::move(segments), layout, memory_limit(options));
  return planned_series(std::make_unique<DenseReader>(std::move(d), std::move(series), wanted),
                        std::move(plan), options);
}

} // namespace bcc4

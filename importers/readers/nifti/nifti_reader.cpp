// SPDX-License-Identifier: Apache-2.0
// Opens NIfTI files as one dense array behind their headers.
#include "readers/nifti/nifti_reader.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "readers/components.h"
#include "readers/decoders.h"
#include "readers/dense_reader.h"
#include "readers/error.h"
#include "readers/file_times.h"
#include "readers/frame_plan.h"
#include "readers/nifti/nifti_header.h"
#include "readers/nifti/nifti_place.h"
#include "readers/nifti/nifti_values.h"
#include "readers/records.h"
#include "readers/same_place.h"
#include "readers/system.h"
#include "readers/text.h"

namespace bcc4 {
namespace {

void set_times(SeriesDescription& d, const NiftiHeader& h, uint64_t frames, const std::string& path,
               const ReaderOptions& o) {
  const int unit = h.units() & 0x38;
  if (frames > 1 && (unit == 32 || unit == 40 || unit == 48) && !o.dt && !o.times)
    fail_input(path, ": its fourth axis is in ",
               unit == 32   ? "hertz"
               : unit == 40 ? "ppm"
                            : "radians",
               ", not time; give --dt to read it as time");
  const char* const name = unit == 8 ? "s" : unit == 16 ? "ms" : unit == 24 ? "us" : "";
  const double step = h.decimal(h.fields().pixdim, 4), first = h.decimal(h.fields().toffset);
  if (frames < 2 || !(step > 0) || !std::isfinite(step) || !std::isfinite(first)) {
    if (frames > 1) d.notes.push_back(concat("pixdim[4] is ", step, ": no time step in the header"));
    if (frames > 1 && (o.dt || o.times)) d.times.unit = name; // frames that are counted have none
    return;
  }
  d.times.unit = name;
  for (uint64_t i = 0; i < frames; ++i) d.times.values.push_back(first + static_cast<double>(i) * step);
  d.times.origin =
      concat("pixdim[4] = ", step, d.times.unit.empty() ? " (unit not stated)" : " ", d.times.unit);
}

// The file that holds the values of a header of its own: a.img of a.hdr.
std::string image_of(const std::string& header) {
  const bool packed = lower(header).ends_with(".gz");
  const std::string name = packed ? header.substr(0, header.size() - 3) : header;
  if (!lower(name).ends_with(".hdr"))
    fail_input(header, ": header and image are two files, but its name does not end in .hdr: rename it");
  const std::string image = concat(name.substr(0, name.size() - 3), name.ends_with('R') ? "IMG" : "img");
  for (const std::string& path : {image + (packed ? ".gz" : ""), image + ".gz", image})
    if (std::filesystem::exists(to_path(path))) return path;
  fail_input(header, ": header and image are two files, and ", image,
             " is missing: put it beside the header");
}

constexpr size_t kValueAxis = 4; // dim[5]

// Returns the axes in the order of the file: the parts of a voxel are its fastest, values of dim[5] its
// slowest.
DenseLayout layout_of(const NiftiHeader& h, const NiftiValues& values, const std::string& path) {
  static constexpr AxisRole roles[] = {AxisRole::x, AxisRole::y, AxisRole::z, AxisRole::t};
  const int64_t axes = h.dim(0);
  if (axes < 1 || axes > 7) fail_input(path, ": dim[0] is ", axes, ", not 1 to 7");
  DenseLayout layout;
  layout.type = values.type;
  layout.swap = h.swapped();
  for (size_t a = 0; a < 7; ++a) {
    const int64_t n = a < static_cast<size_t>(axes) ? h.dim(a + 1) : 1;
    if (n < 1) fail_input(path, ": dim[", a + 1, "] is ", n);
    if (n > 1 && (a > kValueAxis || (a == kValueAxis && values.parts > 1)))
      fail_input(path, ": ", n, " values per voxel (dim[", a + 1, "]) ",
                 a > kValueAxis ? "beside those of dim[5]" : "of several parts each",
                 ": write each to a file of its own");
    if (a < kValueAxis) layout.axes.push_back({roles[a], static_cast<uint64_t>(n)});
    if (a == kValueAxis && n > 1) layout.axes.push_back({AxisRole::component, static_cast<uint64_t>(n)});
  }
  if (values.parts > 1) layout.axes.insert(layout.axes.begin(), {AxisRole::component, values.parts});
  if (values.colour()) return layout; // slopes are not for colours
  const double slope = h.real(h.fields().slope), inter = h.real(h.fields().inter);
  if (slope != 0 && std::isfinite(slope) && std::isfinite(inter)) {
    layout.slope = slope;
    layout.intercept = inter;
  }
  return layout;
}

struct OneNifti {
  NiftiHeader header;
  NiftiValues values;
  DenseLayout layout;
  Segment segment;
};

OneNifti open_header(const std::string& path, const ReaderOptions& options) {
  const FileStart start = read_start(path, kNifti2.header);
  OneNifti n{parse_nifti_header(start.bytes, path), {}, {}, {}};
  n.values = nifti_values(n.header, path);
  n.layout = layout_of(n.header, n.values, path);
  const bool pair = n.header.at<char>(n.header.fields().wide ? 5 : 345) == 'i';
  n.segment.path = pair ? image_of(path) : path;
  n.segment.bytes = layout_bytes(n.layout, path);
  const double offset = n.header.vox_offset();
  const double least = pair ? 0 : static_cast<double>(n.header.fields().header);
  if (!(offset >= least) || offset > 1e15)
    fail_input(path, ": vox_offset ", offset, pair ? " is below 0" : " is not behind the header");
  const bool gzip = pair ? read_start(n.segment.path, 2).gzip : start.gzip;
  n.segment.encoding = gzip ? Encoding::gzip : Encoding::raw;
  (gzip ? n.segment.discard : n.segment.offset) = static_cast<uint64_t>(offset);
  std::vector<Segment> segments{n.segment};
  check_segments(segments, n.layout, options.frames);
  n.segment = segments[0];
  return n;
}

std::array<uint64_t, 3> samples_of(const DenseLayout& layout) {
  return {layout.size_of(AxisRole::x), layout.size_of(AxisRole::y), layout.size_of(AxisRole::z)};
}

// Throws for a file that does not go on with the series of the first one.
void require_like(const SeriesDescription& d, const DenseLayout& first, const OneNifti& next,
                  const ReaderOptions& options, const Sequence& sequence, size_t file) {
  const std::string &of_first = d.files.front().path, &path = sequence.files[file].path;
  const DenseLayout& l = next.layout;
  if (l.type != first.type || l.swap != first.swap || samples_of(l) != samples_of(first) ||
      l.size_of(AxisRole::component) != first.size_of(AxisRole::component) || l.size_of(AxisRole::t) != 1)
    refuse_unlike(sequence, file, "sizes or type");
  if (l.slope != first.slope || l.intercept != first.intercept)
    fail_input(path, ": its values are ", l.slope, " x stored + ", l.intercept, ", those of ", of_first, " ",
               first.slope, " x stored + ", first.intercept,
               ": convert the files to one scaling, such as to floats without any");
  SeriesDescription place;
  set_affine(place, next.header, path, options);
  require_same_place(d, place, samples_of(first), options, path);
}

// The name of the values, their unit (as bcc4 writes it), the text beside them and whether they are labels or
// statistics, where the file tells it.
void describe_values(SeriesDescription& d, Channel& channel, const NiftiHeader& h) {
  constexpr int first_statistic = 2, last_statistic = 24; // NIFTI_FIRST_STATCODE, NIFTI_LAST_STATCODE
  constexpr int estimate = 1001, labels = 1002;           // NIFTI_INTENT_ESTIMATE, NIFTI_INTENT_LABEL
  const int intent = h.code(h.fields().intent);
  if (intent == labels) channel.labels = true;
  constexpr size_t name_bytes = 16, text_bytes = 80;
  constexpr std::string_view unit = "bcc4; values in ";
  if (const std::string name = h.text(h.fields().intent_name, name_bytes); !name.empty())
    channel.name = utf8_of(name);
  if ((intent >= first_statistic && intent <= last_statistic) || intent == estimate)
    keep_kind(d, channel.name, DataKind::statistic);
  if (const std::string text = h.text(h.fields().text, text_bytes); text.starts_with(unit))
    channel.unit = utf8_of(text.substr(unit.size()));
  else if (!text.empty() && !text.starts_with("bcc4"))
    keep_channel(d, channel.name, {{"description", utf8_of(text)}});
}

FileTime file_time(const NiftiHeader& h) {
  constexpr int seconds = 8, milliseconds = 16, microseconds = 24, time_bits = 0x38;
  const int unit = h.units() & time_bits;
  return {h.decimal(h.fields().toffset), unit == seconds        ? "s"
                                         : unit == milliseconds ? "ms"
                                         : unit == microseconds ? "us"
                                                                : ""};
}

// Takes the times of files of one frame each. Files that do not tell theirs all have 0 there.
void take_times(SeriesDescription& d, const std::vector<FileTime>& times) {
  const auto told = [](const FileTime& t) { return t.time.value_or(0) != 0; };
  if (std::any_of(times.begin(), times.end(), told)) take_file_times(d, times, "toffset");
}

// Reads the channels that the values of a voxel are, one frame after the other.
std::unique_ptr<FrameReader> open_values(SeriesDescription d, std::vector<Segment> segments,
                                         const OneNifti& first, const DenseLayout& layout,
                                         const ReaderOptions& options, const std::string& path) {
  Channel kind;
  layout.describe(kind, d);
  DenseSeries series(std::move(segments), layout, memory_limit(options));
  if (first.values.complex()) return open_complex(std::move(d), std::move(series), options, path, kind);
  const uint64_t count = layout.size_of(AxisRole::component);
  if (count == 1) describe_values(d, kind, first.header);
  std::vector<uint64_t> wanted = add_channels(d, options, path, count, kind, first.values.names);
  return std::make_unique<DenseReader>(std::move(d), std::move(series), std::move(wanted));
}

} // namespace

std::unique_ptr<FrameReader> open_nifti(const Sequence& sequence, const ReaderOptions& options) {
  const std::string& path = sequence.files.front().path;
  refuse_raw_options(options, path, "NIfTI", false);
  refuse_grid_option(options, path, "NIfTI");
  const bool file_per_frame = sequence.files.size() > 1;

  SeriesDescription d;
  std::vector<Segment> segments;
  const OneNifti first = open_header(path, options);
  DenseLayout layout = first.layout;
  uint64_t frames = layout.size_of(AxisRole::t);
  const auto add_file = [&](const std::string& name, const OneNifti& file) {
    segments.push_back(file.segment);
    d.files.push_back({name, file_size(name)});
    const std::string& image = file.segment.path;
    if (image != name) d.files.push_back({image, file_size(image)});
  };
  add_file(path, first);
  if (file_per_frame && frames > 1) fail_usage(path, " is a series of its own: give it alone");
  set_affine(d, first.header, path, options);
  check_frame_count(frames, path);
  if (!file_per_frame) set_times(d, first.header, frames, path, options);
  std::vector<FileTime> times{file_time(first.header)};
  for (size_t i = 1; i < sequence.files.size(); ++i) {
    const std::string& name = sequence.files[i].path;
    const OneNifti next = open_header(name, options);
    times.push_back(file_time(next.header));
    require_like(d, layout, next, options, sequence, i);
    add_file(name, next);
  }
  if (file_per_frame) {
    frames = sequence.files.size();
    stack_files(layout, sequence);
    d.notes.push_back(sequence.note);
  }
  d.format = "NIfTI";
  const auto samples = samples_of(layout);
  d.dims = {samples[0], samples[1], samples[2], frames};
  d.axes = layout_text(layout);
  if (times.size() == frames && d.times.values.empty()) take_times(d, times);
  FramePlan plan = plan_frames(sequence, frames, options);
  return planned_series(open_values(std::move(d), std::move(segments), first, layout, options, path),
                        std::move(plan), options);
}

} // namespace bcc4

// SPDX-License-Identifier: Apache-2.0
// Opens NRRD files as one dense array: tells the sort of each axis by its kind, label and direction, never by
// its place, and takes affine and times from the header.
#include "readers/nrrd/nrrd_reader.h"

#include <algorithm>
#include <cmath>

#include "readers/calendar.h"
#include "readers/components.h"
#include "readers/dense_reader.h"
#include "readers/error.h"
#include "readers/file_times.h"
#include "readers/frame_plan.h"
#include "readers/nrrd/nrrd_header.h"
#include "readers/nrrd/nrrd_place.h"
#include "readers/records.h"
#include "readers/same_place.h"
#include "readers/text.h"

namespace bcc4 {
namespace {

bool says_time(const std::string& label) {
  const std::string l = lower(label);
  return l == "t" || l == "time" || l == "frame" || l == "frames";
}

bool holds_components(const std::string& kind) {
  return kind.find("vector") != std::string::npos || kind.find("color") != std::string::npos ||
         kind.find("matrix") != std::string::npos || kind.find("gradient") != std::string::npos ||
         kind.find("normal") != std::string::npos || kind == "complex" || kind == "quaternion" ||
         kind == "point" || kind == "scalar" || kind == "stub";
}

// Returns whether an axis runs along time only, in a space that has time as its fourth dimension.
bool points_in_time(const NrrdAxis& axis) {
  const auto& d = axis.direction;
  return d && d->size() == 4 && (*d)[0] == 0 && (*d)[1] == 0 && (*d)[2] == 0 && (*d)[3] != 0;
}

enum class Sort { space, time, list, component, unknown };

Sort sort_of(const NrrdHeader& h, const NrrdAxis& axis) {
  if (axis.kind == "time" || points_in_time(axis)) return Sort::time;
  if (axis.kind == "list") return Sort::list;
  if (holds_components(axis.kind)) return Sort::component;
  if (axis.kind == "space") return Sort::space; // whatever its label
  if (says_time(axis.label)) return Sort::time;
  if (axis.direction) return Sort::space;
  if (h.has_directions) return Sort::unknown; // direction "none"
  return axis.kind == "domain" || axis.kind.empty() ? Sort::space : Sort::unknown;
}

// Says why an axis was taken for time.
std::string reason_of_time(const NrrdAxis& axis) {
  if (axis.kind == "time" || axis.kind == "list") return concat("kind, ", axis.kind);
  return points_in_time(axis) ? "direction" : "label";
}

[[noreturn]] void refuse_axes(const NrrdHeader& h, std::string_view why) {
  std::string suggestion = h.axes.size() > 4 ? "cxyzt" : "xyzt";
  suggestion.resize(std::clamp<size_t>(h.axes.size(), 3, suggestion.size()));
  fail_input(h.path, ": ", why, "; name them, fastest first, such as --axes ", suggestion);
}

struct Roles {
  std::vector<AxisRole> roles;
  std::string why; // how the time axis was found
};

Roles find_roles(const NrrdHeader& h) {
  std::vector<Sort> sorts;
  for (const NrrdAxis& axis : h.axes) sorts.push_back(sort_of(h, axis));
  const auto count = [&](Sort s) { return std::count(sorts.begin(), sorts.end(), s); };
  Roles out;
  Sort time = Sort::time;
  if (count(Sort::time) == 0 && count(Sort::list) == 1) {
    if (const auto m = h.keys.find("modality"); m != h.keys.end() && lower(trim(m->second)) == "dwmri")
      refuse_axes(h, "its list axis holds diffusion gradients, not times");
    time = Sort::list;
  }
  // Beside an axis of time, one of kind list counts values.
  if (time == Sort::time && count(Sort::time) == 1)
    std::replace(sorts.begin(), sorts.end(), Sort::list, Sort::component);
  if (count(time) > 1 || (time == Sort::time && count(Sort::list) > 0))
    refuse_axes(h, "several axes could be time");
  if (count(Sort::unknown) > 0) refuse_axes(h, "an axis is neither in space nor of kind time or list");
  if (count(Sort::component) > 1) refuse_axes(h, "several axes hold components");
  if (count(Sort::space) > 3)
    refuse_axes(h, concat(count(Sort::space), " axes and no word which one is time (kinds, labels)"));
  size_t next = 0;
  for (size_t a = 0; a < sorts.size(); ++a) {
    if (sorts[a] == time) {
      out.roles.push_back(AxisRole::t);
      out.why = concat("axis ", a, " is time by its ", reason_of_time(h.axes[a]));
    } else if (sorts[a] == Sort::component) {
      out.roles.push_back(AxisRole::component);
    } else {
      out.roles.push_back(static_cast<AxisRole>(next++));
    }
  }
  return out;
}

std::string key_of(const NrrdHeader& h, const std::string& name) {
  const auto found = h.keys.find(name);
  return found == h.keys.end() ? std::string() : std::string(trim(found->second));
}

// Volumes of 3D Slicer tell of each frame the value of a tag of DICOM, such as the time of its trigger.
void take_frame_labels(SeriesDescription& d, const NrrdHeader& h, uint64_t frames) {
  const std::string labels = key_of(h, "MultiVolume.FrameLabels");
  const auto numbers = parse_numbers(split(labels, ", \t"));
  if (labels.empty() || !numbers || numbers->size() != frames) return;
  const std::string tag = key_of(h, "MultiVolume.FrameIdentifyingDICOMTagName"),
                    unit = key_of(h, "MultiVolume.FrameIdentifyingDICOMTagUnits");
  const std::string name = lower(tag);
  const bool of_the_pulse = name == "echotime" || name == "repetitiontime" || name == "inversiontime";
  if (of_the_pulse || !(name.ends_with("time") || (name.empty() && seconds_in(unit)))) {
    d.notes.push_back(concat("MultiVolume.FrameLabels are of ", tag.empty() ? "no tag that is told" : tag,
                             ", and not taken for times"));
    return;
  }
  std::vector<FileTime> times;
  for (const double time : *numbers) times.push_back({time, unit});
  take_file_times(d, times, "MultiVolume.FrameLabels");
  if (!d.times.values.empty()) d.times.origin = "MultiVolume.FrameLabels of the header";
}

void set_times(SeriesDescription& d, const NrrdHeader& h, size_t axis_number) {
  const NrrdAxis& axis = h.axes[axis_number];
  d.times.unit = axis.unit;
  const std::string key = concat("axis ", axis_number, " index ");
  if (const std::string unit = key_of(h, key + "unit"); !unit.empty()) d.times.unit = unit;
  const auto values = h.keys.find(key + "values");
  const auto kind = h.keys.find(key + "type");
  if (values != h.keys.end() && (kind == h.keys.end() || lower(trim(kind->second)) == "numeric")) {
    const auto numbers = parse_numbers(split(values->second, " \t,;"));
    if (!numbers || numbers->size() != axis.size)
      fail_input(h.path, ": \"", key, "values\" should give ", axis.size, " numbers: use --dt or --times");
    d.times.values = *numbers;
    d.times.origin = concat("\"", key, "values\" of the header");
    return;
  }
  take_frame_labels(d, h, axis.size);
  if (!d.times.values.empty()) return;
  const AxisPlace place = axis_place(axis, false); // moments are nodes unless the file says otherwise
  const double step = points_in_time(axis) ? (*axis.direction)[3] : place.step.value_or(0);
  if (!(step > 0)) return;
  const double first = place.first.value_or(h.origin && h.origin->size() == 4 ? (*h.origin)[3] : 0);
  for (uint64_t i = 0; i < axis.size; ++i) d.times.values.push_back(first + static_cast<double>(i) * step);
  d.times.origin = concat("spacing ", step, " of axis ", axis_number);
}

// The time of a file that holds one frame, which is no field of the format: what bcc4 writes.
FileTime file_time(const NrrdHeader& h) {
  return {parse_number<double>(key_of(h, "time")), key_of(h, "time unit")};
}

// The date of time 0 and its calendar, which are no fields of the format: what bcc4 writes.
void keep_dates(SeriesDescription& d, const NrrdHeader& h) {
  constexpr std::pair<const char*, const char*> kept[] = {{"time epoch", "time_epoch"},
                                                          {"time calendar", "time_calendar"}};
  for (const auto& [key, attribute] : kept)
    if (const std::string text = key_of(h, key); !text.empty())
      d.attributes.emplace_back(attribute, utf8_of(text));
}

// What the header says of its axes: the keys that bcc4 writes, else labels and, where they differ, units. The
// axis of time of a file of one frame is the fourth.
void keep_axes(SeriesDescription& d, const NrrdHeader& h, const std::vector<AxisRole>& roles) {
  for (size_t a = 0; a < std::max<size_t>(roles.size(), 4); ++a) {
    const AxisRole role = a < roles.size() ? roles[a] : AxisRole::t;
    if (role == AxisRole::component || (a >= roles.size() && a != 3)) continue;
    Record said = read_record(key_of(h, concat("axis ", a, " attributes")));
    std::string name = text_in(said, "name");
    said.erase("name");
    const auto r = static_cast<size_t>(role);
    if (a < roles.size() && name.empty() && h.axes[a].label != std::string(1, "xyzt"[r]))
      name = h.axes[a].label;
    if (role != AxisRole::t && d.spatial_unit.empty() && said.empty() && !d.places[r].unit.empty())
      said["units"] = utf8_of(d.places[r].unit);
    keep_axis(d, r, name, std::move(said));
  }
}

struct OneNrrd {
  NrrdHeader header{};
  Roles roles{};
  DenseLayout layout{};
};

OneNrrd open_header(const ReaderOptions& options, const std::string& path) {
  OneNrrd n{.header = read_nrrd_header(path)};
  n.roles = options.axes
                ? Roles{roles_from_letters(*options.axes, n.header.axes.size(), path, true), "axes by --axes"}
                : find_roles(n.header);
  n.layout.type = n.header.type;
  n.layout.swap = n.header.encoding != Encoding::ascii && needs_swap(n.header.big_endian);
  for (size_t a = 0; a < n.roles.roles.size(); ++a)
    n.layout.axes.push_back({n.roles.roles[a], n.header.axes[a].size});
  return n;
}

// The name of the channel that one value per sample makes: what the header says the file holds, where that is
// a name and not a description or a protocol of how it was made.
void set_name(Channel& channel, const std::string& content) {
  constexpr size_t longest = 64;
  if (!content.empty() && content.size() <= longest) channel.name = utf8_of(content);
}

std::vector<uint64_t> sizes(const DenseLayout& layout) {
  std::vector<uint64_t> s;
  for (const FileAxis& axis : layout.axes) s.push_back(axis.size);
  return s;
}

} // namespace

std::unique_ptr<FrameReader> open_nrrd(const Sequence& sequence, const ReaderOptions& options) {
  const std::string& path = sequence.files.front().path;
  refuse_raw_options(options, path, "NRRD", true);
  refuse_grid_option(options, path, "NRRD");
  const OneNrrd first = open_header(options, path);
  const NrrdHeader& h = first.header;
  DenseLayout layout = first.layout;
  uint64_t frames = layout.size_of(AxisRole::t);
  const bool file_per_frame = sequence.files.size() > 1;

  SeriesDescription d;
  std::vector<Segment> segments;
  const auto add_file = [&](const OneNrrd& file, size_t number) {
    const std::string& name = file.header.path;
    if (file_per_frame && frames > 1) fail_usage(name, " is a series of its own: give it alone");
    if (file.header.type != h.type || file.layout.swap != layout.swap || sizes(file.layout) != sizes(layout))
      refuse_unlike(sequence, number, "sizes or type");
    std::vector<Segment> own = nrrd_segments(file.header, layout_bytes(file.layout, name));
    check_segments(own, file.layout, options.frames);
    segments.insert(segments.end(), own.begin(), own.end());
    d.files.push_back({name, file_size(name)});
    for (const std::string& data : file.header.data_files) d.files.push_back({data, file_size(data)});
  };
  add_file(first, 0);
  set_affine(d, h, first.roles.roles, options);
  std::vector<FileTime> times{file_time(h)};
  const std::array samples{layout.size_of(AxisRole::x), layout.size_of(AxisRole::y),
                           layout.size_of(AxisRole::z)};
  bool one_unit = true;
  bool one_content = true; // else it is not of the series but of its frames
  for (size_t i = 1; i < sequence.files.size(); ++i) {
    const OneNrrd next = open_header(options, sequence.files[i].path);
    add_file(next, i);
    SeriesDescription place;
    set_affine(place, next.header, next.roles.roles, options);
    require_same_place(d, place, samples, options, next.header.path);
    times.push_back(file_time(next.header));
    one_content = one_content && next.header.content == h.content;
    if (next.header.sample_unit != h.sample_unit && one_unit)
      d.warnings.push_back(concat(sequence.files[i].path, ": its values are in \"", next.header.sample_unit,
                                  "\", those of the first file in \"", h.sample_unit, "\""));
    one_unit = one_unit && next.header.sample_unit == h.sample_unit;
  }

  d.format = "NRRD";
  keep_dates(d, h);
  keep_axes(d, h, first.roles.roles);
  d.axes = layout_text(layout) + (first.roles.why.empty() ? "" : "; " + first.roles.why);
  if (file_per_frame) {
    frames = sequence.files.size();
    stack_files(layout, sequence);
    d.notes.push_back(sequence.note);
  } else {
    check_frame_count(frames, path);
    for (size_t a = 0; a < first.roles.roles.size(); ++a)
      if (first.roles.roles[a] == AxisRole::t) set_times(d, h, a);
  }
  if (times.size() == frames && d.times.values.empty()) take_file_times(d, times, "time");
  d.dims = {samples[0], samples[1], samples[2], frames};
  const uint64_t components = layout.size_of(AxisRole::component);
  const std::vector<uint64_t> wanted =
      add_channels(d, options, path, components, {.unit = utf8_of(h.sample_unit), .precision = layout.type});
  if (components == 1 && one_content) set_name(d.channels[0], h.content);
  keep_channel(d, d.channels[0].name, read_record(key_of(h, "sample attributes")));
  if (lower(path).ends_with(".seg.nrrd")) // 3D Slicer's
    for (Channel& channel : d.channels) channel.labels = true;
  if (h.encoding != Encoding::raw)
    d.notes.push_back(h.encoding == Encoding::gzip ? "gzip encoding" : "ascii encoding");

  FramePlan plan = plan_frames(sequence, frames, options);
  DenseSeries series(std::move(segments), layout, memory_limit(options));
  return planned_series(std::make_unique<DenseReader>(std::move(d), std::move(series), wanted),
                        std::move(plan), options);
}

} // namespace bcc4

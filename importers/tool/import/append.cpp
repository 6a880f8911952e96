// SPDX-License-Identifier: Apache-2.0
// What an appended series must have in common with its file, and what it takes from it.
#include "tool/import/append.h"
#include "readers/system.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <numeric>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "readers/affine.h"
#include "readers/calendar.h"
#include "readers/same_place.h"
#include "tool/import/write_series.h"

namespace bcc4 {

namespace {

// Warns of frames whose files are not those of the series, where each frame has a file of its own.
void warn_of_other_files(const std::string& path, const AppendedFile& old, const SeriesDescription& series) {
  if (old.sources.size() != old.frames || series.files.size() != series.dims[3]) return;
  for (size_t f = 0; f < old.frames; ++f) {
    const std::string name = to_text(to_path(series.files[f].path).filename());
    if (name == old.sources[f].name && series.files[f].bytes == old.sources[f].bytes) continue;
    std::fprintf(
        stderr,
        "bcc4: warning: %s: frame %zu was made of %s, %llu bytes, and is %s, %llu bytes, now: frames that "
        "the file has stay as they are\n",
        path.c_str(), f, old.sources[f].name.c_str(), static_cast<unsigned long long>(old.sources[f].bytes),
        name.c_str(), static_cast<unsigned long long>(series.files[f].bytes));
    return;
  }
}

// Reads a series of which some is told otherwise.
class ContinuedReader : public FrameReader {
 public:
  ContinuedReader(std::unique_ptr<FrameReader> source, SeriesDescription description)
      : source_(std::move(source)), description_(std::move(description)) {}
  const SeriesDescription& description() const override { return description_; }
  Frame read(uint64_t frame, size_t channel) override { return source_->read(frame, channel); }
  std::string frame_name(uint64_t frame) const override { return source_->frame_name(frame); }
  bool frames_fit() const override { return source_->frames_fit(); }
  Frame read_box(uint64_t frame, size_t channel, const SampleBox& box) override {
    return source_->read_box(frame, channel, box);
  }

 private:
  std::unique_ptr<FrameReader> source_;
  SeriesDescription description_;
};

void rename_channel(SeriesDescription& d, const std::string& name) {
  const std::string old = std::exchange(d.channels.front().name, name);
  // A grid has the name that the file tells of it.
  std::erase_if(d.attributes, [&](const auto& told) { return told.first == "openvdb.name." + old; });
  for (auto& [key, value] : d.attributes)
    for (const std::string prefix : {"channel.", "kind.", "openvdb.class.", "openvdb.type."})
      if (key == prefix + old) key = prefix + name;
}

Affine affine_of(const bccsplat_volume_info& info) {
  Affine affine;
  std::copy(info.affine, info.affine + affine.size(), affine.begin());
  return affine;
}

// Units that both tell must be the same.
void require_same_unit(const std::string& path, const char* what, const std::string& was,
                       const std::string& now) {
  if (!was.empty() && !now.empty() && was != now)
    fail_usage(path, ": its ", what, " are in ", was, ", those of the input in ", now);
}

// Times go on where both count the same from the same date.
void require_same_clock(const std::string& path, const Clock& was, const SeriesDescription& series) {
  const auto [a, b] = told_by_both(was, clock_of(series));
  const auto change = clock_change(b, a);
  if (!change || change->scale() != 1 || change->offset() != 0)
    fail_usage(path, ": its times are in ", clock_text(a), ", those of the input in ", clock_text(b));
}

} // namespace

std::unique_ptr<FrameReader> continue_series(const Volume& old, const std::string& path,
                                             std::unique_ptr<FrameReader> reader) {
  const bccsplat_volume_info info = volume_info(old);
  SeriesDescription d = reader->description();
  const bool placed = d.affine != SeriesDescription{}.affine || !d.spatial_unit.empty();
  if (!placed) d.affine = affine_of(info), d.spatial_unit = info.spatial_unit;
  const std::string name = channel_info(old, 0).name, given = d.channels.front().name;
  const bool renamed = d.channels.size() == 1 && info.channel_count == 1 && given != name;
  if (renamed) {
    std::fprintf(stderr, "bcc4: channel \"%s\" of the input goes on as \"%s\" of %s\n", given.c_str(),
                 name.c_str(), path.c_str());
    rename_channel(d, name);
  }
  const auto was = seconds_in(info.time_unit), now = seconds_in(d.times.unit);
  const bool reworded = was && was == now && d.times.unit != info.time_unit; // s for seconds
  if (reworded) d.times.unit = info.time_unit;
  if (placed && !renamed && !reworded) return reader;
  return std::make_unique<ContinuedReader>(std::move(reader), std::move(d));
}

namespace {

// What is free text, and names of grids: not what an import says of how its input was read, or else of its
// grids and labels.
std::vector<std::pair<std::string, std::string>> attributes_to_keep(const Volume& old) {
  std::vector<std::pair<std::string, std::string>> kept;
  const char *key = nullptr, *value = nullptr;
  for (uint64_t i = 0; bccsplat_volume_get_attribute(old.get(), i, &key, &value) == BCCSPLAT_OK; ++i) {
    const std::string_view name = key;
    const bool of_grid = name.starts_with("openvdb.") && !name.starts_with("openvdb.name.");
    if (!name.starts_with("import.") && !name.starts_with("labels.") && !of_grid)
      kept.emplace_back(key, value);
  }
  return kept;
}

} // namespace

AppendedFile read_appended(const Volume& old, const std::string& path, const SeriesDescription& series,
                           const std::string& filtering) {
  const bccsplat_volume_info info = volume_info(old);
  const std::string was = told(old, "import.filtering");
  if (was != filtering)
    fail_usage(path, ": its frames were filtered ", was.empty() ? "without --lowpass" : "with --lowpass",
               ", the new ones would be ", filtering.empty() ? "without" : "with");
  if (info.part_end > 0) fail_usage(path, ": a part of a series; join all parts first, by bcc4 concat");
  const auto& n = series.dims;
  if (!std::equal(n.begin(), n.begin() + 3, std::begin(info.dims)))
    fail_usage(path, ": its frames have ", info.dims[0], " x ", info.dims[1], " x ", info.dims[2],
               " samples, those of the input ", n[0], " x ", n[1], " x ", n[2]);
  if (info.dims[3] > n[3])
    fail_usage(
        path, ": it has ", info.dims[3], " frames, the input ", n[3],
        "; --append takes the whole series, the frames that the file has first: give the files of these "
        "and the new ones together");
  require_same_clock(path, clock_of(old), series);
  const double shift = shift_of(affine_of(info), series.affine, {n[0], n[1], n[2]});
  if (!(shift <= same_place))
    fail_usage(path, ": its samples lie up to ", short_number(shift, 3),
               " voxels from where those of the input do; --append needs the --spacing and --origin that the "
               "file was made with");
  require_same_unit(path, "places", info.spatial_unit, series.spatial_unit);
  for (uint32_t c = 0; c < std::min<size_t>(info.channel_count, series.channels.size()); ++c)
    require_same_unit(path, "values", channel_info(old, c).unit, series.channels[c].unit);
  std::vector<double> times(info.dims[3]);
  check(bccsplat_volume_get_times(old.get(), times.data(), times.size(), nullptr), path);
  const std::vector<double>& now = series.times.values;
  const double step = now.size() > 1 ? (now.back() - now.front()) / static_cast<double>(now.size() - 1) : 1;
  for (size_t f = 0; f < times.size(); ++f)
    if (!(std::fabs(times[f] - now[f]) <= 1e-6 * step))
      fail_usage(path, ": its frame ", f, " is at time ", times[f], ", that of the input at ", now[f],
                 "; --append needs the --dt or --times that the file was made with");
  AppendedFile file{info.dims[3], {}, attributes_to_keep(old)};
  PlannedSource source;
  const char* name = nullptr;
  while (bccsplat_volume_get_source(old.get(), file.sources.size(), &name, &source.bytes, &source.crc32) ==
         BCCSPLAT_OK) {
    source.name = name;
    file.sources.push_back(source);
  }
  warn_of_other_files(path, file, series);
  return file;
}

namespace {

// Takes over what channels have, if a file says it of all.
void adopt_kinds(const Volume& old, std::vector<uint32_t>& kinds) {
  std::vector<uint32_t> said;
  for (uint32_t c = 0; c < volume_info(old).channel_count; ++c) {
    const std::string kind = told(old, concat("labels.", channel_info(old, c).name).c_str());
    if (kind.empty()) return;
    said.push_back(kind == "yes" ? BCCSPLAT_CHANNEL_LABELS : BCCSPLAT_CHANNEL_QUANTITIES);
  }
  std::copy_n(said.begin(), std::min(said.size(), kinds.size()), kinds.begin());
}

// The axes across whose faces it has planes.
int32_t faces_in_file(const bccsplat_volume_info& info) {
  int32_t faces = 0;
  for (size_t a = 0; a < 3; ++a)
    if (info.planes_before[a] > 0) faces += BCCSPLAT_FACES_PREDICT_X << a;
  return faces > 0 ? faces : BCCSPLAT_FACES_MIRROR;
}

// The first layer of the lattice that a writer would make of the file's frames: as one part, so that it is
// settled before the first of them. Without layers beyond the ends.
bccsplat_layer_geometry first_layer(const Device& device, const bccsplat_volume_info& info, int32_t faces) {
  SeriesDescription s;
  WriterSettings settings;
  std::copy(std::begin(info.dims), std::end(info.dims), s.dims.begin());
  std::copy(std::begin(info.scales), std::end(info.scales), settings.scales);
  settings.lattice = info.lattice, settings.periodic_axes = info.periodic_axes;
  settings.ends = BCCSPLAT_ENDS_MIRROR, settings.faces = faces;
  std::vector<double> times(s.dims[3]);
  std::iota(times.begin(), times.end(), 0.0);
  auto whole = sized<bccsplat_series_part>();
  whole.end = s.dims[3], whole.times = times.data();
  const Writer writer = create_writer(device, "", s, settings, s.dims[3], s.dims[3] > 1 ? &whole : nullptr);
  auto layer = sized<bccsplat_layer_geometry>();
  check(bccsplat_writer_get_layer_geometry(writer.get(), 0, &layer), "");
  return layer;
}

int32_t ends_in_file(const Device& device, const bccsplat_volume_info& info) {
  const auto inner = first_layer(device, info, BCCSPLAT_FACES_MIRROR).layer_count;
  return info.layer_count > static_cast<uint64_t>(inner) ? BCCSPLAT_ENDS_PREDICT : BCCSPLAT_ENDS_MIRROR;
}

} // namespace

void refuse_other_ends(const Device& device, const Volume& old, const std::string& path,
                       const WriterSettings& settings) {
  const bccsplat_volume_info info = volume_info(old);
  const auto refuse = [&](const char* option) {
    fail_usage(option, ": ", path, " goes on as it was made, and that is different: leave it out");
  };
  if (settings.periodic_axes != 0 && settings.periodic_axes != info.periodic_axes) refuse("--periodic");
  // A periodic series never goes on, as the library says.
  if (settings.ends != BCCSPLAT_ENDS_DEFAULT && settings.ends != BCCSPLAT_ENDS_PERIODIC &&
      settings.ends != ends_in_file(device, info))
    refuse("--ends");
  if (settings.faces == BCCSPLAT_FACES_DEFAULT) return;
  const bccsplat_layer_geometry asked = first_layer(device, info, settings.faces);
  for (size_t a = 0; a < 3; ++a)
    if ((asked.origin[a] < 0) != (info.planes_before[a] > 0)) refuse("--faces");
}

void adopt_lattice(const Device& device, const Volume& old, WriterSettings& settings, PlanWish& wish) {
  const bccsplat_volume_info info = volume_info(old);
  adopt_kinds(old, wish.kinds);
  settings.lattice = info.lattice;
  std::copy(std::begin(info.scales), std::end(info.scales), settings.scales);
  settings.faces = faces_in_file(info);
  settings.periodic_axes = info.periodic_axes;
  if (settings.ends != BCCSPLAT_ENDS_PERIODIC) settings.ends = ends_in_file(device, info);
}

void adopt_error(const Volume& old, WriterSettings& settings) {
  const bccsplat_volume_info info = volume_info(old);
  const bool wavelets = info.store == BCCSPLAT_STORE_WAVELETS;
  if (settings.store != BCCSPLAT_STORE_DEFAULT && settings.store != info.store) return;
  if (wavelets) settings.store = info.store;
  bool bound = wavelets;
  for (uint32_t c = 0; c < info.channel_count; ++c) {
    const bccsplat_channel_info channel = channel_info(old, c);
    if (wavelets) settings.mean_errors.push_back(channel.wavelet_error);
    settings.largest_errors.push_back(channel.error_bound);
    bound = bound || channel.error_bound > 0;
  }
  if (!bound) settings.largest_errors.clear();
}

void adopt_steps(const Volume& old, const SeriesDescription& series, WriterSettings& settings) {
  constexpr double codes = 65000; // at most so many are in use
  const size_t count = std::min<size_t>(series.channels.size(), volume_info(old).channel_count);
  for (size_t c = 0; c < count; ++c) {
    const bccsplat_channel_info channel = channel_info(old, static_cast<uint32_t>(c));
    const Channel& source = series.channels[c];
    const double step = channel.value_scale;
    const double own = source.scaled() ? std::fabs(source.step) : is_float(source.precision) ? 0 : 1;
    if (channel.value_type != BCCSPLAT_TYPE_U16 || step == own) continue;
    // A quarter of a step inwards the first code is the same, rounded or not.
    bccsplat_channel_options& out = settings.values[c];
    out.value_type = BCCSPLAT_TYPE_U16, out.value_step = step;
    out.set_mask |= BCCSPLAT_CHANNEL_SET_RANGE;
    out.range[0] = channel.value_offset + step / 4, out.range[1] = channel.value_offset + codes * step;
  }
}

} // namespace bcc4

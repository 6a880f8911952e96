// SPDX-License-Identifier: Apache-2.0
// Opens .vti files, numbered or named by a .pvd collection, as a series: arrays or their components become
// channels, and sizes, spacing and origin must agree.
#include "readers/vti/vti_reader.h"

#include "readers/error.h"
#include "readers/frame_plan.h"
#include "readers/held_file.h"
#include "readers/vti/vti_collection.h"
#include "readers/vti/vti_file.h"

namespace bcc4 {
namespace {

// A channel: one component of an array.
struct VtiChannel {
  std::string array;
  uint64_t component = 0;
};

const VtiArray& find_array(const VtiFile& file, const std::string& path, const std::string& name) {
  std::vector<std::string> names;
  for (const VtiArray& array : file.arrays()) {
    if (array.name == name) return array;
    names.push_back(array.name);
  }
  fail_usage(path, ": no array \"", name, "\"", did_you_mean(name, names), "; it has ", join(names));
}

class VtiReader : public FrameReader {
 public:
  VtiReader(SeriesDescription description, std::vector<VtiChannel> channels, uint64_t memory_limit,
            std::unique_ptr<VtiFile> first)
      : description_(std::move(description)), channels_(std::move(channels)), memory_limit_(memory_limit),
        file_(std::move(first)), affine_(file_->affine()), coordinates_(file_->coordinates()) {}

  const SeriesDescription& description() const override { return description_; }
  std::string frame_name(uint64_t frame) const override { return description_.files[frame].path; }

  Frame read(uint64_t frame, size_t channel) override {
    const VtiChannel& c = channels_[channel];
    if (!values_ || frame != frame_ || c.array != array_) load(frame, channel);
    const auto& d = description_.dims;
    return dense_frame(
        description_.channels[channel].type, values_,
        {{AxisRole::component, components_}, {AxisRole::x, d[0]}, {AxisRole::y, d[1]}, {AxisRole::z, d[2]}},
        c.component);
  }

 private:
  void load(uint64_t frame, size_t channel) {
    const std::string& path = description_.files[frame].path;
    const std::string& name = channels_[channel].array;
    VtiFile& file = hold_file(file_, path);
    const auto& d = description_.dims;
    if (file.dims() != std::array{d[0], d[1], d[2]})
      fail_input(path, ": ", file.dims()[0], " x ", file.dims()[1], " x ", file.dims()[2],
                 " samples, but the first frame has ", d[0], " x ", d[1], " x ", d[2]);
    if (file.affine() != affine_ || file.coordinates() != coordinates_)
      fail_input(path, ": ", file.rectilinear() ? "Coordinates" : "Origin, Spacing or Direction",
                 " differ from those of the first frame");
    const VtiArray& array = find_array(file, path, name);
    if (array.type != description_.channels[channel].precision)
      fail_input(path, ": array ", name, " is ", type_name(array.type), ", in the first frame ",
                 type_name(description_.channels[channel].precision));
    const uint64_t bytes = d[0] * d[1] * d[2] * array.components * type_size(array.type);
    if (bytes > memory_limit_)
      fail_resources(path, ": array ", name, " takes ", byte_text(static_cast<double>(bytes)),
                     ", more than allowed: raise --max-mem");
    Bytes values = file.values(array);
    widen_values(values, array.type);
    values_ = std::make_shared<const Bytes>(std::move(values));
    components_ = array.components;
    frame_ = frame;
    array_ = name;
  }

  SeriesDescription description_;
  std::vector<VtiChannel> channels_;
  uint64_t memory_limit_;
  std::unique_ptr<VtiFile> file_;
  Affine affine_; // of the first file, as its coordinates
  std::array<std::vector<double>, 3> coordinates_;
  std::shared_ptr<const Bytes> values_; // all components of one array of one frame
  uint64_t frame_ = 0;
  std::string array_;
  uint64_t components_ = 1;
};

void choose_channels(const ReaderOptions& options, const VtiFile& file, const std::string& path,
                     SeriesDescription& d, std::vector<VtiChannel>& channels) {
  std::vector<std::string> names = options.channels;
  if (names.empty() && file.arrays().size() == 1) names.push_back(file.arrays()[0].name);
  if (names.empty() && !file.active().empty()) names.push_back(file.active());
  if (names.empty()) {
    std::vector<std::string> all;
    for (const VtiArray& a : file.arrays()) all.push_back(a.name);
    fail_usage(path, ": several arrays: choose with --channel: ", join(all));
  }
  for (const std::string& name : names) {
    const VtiArray& array = find_array(file, path, name);
    for (uint64_t c = 0; c < array.components; ++c) {
      channels.push_back({array.name, c});
      d.channels.push_back({.name = array.components > 1 ? concat(name, ".", c)
                                    : name.empty()       ? "value"
                                                         : name,
                            .unit = array.unit,
                            .type = widened(array.type),
                            .precision = array.type});
    }
    d.notes.push_back(
        concat("array ", name, ": ", file.storage(array), file.cell_data() ? ", at cells" : ""));
  }
}

std::unique_ptr<FrameReader> open_files(const Sequence& sequence, const ReaderOptions& options,
                                        SeriesTimes times) {
  const std::string& path = sequence.files.front().path;
  refuse_raw_options(options, path, "VTK ImageData", false);
  refuse_grid_option(options, path, "VTK ImageData");
  SeriesDescription d;
  for (const SequenceFile& f : sequence.files) d.files.push_back({f.path, file_size(f.path)});
  auto first = std::make_unique<VtiFile>(path);
  d.format = first->rectilinear() ? "VTK RectilinearGrid" : "VTK ImageData";
  d.dims = {first->dims()[0], first->dims()[1], first->dims()[2], sequence.files.size()};
  d.affine = first->affine();
  d.affine_origin = first->rectilinear() ? "Coordinates" : "Origin, Spacing and Direction";
  for (size_t a = 0; a < 3; ++a) d.places[a].coordinates = first->coordinates()[a];
  d.axes = concat("x ", d.dims[0], " (fastest), y ", d.dims[1], ", z ", d.dims[2]);
  if (!sequence.note.empty()) d.notes.push_back(sequence.note);
  std::vector<VtiChannel> channels;
  choose_channels(options, *first, path, d, channels);
  if (!times.values.empty()) {
    d.times = std::move(times);
  } else if (first->time() && !options.dt && !options.times) {
    for (const SequenceFile& f : sequence.files) {
      const auto time = f.path == path ? first->time() : VtiFile(f.path).time();
      if (!time) fail_input(f.path, ": has no TimeValue, others do: give --dt or --times");
      d.times.values.push_back(*time);
    }
    d.times.origin = "TimeValue of the files";
  }
  FramePlan plan = plan_files(sequence, options);
  return planned_series(
      std::make_unique<VtiReader>(std::move(d), std::move(channels), memory_limit(options), std::move(first)),
      std::move(plan), options);
}

std::unique_ptr<FrameReader> open_collection(const std::string& path, const ReaderOptions& options) {
  const Collection collection = read_collection(path, options);
  const FramePlan selected = plan_selection(collection.entries.size(), options.frames, path);
  Sequence sequence;
  SeriesTimes times{.origin = "timesteps of the collection"};
  for (const PlannedFrame& frame : selected.frames) {
    sequence.files.push_back({collection.entries[frame.a].path, frame.number});
    if (collection.timed) times.values.push_back(collection.entries[frame.a].time);
  }
  sequence.note = concat(sequence.files.size(), " files of the collection ", path, collection.note);
  return open_files(sequence, options, std::move(times));
}

} // namespace

std::unique_ptr<FrameReader> open_vti(const Sequence& sequence, const ReaderOptions& options) {
  const std::string& path = sequence.files.front().path;
  if (!lower(path).ends_with(".pvd")) return open_files(sequence, options, {});
  if (sequence.files.size() > 1) fail_usage(path, ": a collection stands alone, without other inputs");
  return open_collection(path, options);
}

} // namespace bcc4

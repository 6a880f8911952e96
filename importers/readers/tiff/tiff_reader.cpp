// SPDX-License-Identifier: Apache-2.0
// Frames of TIFF files: of one file what its words say, of several a file for each moment, or for each plane.
#include "readers/tiff/tiff_reader.h"

#include <algorithm>

#include "readers/affine.h"
#include "readers/byte_stream.h"
#include "readers/components.h"
#include "readers/error.h"
#include "readers/frame_plan.h"
#include "readers/held_file.h"
#include "readers/stored_values.h"
#include "readers/tiff/tiff_stack.h"

namespace bcc4 {
namespace {

constexpr uint16_t kMinIsWhite = 0, kRgb = 2, kPalette = 3; // values of the tag "photometric"

// What files one after the other are.
enum class FilesAre : uint8_t { one_file, planes, moments };

// A place in the series, as the channels, planes and moments are counted.
struct PagePlace {
  size_t file = 0;
  uint64_t page = 0;
};

struct TiffLayout {
  std::vector<std::string> paths;
  TiffStack stack; // of each file
  FilesAre files = FilesAre::one_file;

  [[nodiscard]] uint64_t planes() const { return files == FilesAre::planes ? paths.size() : stack.z; }
  [[nodiscard]] uint64_t moments() const { return files == FilesAre::moments ? paths.size() : stack.t; }
  [[nodiscard]] PagePlace place(uint64_t channel, uint64_t plane, uint64_t moment) const {
    if (files == FilesAre::planes) return {plane, stack.page(channel, 0, 0)};
    if (files == FilesAre::moments) return {moment, stack.page(channel, plane, 0)};
    return {0, stack.page(channel, plane, moment)};
  }
};

class TiffReader : public FrameReader {
 public:
  TiffReader(SeriesDescription description, TiffLayout layout, std::vector<uint64_t> components,
             std::unique_ptr<TiffFile> first)
      : description_(std::move(description)), layout_(std::move(layout)), components_(std::move(components)),
        kind_(first->kind()), file_(std::move(first)) {}
  const SeriesDescription& description() const override { return description_; }
  std::string frame_name(uint64_t frame) const override {
    return layout_.paths[layout_.place(0, 0, frame).file];
  }

  Frame read(uint64_t frame, size_t channel) override {
    const uint64_t component = components_[channel], sample = component % kind_.samples;
    auto bytes = std::make_shared<Bytes>();
    bytes->reserve(kind_.page_bytes() / kind_.samples * layout_.planes());
    Bytes page(kind_.page_bytes());
    for (uint64_t z = 0; z < layout_.planes(); ++z) {
      const PagePlace place = layout_.place(component / kind_.samples, z, frame);
      hold_file(file_, layout_.paths[place.file]).read(place.page, page);
      append(*bytes, page, sample);
    }
    StoredValues values;
    values.type = kind_.type;
    values.convert(*bytes);
    const auto& dims = description_.dims;
    return dense_frame(values.value_type(), std::move(bytes),
                       {{AxisRole::x, dims[0]}, {AxisRole::y, dims[1]}, {AxisRole::z, dims[2]}});
  }

 private:
  // Appends one sample of each pixel.
  void append(Bytes& bytes, const Bytes& page, uint64_t sample) const {
    const size_t size = type_size(kind_.type), step = size * kind_.samples;
    if (step == size) {
      bytes.insert(bytes.end(), page.begin(), page.end());
      return;
    }
    for (size_t at = sample * size; at < page.size(); at += step)
      bytes.insert(bytes.end(), page.begin() + static_cast<std::ptrdiff_t>(at),
                   page.begin() + static_cast<std::ptrdiff_t>(at + size));
  }

  SeriesDescription description_;
  TiffLayout layout_;
  std::vector<uint64_t> components_; // sample + samples x channel of pages
  TiffKind kind_;
  std::unique_ptr<TiffFile> file_; // the one read last
};

// What --axes says of files: xyz, xyt or xyzt; of one file all letters of its pages.
void check_axes(const ReaderOptions& options, bool alone) {
  const std::string axes = options.axes.value_or("xyz"),
                    pages = axes.substr(std::min<size_t>(2, axes.size()));
  bool known =
      axes.starts_with("xy") && !pages.empty() && (alone || pages == "z" || pages == "t" || pages == "zt");
  for (const char a : pages)
    known = known && std::string_view("zct").find(a) != std::string_view::npos &&
            std::count(pages.begin(), pages.end(), a) == 1;
  if (!known)
    fail_usage(
        "--axes ", axes,
        ": of TIFF files xyz (pages, or files of one page, are planes), xyt (they are moments), xyzt (a "
        "file for each moment), or all axes of one file that tells their sizes, such as xyzct");
}

// Several files of a page each may be planes or moments.
FilesAre files_are(const Sequence& sequence, const TiffStack& stack, const ReaderOptions& options) {
  const std::string& path = sequence.files.front().path;
  if (sequence.files.size() == 1) return FilesAre::one_file;
  if (stack.t > 1) fail_usage(path, " is a series of its own: give it alone");
  if (stack.z > 1) {
    if (options.axes && *options.axes != "xyzt")
      fail_usage("--axes ", *options.axes, ": the files have ", stack.z,
                 " planes each, so that they are moments: --axes xyzt");
    return FilesAre::moments;
  }
  if (!options.axes)
    fail_usage(path, " and the others have one page each: --axes xyz reads them as the planes of a volume, "
                     "--axes xyt as moments of a picture");
  return *options.axes == "xyz" ? FilesAre::planes : FilesAre::moments;
}

// Pages of a file that says nothing are planes unless --axes makes them moments.
TiffStack stack_of(const TiffFile& file, const ReaderOptions& options, bool alone) {
  TiffStack stack = tiff_stack(file, !options.spacing);
  if (!alone || !options.axes) return stack;
  const std::string letters = options.axes->substr(2);
  if (!stack.said_by.empty() && ((stack.z > 1 && stack.t > 1) || letters == "c"))
    fail_usage("--axes ", *options.axes, ": ", file.path(), " says itself what its pages are (",
               stack.said_by, "): leave it out");
  if (letters.size() > 1 && letters.size() == stack.unnamed.size()) {
    stack.set_axes(letters, stack.unnamed);
    return stack;
  }
  if (letters.size() > 1)
    fail_usage("--axes ", *options.axes, ": the file does not tell the sizes of these axes",
               stack.unnamed.empty() ? "" : concat(", but of ", 2 + stack.unnamed.size()),
               "; save it as a hyperstack (Image > Hyperstacks in ImageJ) or as OME-TIFF");
  const uint64_t pages = stack.z * stack.t;
  if (stack.said_by.empty())
    stack.set_axes(letters, {pages});
  else
    stack.z = letters == "z" ? pages : 1, stack.t = letters == "z" ? 1 : pages;
  return stack;
}

void set_place(SeriesDescription& d, const TiffStack& stack, bool planes_are_files) {
  std::array<std::array<double, 3>, 3> columns{};
  for (size_t a = 0; a < 3; ++a) columns[a][a] = stack.steps[a].value_or(1);
  if (planes_are_files) columns[2][2] = 1; // no file tells of another
  d.affine = affine_from_columns(columns, {0, 0, 0});
  d.affine_origin = stack.steps[0] || stack.steps[2] ? concat("steps of ", stack.said_by)
                                                     : "none given: one unit per pixel";
  d.spatial_unit = stack.unit;
}

void set_times(SeriesDescription& d, const TiffStack& stack) {
  if (stack.t < 2) return;
  if (stack.moments.size() == stack.t) take_file_times(d, stack.moments, "DeltaT");
  if (!d.times.values.empty()) d.times.origin = "DeltaT of OME-XML";
  if (!stack.interval || !d.times.values.empty()) return;
  for (uint64_t i = 0; i < stack.t; ++i) d.times.values.push_back(static_cast<double>(i) * *stack.interval);
  d.times.unit = stack.time_unit;
  d.times.origin = concat("the interval of ", stack.said_by, ", ", *stack.interval);
}

std::vector<std::string> channel_names(const TiffKind& kind, const TiffStack& stack) {
  static const std::vector<std::string> colors{"red", "green", "blue", "alpha"};
  if (stack.c == 1 && kind.photometric == kRgb && kind.samples <= colors.size())
    return {colors.begin(), colors.begin() + kind.samples};
  return kind.samples == 1 ? stack.names : std::vector<std::string>{};
}

std::string axes_text(const TiffLayout& l, const TiffKind& kind) {
  std::string text = concat("x ", kind.width, " (fastest), y ", kind.height);
  for (const char axis : l.stack.order) {
    const uint64_t size = axis == 'c' ? l.stack.c : axis == 'z' ? l.planes() : l.moments();
    if (size > 1) text += concat(", ", axis, " ", size);
  }
  return text;
}

// A page is read through one tile at a time, which a file can make larger than a frame.
void check_memory(const TiffFile& file, uint64_t planes, const ReaderOptions& options) {
  const double frame = static_cast<double>(file.kind().page_bytes()) * static_cast<double>(planes),
               bytes = std::max(frame, static_cast<double>(file.tile_bytes()));
  if (const uint64_t most = memory_limit(options); bytes > static_cast<double>(most))
    fail_resources(file.path(), bytes > frame ? ": one tile takes " : ": one frame takes ", byte_text(bytes),
                   ", more than the ", byte_text(static_cast<double>(most)), " allowed: raise --max-mem");
}

// Opens the other files of a series to see that they are like the first one.
void add_files(SeriesDescription& d, const Sequence& sequence, const TiffLayout& layout,
               const TiffFile& first, const ReaderOptions& options) {
  check_memory(first, layout.planes(), options);
  d.files.push_back({first.path(), file_size(first.path())});
  for (size_t i = 1; i < layout.paths.size(); ++i) {
    const TiffFile next(layout.paths[i]);
    if (!(next.kind() == first.kind()) || next.pages() != first.pages())
      refuse_unlike(sequence, i, "size, type or number of pages");
    check_memory(next, layout.planes(), options);
    d.files.push_back({next.path(), file_size(next.path())});
  }
}

void add_notes(SeriesDescription& d, const Sequence& sequence, const TiffLayout& l, const TiffKind& kind,
               const ReaderOptions& options) {
  if (sequence.files.size() > 1) d.notes.push_back(sequence.note);
  if (l.stack.unnamed.size() > 1 && !options.axes) {
    std::string sizes = concat(kind.width, " x ", kind.height);
    for (const uint64_t size : l.stack.unnamed) sizes += concat(" x ", size);
    d.notes.push_back(concat("the file tells the sizes of its axes, ", sizes,
                             ", and not what they are: they ", "are read as ", axes_text(l, kind),
                             " (--axes, such as xyzct, names them)"));
  } else if (l.files == FilesAre::one_file && l.stack.said_by.empty() && l.stack.z > 1)
    d.notes.push_back("the file does not say what its pages are: they are read as planes (--axes xyt: as "
                      "moments)");
  if (kind.photometric == kMinIsWhite)
    d.warnings.push_back("the least value is white in this file: values are as stored, and pictures are "
                         "its negative");
  if (kind.photometric == kPalette)
    d.warnings.push_back("values are numbers of a table of colours, which is not kept");
}

FramePlan plan_of(const Sequence& sequence, const TiffLayout& l, const ReaderOptions& options) {
  if (l.files != FilesAre::planes) return plan_frames(sequence, l.moments(), options);
  if (!sequence.missing.empty())
    fail_input("planes ", range_text(sequence.missing, sequence.stride),
               " are missing: there is no file of "
               "that number");
  return plan_selection(1, {}, l.paths[0]);
}

} // namespace

std::unique_ptr<FrameReader> open_tiff(const Sequence& sequence, const ReaderOptions& options) {
  refuse_raw_options(options, sequence.files.front().path, "TIFF", true);
  refuse_grid_option(options, sequence.files.front().path, "TIFF");
  check_axes(options, sequence.files.size() == 1);
  TiffLayout layout;
  for (const SequenceFile& file : sequence.files) layout.paths.push_back(file.path);
  auto first = std::make_unique<TiffFile>(layout.paths[0]);
  const TiffKind kind = first->kind();
  layout.stack = stack_of(*first, options, layout.paths.size() == 1);
  layout.files = files_are(sequence, layout.stack, options);
  check_frame_count(layout.moments(), layout.paths[0]);

  SeriesDescription d;
  d.format = "TIFF";
  d.dims = {kind.width, kind.height, layout.planes(), layout.moments()};
  d.axes = axes_text(layout, kind);
  add_files(d, sequence, layout, *first, options);
  set_place(d, layout.stack, layout.files == FilesAre::planes);
  set_times(d, layout.stack);
  add_notes(d, sequence, layout, kind, options);
  StoredValues values;
  values.type = kind.type;
  Channel channel;
  values.describe(channel, d);
  channel.type = values.value_type();
  const std::vector<uint64_t> wanted = add_channels(
      d, options, layout.paths[0], layout.stack.c * kind.samples, channel, channel_names(kind, layout.stack));
  FramePlan plan = plan_of(sequence, layout, options);
  return planned_series(
      std::make_unique<TiffReader>(std::move(d), std::move(layout), wanted, std::move(first)),
      std::move(plan), options);
}

} // namespace bcc4

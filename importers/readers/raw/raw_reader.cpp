// SPDX-License-Identifier: Apache-2.0
// Opens raw arrays by what the user says of them, checks that the files have the sizes that follow, and warns
// where one frame looks as if it were declared wrongly (roughness.h).
#include "readers/raw/raw_reader.h"

#include <algorithm>

#include "readers/components.h"
#include "readers/decoders.h"
#include "readers/dense_reader.h"
#include "readers/error.h"
#include "readers/frame_plan.h"
#include "readers/raw/roughness.h"

namespace bcc4 {
namespace {

// Returns whether a file is gzip is told by its name: what begins like gzip under another name may be values.
// The error for such a file of the wrong size says so.
bool is_gzip(const std::string& path) { return lower(path).ends_with(".gz"); }

// Returns text such as "64 x 64 x 64 x 2 bytes (u16)".
std::string arithmetic(const DenseLayout& layout, uint64_t frames) {
  std::string text;
  for (const FileAxis& axis : layout.axes)
    if (axis.role != AxisRole::t) text += concat(axis.size, " x ");
  if (frames > 1) text += concat(frames, " frames x ");
  return concat(text, type_size(layout.type), " bytes (", type_name(layout.type), ")");
}

// Returns what to say where a file holds another number of frames than was told.
std::string frames_hint(const DenseLayout& layout, uint64_t frames) {
  return concat("the file would fit ", frames, frames == 1 ? " frame" : " frames", ": --dims ",
                layout.size_of(AxisRole::x), ",", layout.size_of(AxisRole::y), ",",
                layout.size_of(AxisRole::z), ",", frames);
}

void check_file(const Segment& s, const DenseLayout& layout, uint64_t frames) {
  const uint64_t size = file_size(s.path);
  const uint64_t all = s.offset + s.bytes;
  if (s.encoding != Encoding::raw || (size <= all && size >= all - s.unread)) return;
  const uint64_t frame = layout_bytes(layout, s.path) / layout.size_of(AxisRole::t);
  std::string hint = "check --dims, --dtype and --skip";
  if (read_start(s.path, 2).gzip)
    hint = "it is packed with gzip: name it .gz, or unpack it";
  else if (size > s.offset && (size - s.offset) % frame == 0)
    hint = frames_hint(layout, (size - s.offset) / frame);
  else if (const std::string whole = whole_frames(layout, size - std::min(size, s.offset));
           size < all && !whole.empty())
    hint = whole;
  fail_input(s.path, ": ", size, " bytes, but ", arithmetic(layout, frames),
             s.offset > 0 ? concat(" + ", s.offset, " skipped") : "", " = ", s.offset + s.bytes, "; ", hint);
}

// Returns the axes in file order: those of the letters, and for several arrays one of components, where c is
// among the letters or else before time.
std::vector<FileAxis> raw_axes(std::string letters, const std::array<uint64_t, 4>& dims, uint64_t arrays) {
  const size_t c = letters.find('c');
  if (c != std::string::npos) {
    if (arrays == 1) fail_usage("--axes ", letters, ": c is the axis of --count N arrays");
    letters.erase(c, 1);
  }
  std::vector<FileAxis> axes = axes_from_letters(letters, dims);
  if (arrays == 1) return axes;
  const auto time =
      std::find_if(axes.begin(), axes.end(), [](const auto& a) { return a.role == AxisRole::t; });
  const auto place = c == std::string::npos ? time : axes.begin() + c;
  axes.insert(place, {AxisRole::component, arrays});
  return axes;
}

// Returns what is probably wrong by the look of one frame; of several arrays the first one is looked at,
// where it is in one piece.
std::vector<std::string> suspicions_of(const Frame& frame, DenseLayout layout) {
  if (frame.boxes[0].type != layout.type) return {};
  std::erase_if(layout.axes, [](const FileAxis& a) { return a.role == AxisRole::t; });
  const Bytes& all = *frame.storage[0];
  const uint64_t arrays = layout.size_of(AxisRole::component);
  if (arrays == 1) return find_suspicions(all, layout.type, layout.axes);
  if (layout.axes.back().role != AxisRole::component) return {};
  layout.axes.pop_back();
  const Bytes first(all.begin(), all.begin() + all.size() / arrays);
  return find_suspicions(first, layout.type, layout.axes);
}

} // namespace

std::unique_ptr<FrameReader> open_raw(const Sequence& sequence, const ReaderOptions& options) {
  const std::string& first = sequence.files.front().path;
  refuse_grid_option(options, first, "raw");
  for (const SequenceFile& f : sequence.files)
    (void)file_size(f.path); // a missing file is the first thing to say
  if (!options.dims || !options.dtype)
    fail_usage(first,
               ": begins like none of the known formats (NRRD, OpenVDB, VTK ImageData, NIfTI, MetaImage, "
               "NetCDF, TIFF); to read it as ",
               "raw values give ", options.dims ? "" : "--dims NX,NY,NZ[,NT]",
               options.dims || options.dtype ? "" : " and ",
               options.dtype ? "" : "--dtype u8|i8|u16|i16|u32|i32|f16|f32|f64");

  auto dims = *options.dims;
  const uint64_t files = sequence.files.size();
  const bool file_per_frame = files > 1;
  if (dims[3] == 0) dims[3] = 1;
  if (file_per_frame && dims[3] > 1 && dims[3] != files && !options.frames.given)
    fail_usage("--dims says ", dims[3], " frames, but there are ", files, " files, one per frame");

  DenseLayout layout;
  layout.type = *options.dtype;
  layout.swap = needs_swap(options.big_endian.value_or(false));
  const std::string letters = options.axes.value_or(dims[3] > 1 && !file_per_frame ? "xyzt" : "xyz");
  auto file_dims = dims;
  if (file_per_frame) file_dims[3] = 1;
  const uint64_t arrays = options.count.value_or(1);
  layout.axes = raw_axes(letters, file_dims, arrays);
  if (letters.find('t') == std::string::npos && file_dims[3] > 1)
    fail_usage("--axes ", letters, " has no t, but --dims has ", file_dims[3], " frames");

  const uint64_t bytes = layout_bytes(layout, first), skip = options.skip.value_or(0);
  std::vector<Segment> segments;
  SeriesDescription d;
  for (const SequenceFile& f : sequence.files) {
    Segment s{.path = f.path, .bytes = bytes, .exact = true};
    if (is_gzip(f.path)) {
      s.encoding = Encoding::gzip;
      s.discard = skip;
    } else {
      s.offset = skip;
    }
    std::vector<Segment> own{s};
    leave_unread(own, layout, options.frames);
    check_file(own[0], layout, file_dims[3]);
    segments.push_back(own[0]);
    d.files.push_back({f.path, file_size(f.path)});
  }
  if (file_per_frame) {
    stack_files(layout, sequence);
    dims[3] = files;
  }

  d.format = "raw";
  d.dims = dims;
  d.axes = layout_text(layout) + (options.axes ? " (--axes)" : "");
  d.affine_origin = "raw files have none: one unit per voxel (use --spacing)";
  const std::vector<uint64_t> wanted = add_channels(d, options, first, arrays, {.precision = layout.type});
  if (!sequence.note.empty()) d.notes.push_back(sequence.note);
  d.notes.push_back(concat(type_name(layout.type), ", ",
                           options.big_endian.value_or(false) ? "big" : "little", "-endian",
                           skip > 0 ? concat(", ", skip, " bytes skipped") : ""));
  FramePlan plan = plan_frames(sequence, dims[3], options);
  DenseSeries series(std::move(segments), layout, memory_limit(options));
  // The middle frame is looked at, for the first one of a simulation is often empty; of a packed file it is
  // the first, because unpacking begins at the start.
  const bool packed = is_gzip(first) && !file_per_frame;
  if (series.frame_fits())
    d.warnings = suspicions_of(series.read(plan.frames[packed ? 0 : plan.frames.size() / 2].a, 0), layout);
  return planned_series(std::make_unique<DenseReader>(std::move(d), std::move(series), wanted),
                        std::move(plan), options);
}

} // namespace bcc4

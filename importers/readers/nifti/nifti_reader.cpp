// SPDX-License-Identifier: Apache-2.0
// Reads the fixed fields of a NIfTI-1 or NIfTI-2 header in either byte order and opens the image behind it as
// one dense array.
#include "readers/nifti/nifti_reader.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "readers/affine.h"
#include "readers/decoders.h"
#include "readers/dense_reader.h"
#include "readers/error.h"
#include "readers/frame_plan.h"

namespace bcc4 {
namespace {

// Byte offsets of the fields in the two versions.
struct Fields {
  size_t header, dim, datatype, pixdim, vox_offset, slope, inter, units, toffset, qform, sform, quatern,
      qoffset, srow;
  bool wide; // NIfTI-2: dims are i64, floats f64, codes i32
};
constexpr Fields kNifti1{348, 40, 70, 76, 108, 112, 116, 123, 136, 252, 254, 256, 268, 280, false};
constexpr Fields kNifti2{540, 16, 12, 104, 168, 176, 184, 500, 216, 344, 348, 352, 376, 400, true};

class Header {
 public:
  Header(std::string bytes, const Fields& fields, bool swap)
      : bytes_(std::move(bytes)), f_(fields), swap_(swap) {}
  [[nodiscard]] const Fields& fields() const { return f_; }
  [[nodiscard]] bool swapped() const { return swap_; }
  template<class T> [[nodiscard]] T at(size_t offset) const {
    char raw[sizeof(T)];
    std::copy_n(bytes_.data() + offset, sizeof(T), raw);
    if (swap_) std::reverse(raw, raw + sizeof(T));
    T value;
    std::memcpy(&value, raw, sizeof value);
    return value;
  }
  [[nodiscard]] int64_t dim(size_t i) const {
    return f_.wide ? at<int64_t>(f_.dim + 8 * i) : at<int16_t>(f_.dim + 2 * i);
  }
  [[nodiscard]] double real(size_t offset, size_t i = 0) const {
    return f_.wide ? at<double>(offset + 8 * i) : static_cast<double>(at<float>(offset + 4 * i));
  }
  // Returns a float as the decimal number it was made from: 2.54, not 2.5399999618530273.
  [[nodiscard]] double decimal(size_t offset, size_t i = 0) const {
    if (f_.wide) return real(offset, i);
    return parse_number<double>(concat(at<float>(offset + 4 * i))).value_or(real(offset, i));
  }
  [[nodiscard]] int code(size_t offset) const { return f_.wide ? at<int32_t>(offset) : at<int16_t>(offset); }
  [[nodiscard]] int units() const {
    return f_.wide ? at<int32_t>(f_.units) : static_cast<int>(at<uint8_t>(f_.units));
  }
  [[nodiscard]] double vox_offset() const {
    return f_.wide ? static_cast<double>(at<int64_t>(f_.vox_offset)) : real(f_.vox_offset);
  }

 private:
  std::string bytes_;
  Fields f_;
  bool swap_;
};

uint32_t size_field(std::string_view start, bool swap) {
  char raw[4];
  std::copy_n(start.data(), 4, raw);
  if (swap) std::reverse(raw, raw + 4);
  uint32_t size = 0;
  std::memcpy(&size, raw, 4);
  return size;
}

bool magic_at(std::string_view start, size_t offset, std::string_view magic) {
  return start.size() >= offset + magic.size() && start.substr(offset, magic.size()) == magic;
}

Header parse_header(const std::string& bytes, const std::string& path) {
  if (bytes.size() >= 4) {
    for (const bool swap : {false, true})
      for (const Fields* f : {&kNifti1, &kNifti2})
        if (size_field(bytes, swap) == f->header && bytes.size() >= f->header) return Header(bytes, *f, swap);
  }
  fail_input(path, ": the NIfTI header is cut off");
}

Type type_of(int code, const std::string& path) {
  static constexpr std::pair<int, Type> codes[] = {
      {2, Type::u8},   {4, Type::i16},   {8, Type::i32},   {16, Type::f32},   {64, Type::f64},
      {256, Type::i8}, {512, Type::u16}, {768, Type::u32}, {1024, Type::i64}, {1280, Type::u64}};
  for (const auto& [number, type] : codes)
    if (number == code) return type;
  fail_input(path, ": NIfTI data type ", code, " cannot be read; integers and floats up to 64 bits can");
}

// Takes the sform where there is one, else the qform, else the voxel sizes alone.
void set_affine(SeriesDescription& d, const Header& h, const std::string& path) {
  const Fields& f = h.fields();
  std::array<double, 3> size{};
  for (size_t a = 0; a < 3; ++a) {
    size[a] = std::abs(h.real(f.pixdim, a + 1));
    if (!(size[a] > 0) || !std::isfinite(size[a])) size[a] = 1;
  }
  if (h.code(f.sform) > 0) {
    for (size_t i = 0; i < 12; ++i) d.affine[i] = h.real(f.srow, i);
    d.affine_origin = concat("sform, code ", h.code(f.sform));
  } else if (h.code(f.qform) > 0) {
    const double b = h.real(f.quatern, 0), c = h.real(f.quatern, 1), e = h.real(f.quatern, 2);
    const double a = std::sqrt(std::max(0.0, 1 - (b * b + c * c + e * e)));
    const double flip = h.real(f.pixdim, 0) < 0 ? -1 : 1;
    const double s[3] = {size[0], size[1], size[2] * flip};
    d.affine = affine_from_columns(
        {{{(a * a + b * b - c * c - e * e) * s[0], 2 * (b * c + a * e) * s[0], 2 * (b * e - a * c) * s[0]},
          {2 * (b * c - a * e) * s[1], (a * a + c * c - b * b - e * e) * s[1], 2 * (c * e + a * b) * s[1]},
          {2 * (b * e + a * c) * s[2], 2 * (c * e - a * b) * s[2], (a * a + e * e - c * c - b * b) * s[2]}}},
        {h.real(f.qoffset, 0), h.real(f.qoffset, 1), h.real(f.qoffset, 2)});
    d.affine_origin = concat("qform, code ", h.code(f.qform));
  } else {
    d.affine = affine_from_columns({{{size[0], 0, 0}, {0, size[1], 0}, {0, 0, size[2]}}}, {0, 0, 0});
    d.affine_origin = "pixdim only";
  }
  for (const double v : d.affine)
    if (!std::isfinite(v))
      fail_input(path, ": its affine (", d.affine_origin, ") is not finite: give --spacing");
  if (!(std::abs(determinant(d.affine)) > 0))
    fail_input(path, ": its affine (", d.affine_origin, ") spans no volume: give --spacing");
  static constexpr const char* units[] = {"", "m", "mm", "um"};
  d.spatial_unit = (h.units() & 7) < 4 ? units[h.units() & 7] : "";
  d.attributes.emplace_back("space", "right-anterior-superior");
}

void set_times(SeriesDescription& d, const Header& h, uint64_t frames, const std::string& path,
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

} // namespace

bool is_nifti(std::string_view start) {
  if (start.size() < 348) return false;
  for (const bool swap : {false, true}) {
    const uint32_t size = size_field(start, swap);
    if (size == 348 && (magic_at(start, 344, std::string_view("n+1\0", 4)) ||
                        magic_at(start, 344, std::string_view("ni1\0", 4))))
      return true;
    if (size == 540 && magic_at(start, 4, std::string_view("n+2\0\r\n\032\n", 8))) return true;
  }
  return false;
}

std::unique_ptr<FrameReader> open_nifti(const Sequence& sequence, const ReaderOptions& options) {
  const std::string& path = sequence.files.front().path;
  refuse_raw_options(options, path, "NIfTI", false);
  refuse_grid_option(options, path, "NIfTI");
  refuse_channel_option(options, path, "NIfTI");
  const bool file_per_frame = sequence.files.size() > 1;

  SeriesDescription d;
  DenseLayout layout;
  std::vector<Segment> segments;
  uint64_t frames = 1;
  for (size_t i = 0; i < sequence.files.size(); ++i) {
    const std::string& name = sequence.files[i].path;
    const FileStart start = read_start(name, kNifti2.header);
    const Header h = parse_header(start.bytes, name);
    if (!h.fields().wide && h.at<char>(345) == 'i')
      fail_input(name, ": header and image are two files (.hdr, .img); convert it to one .nii");
    const int64_t axes = h.dim(0);
    if (axes < 1 || axes > 7) fail_input(name, ": dim[0] is ", axes, ", not 1 to 7");
    DenseLayout next;
    next.type = type_of(h.at<int16_t>(h.fields().datatype), name);
    next.swap = h.swapped();
    static constexpr AxisRole roles[] = {AxisRole::x, AxisRole::y, AxisRole::z, AxisRole::t};
    for (size_t a = 0; a < 7; ++a) {
      const int64_t n = a < static_cast<size_t>(axes) ? h.dim(a + 1) : 1;
      if (n < 1) fail_input(name, ": dim[", a + 1, "] is ", n);
      if (a >= 4 && n > 1)
        fail_input(name, ": ", n, " values per voxel (dim[", a + 1, "]); scalars can be read");
      if (a < 4) next.axes.push_back({roles[a], static_cast<uint64_t>(n)});
    }
    const double slope = h.real(h.fields().slope), inter = h.real(h.fields().inter);
    if (slope != 0 && std::isfinite(slope) && std::isfinite(inter)) {
      next.slope = slope;
      next.intercept = inter;
    }
    const double offset = h.vox_offset();
    if (!(offset >= static_cast<double>(h.fields().header)) || offset > 1e15)
      fail_input(name, ": vox_offset ", offset, " is not behind the header");
    Segment s{.path = name, .bytes = layout_bytes(next, name)};
    s.encoding = start.gzip ? Encoding::gzip : Encoding::raw;
    (start.gzip ? s.discard : s.offset) = static_cast<uint64_t>(offset);
    check_segment(s);
    segments.push_back(std::move(s));
    d.files.push_back({name, file_size(name)});
    if (i == 0) {
      layout = next;
      frames = next.size_of(AxisRole::t);
      if (file_per_frame && frames > 1) fail_usage(name, " is a series of its own: give it alone");
      set_affine(d, h, name);
      check_frame_count(frames, name);
      if (!file_per_frame) set_times(d, h, frames, name, options);
    } else if (next.type != layout.type || next.swap != layout.swap ||
               next.size_of(AxisRole::x) != layout.size_of(AxisRole::x) ||
               next.size_of(AxisRole::y) != layout.size_of(AxisRole::y) ||
               next.size_of(AxisRole::z) != layout.size_of(AxisRole::z) || next.size_of(AxisRole::t) != 1 ||
               next.slope != layout.slope || next.intercept != layout.intercept) {
      fail_input(name, ": its sizes, type or scaling differ from those of ", path);
    }
  }
  if (file_per_frame) {
    frames = sequence.files.size();
    stack_files(layout, sequence);
    d.notes.push_back(sequence.note);
  }
  d.format = "NIfTI";
  d.dims = {layout.size_of(AxisRole::x), layout.size_of(AxisRole::y), layout.size_of(AxisRole::z), frames};
  d.axes = layout_text(layout);
  layout.describe(d.channels.emplace_back(), d);
  FramePlan plan = plan_frames(sequence, frames, options);
  DenseSeries series(std::move(segments), layout, memory_limit(options));
  return planned_series(std::make_unique<DenseReader>(std::move(d), std::move(series)), std::move(plan),
                        options);
}

} // namespace bcc4

// SPDX-License-Identifier: Apache-2.0
// Cuts frames out of an array of any order of axes. Where time is the slowest axis a frame is one piece of
// the array; elsewhere the array is read in passes, each of which collects as many frames as memory allows.
#include "readers/dense_series.h"

#include <algorithm>
#include <cstring>

#include "readers/error.h"

namespace bcc4 {
namespace {

const char* role_name(AxisRole role) {
  static constexpr const char* names[] = {"x", "y", "z", "t", "component"};
  return names[static_cast<size_t>(role)];
}

} // namespace

uint64_t DenseLayout::size_of(AxisRole role) const {
  for (const FileAxis& axis : axes)
    if (axis.role == role) return axis.size;
  return 1;
}

uint64_t layout_bytes(const DenseLayout& layout, const std::string& path) {
  uint64_t bytes = type_size(layout.type);
  for (const FileAxis& axis : layout.axes) {
    if (axis.size == 0) fail_input(path, ": axis ", role_name(axis.role), " has no samples");
    if (axis.size > INT32_MAX || bytes > UINT64_MAX / 4 / axis.size)
      fail_input(path, ": axis ", role_name(axis.role), " has ", axis.size, " samples: too many");
    bytes *= axis.size;
  }
  return bytes;
}

std::string layout_text(const DenseLayout& layout) {
  std::string text;
  for (size_t i = 0; i < layout.axes.size(); ++i)
    text += concat(i > 0 ? ", " : "", role_name(layout.axes[i].role), " ", layout.axes[i].size,
                   i == 0 ? " (fastest)" : "");
  return text;
}

std::vector<FileAxis> axes_from_letters(const std::string& letters, const std::array<uint64_t, 4>& sizes) {
  std::vector<FileAxis> axes;
  const std::string known = "xyzt";
  for (const char letter : letters) {
    const size_t a = known.find(letter);
    if (a == std::string::npos || letters.find(letter) != letters.rfind(letter) ||
        (letters.size() != 3 && letters.size() != 4))
      fail_usage("--axes ", letters,
                 ": write each of x, y, z and t once, fastest first, such as xyzt or zyxt");
    axes.push_back({static_cast<AxisRole>(a), sizes[a]});
  }
  for (size_t a = 0; a < 3; ++a)
    if (letters.find(known[a]) == std::string::npos)
      fail_usage("--axes ", letters, ": ", known[a], " is missing");
  return axes;
}

std::vector<AxisRole> roles_from_letters(const std::string& letters, size_t count, const std::string& owner,
                                         bool with_components) {
  if (letters.size() != count)
    fail_usage("--axes ", letters, " names ", letters.size(), " axes, but ", owner, " has ", count);
  std::string places = letters;
  const size_t c = with_components ? letters.find('c') : std::string::npos;
  if (c != std::string::npos) places.erase(c, 1);
  std::vector<AxisRole> roles;
  for (const FileAxis& axis : axes_from_letters(places, {1, 1, 1, 1})) roles.push_back(axis.role);
  if (c != std::string::npos)
    roles.insert(roles.begin() + static_cast<std::ptrdiff_t>(c), AxisRole::component);
  return roles;
}

void leave_unread(std::vector<Segment>& segments, const DenseLayout& layout, const FrameSelection& frames) {
  if (!frames.given || frames.last < 0 || layout.axes.back().role != AxisRole::t) return;
  uint64_t all = 0;
  for (const Segment& s : segments) all += s.bytes;
  const uint64_t count = layout.axes.back().size,
                 taken = std::min<uint64_t>(count, uint64_t{1} + frames.last);
  uint64_t unread = all / count * (count - taken);
  for (auto s = segments.rbegin(); s != segments.rend(); ++s)
    s->unread = std::min(unread, s->bytes), unread -= s->unread;
}

std::string whole_frames(const DenseLayout& layout, uint64_t bytes) {
  if (layout.axes.back().role != AxisRole::t) return "";
  uint64_t frame = type_size(layout.type);
  for (const FileAxis& axis : layout.axes) frame *= axis.role == AxisRole::t ? 1 : axis.size;
  const uint64_t whole = std::min(bytes / frame, layout.axes.back().size);
  if (whole == 0) return "";
  return concat("its first ", whole, whole > 1 ? " frames are" : " frame is", " whole: --frames 0",
                whole > 1 ? concat("-", whole - 1) : "");
}

void check_segments(std::vector<Segment>& segments, const DenseLayout& layout, const FrameSelection& frames) {
  leave_unread(segments, layout, frames);
  uint64_t held = 0;
  for (const Segment& s : segments) {
    try {
      check_segment(s);
    } catch (const Error& e) {
      const uint64_t size = file_size(s.path), begin = s.offset + s.discard;
      if (size > begin) held += std::min(s.bytes, size - begin);
      const bool cut = s.encoding == Encoding::raw && size < begin + s.bytes;
      const std::string whole = cut ? whole_frames(layout, held) : "";
      throw Error(e.code(), concat(e.what(), whole.empty() ? "" : "; ", whole));
    }
    held += s.bytes;
  }
}

DenseSeries::DenseSeries(std::vector<Segment> segments, DenseLayout layout, uint64_t memory_limit)
    : bytes_(std::move(segments)), layout_(std::move(layout)), frame_type_(layout_.value_type()),
      inner_(type_size(layout_.type)) {
  bool slower = false;
  for (const FileAxis& axis : layout_.axes) {
    if (axis.role == AxisRole::t)
      slower = true;
    else
      (slower ? outer_ : inner_) *= axis.size;
  }
  const uint64_t frame = inner_ * outer_;
  const uint64_t held =
      frame / type_size(layout_.type) * std::max(type_size(layout_.type), type_size(frame_type_));
  memory_limit_ = memory_limit, frame_held_ = held;
  if (!frame_fits() && !has_planes()) refuse_frame();
  if (outer_ > 1) batch_ = std::clamp<uint64_t>(memory_limit / 2 / held, 1, layout_.size_of(AxisRole::t));
}

void DenseSeries::refuse_frame() const {
  fail_resources(bytes_.path_at(0), ": one frame takes ", byte_text(static_cast<double>(frame_held_)),
                 ", more than the ", byte_text(static_cast<double>(memory_limit_)),
                 " allowed: raise --max-mem");
}

bool DenseSeries::has_planes() const {
  const auto& axes = layout_.axes;
  const size_t space = axes.size() - (axes.back().role == AxisRole::t ? 1 : 0);
  return outer_ == 1 && space == 3 && axes[2].role == AxisRole::z &&
         layout_.size_of(AxisRole::component) == 1;
}

const std::string& DenseSeries::path_of(uint64_t t) const {
  return bytes_.path_at(outer_ > 1 ? 0 : t * inner_);
}

std::string DenseSeries::passes_text() const {
  if (outer_ == 1) return "";
  const uint64_t frames = layout_.size_of(AxisRole::t), passes = (frames + batch_ - 1) / batch_;
  return concat("time is not the slowest axis: ", passes, passes == 1 ? " pass" : " passes",
                " over the file, ", batch_, " frames in memory at a time");
}

void DenseSeries::fetch(uint64_t t) {
  const uint64_t frames = layout_.size_of(AxisRole::t);
  held_.clear();
  first_ = outer_ > 1 ? t / batch_ * batch_ : t;
  const uint64_t count = std::min(batch_, frames - first_);
  std::vector<std::shared_ptr<Bytes>> raw(count);
  for (auto& bytes : raw) bytes = std::make_shared<Bytes>(inner_ * outer_);
  if (outer_ == 1) {
    bytes_.read(t * inner_, *raw[0]);
  } else { // whole rows of time at a time; the frames wanted are cut out
    const uint64_t row = inner_ * frames;
    const uint64_t rows = std::clamp<uint64_t>((uint64_t{1} << 22) / row, 1, outer_);
    Bytes chunk;
    for (uint64_t o = 0; o < outer_; o += rows) {
      const uint64_t n = std::min(rows, outer_ - o);
      chunk.resize(n * row);
      bytes_.read(o * row, chunk);
      for (uint64_t f = 0; f < count; ++f)
        for (uint64_t k = 0; k < n; ++k)
          std::memcpy(raw[f]->data() + (o + k) * inner_, chunk.data() + k * row + (first_ + f) * inner_,
                      inner_);
    }
  }
  for (auto& bytes : raw) {
    if (layout_.swap) swap_bytes(*bytes, type_size(layout_.type));
    layout_.convert(*bytes);
    held_.push_back(std::move(bytes));
  }
}

Frame DenseSeries::read(uint64_t t, uint64_t component) {
  if (!frame_fits()) refuse_frame();
  if (held_.empty() || t < first_ || t >= first_ + held_.size()) fetch(t);
  return dense_frame(frame_type_, held_[t - first_], layout_.axes, component);
}

// Whole planes are read one after the other, and what is wanted is cut out of each.
std::shared_ptr<Bytes> DenseSeries::read_planes(uint64_t t, const SampleBox& wanted) {
  const uint64_t size = type_size(layout_.type), plane = inner_ / layout_.size_of(AxisRole::z);
  const auto fast = static_cast<size_t>(layout_.axes[0].role),
             slow = static_cast<size_t>(layout_.axes[1].role);
  const uint64_t row = size * layout_.axes[0].size, part = size * wanted.dims[fast];
  const uint64_t rows = wanted.dims[slow];
  auto bytes = std::make_shared<Bytes>(part * rows * wanted.dims[2]);
  const bool all = part * rows == plane;
  Bytes one(all ? 0 : plane);
  for (uint64_t z = 0; z < wanted.dims[2]; ++z) {
    const std::span<std::byte> to = std::span(*bytes).subspan(z * part * rows, part * rows);
    bytes_.read(t * inner_ + (wanted.begin[2] + z) * plane, all ? to : std::span(one));
    for (uint64_t r = 0; r < rows && !all; ++r)
      std::memcpy(to.data() + r * part,
                  one.data() + (wanted.begin[slow] + r) * row + wanted.begin[fast] * size, part);
  }
  return bytes;
}

Frame DenseSeries::read_box(uint64_t t, uint64_t component, const SampleBox& wanted) {
  if (!has_planes() || (frame_fits() && wanted.dims[2] == layout_.size_of(AxisRole::z)))
    return read(t, component);
  held_.clear(); // they would stay beside the planes
  const std::shared_ptr<Bytes> bytes = read_planes(t, wanted);
  if (layout_.swap) swap_bytes(*bytes, type_size(layout_.type));
  layout_.convert(*bytes);
  std::vector<FileAxis> axes = layout_.axes;
  for (FileAxis& axis : std::span(axes).first(3)) axis.size = wanted.dims[static_cast<size_t>(axis.role)];
  Frame frame = dense_frame(frame_type_, bytes, axes, component);
  frame.boxes[0].begin = wanted.begin;
  return frame;
}

} // namespace bcc4

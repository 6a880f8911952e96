// SPDX-License-Identifier: Apache-2.0
#include "readers/netcdf/netcdf_frames.h"

#include <algorithm>

#include "readers/error.h"
#include "readers/held_file.h"

namespace bcc4 {
namespace {

// Reverses the order of samples of `inner` bytes along an axis of `size` of them.
void turn_axis(Bytes& bytes, size_t inner, size_t size) {
  for (std::byte* row = bytes.data(); row < bytes.data() + bytes.size(); row += inner * size)
    for (size_t i = 0; i < size / 2; ++i)
      std::swap_ranges(row + i * inner, row + (i + 1) * inner, row + (size - 1 - i) * inner);
}

class NetcdfReader : public FrameReader {
 public:
  NetcdfReader(SeriesDescription description, std::vector<NetcdfChannel> channels,
               std::vector<AxisRole> roles, std::vector<NetcdfPart> parts, std::unique_ptr<NetcdfFile> first)
      : description_(std::move(description)), channels_(std::move(channels)), roles_(std::move(roles)),
        parts_(std::move(parts)), file_(std::move(first)) {}

  const SeriesDescription& description() const override { return description_; }
  std::string frame_name(uint64_t frame) const override { return part_of(frame).path; }

  Frame read(uint64_t frame, size_t channel) override {
    const auto& n = description_.dims;
    return read_box(frame, channel, {{0, 0, 0}, {n[0], n[1], n[2]}});
  }

  Frame read_box(uint64_t frame, size_t channel, const SampleBox& wanted) override {
    const NetcdfPart& part = part_of(frame);
    const NetcdfFile& file = hold_file(file_, part.path);
    const NetcdfChannel& c = channels_[channel];
    const StoredValues& stored = c.of_files[static_cast<size_t>(&part - parts_.data())];
    const NetcdfVariable* v = file.find(c.name);
    if (!v || !v->type || type_size(*v->type) != type_size(stored.type) || v->dims.size() != roles_.size())
      fail_input(part.path, ": variable ", c.name, " is not as it was: the file has changed");
    std::vector<size_t> start(roles_.size(), 0), count(roles_.size(), 1);
    std::vector<FileAxis> axes;
    size_t bytes = type_size(stored.type);
    for (size_t a = 0; a < roles_.size(); ++a) {
      const uint64_t size =
          roles_[a] == AxisRole::t ? part.count : description_.dims[static_cast<size_t>(roles_[a])];
      if (v->dims[a].size != size)
        fail_input(part.path, ": dimension ", v->dims[a].name, " has ", v->dims[a].size, " samples, not ",
                   size);
      if (roles_[a] == AxisRole::t) {
        start[a] = frame - part.first;
        continue;
      }
      const auto axis = static_cast<size_t>(roles_[a]);
      const uint64_t begin = wanted.begin[axis], length = wanted.dims[axis];
      start[a] = part.turned[axis] ? size - begin - length : begin;
      bytes *= count[a] = length;
    }
    for (size_t a = roles_.size(); a-- > 0;) axes.push_back({roles_[a], count[a]});
    auto values = std::make_shared<Bytes>(bytes);
    file.read(*v, start, count, *values);
    const Type type = description_.channels[channel].type;
    stored.convert(*values, type);
    turn(*values, part, axes, type_size(type));
    Frame box = dense_frame(type, std::move(values), axes);
    box.boxes[0].begin = wanted.begin;
    return box;
  }

 private:
  // `axes` are the fastest first.
  static void turn(Bytes& values, const NetcdfPart& part, const std::vector<FileAxis>& axes, size_t inner) {
    for (const FileAxis& axis : axes) {
      if (axis.role != AxisRole::t && part.turned[static_cast<size_t>(axis.role)])
        turn_axis(values, inner, axis.size);
      inner *= axis.size;
    }
  }
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

} // namespace

std::unique_ptr<FrameReader> netcdf_frames(SeriesDescription description, std::vector<NetcdfChannel> channels,
                                           std::vector<AxisRole> roles, std::vector<NetcdfPart> parts,
                                           std::unique_ptr<NetcdfFile> file) {
  return std::make_unique<NetcdfReader>(std::move(description), std::move(channels), std::move(roles),
                                        std::move(parts), std::move(file));
}

} // namespace bcc4

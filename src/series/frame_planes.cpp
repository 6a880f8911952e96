// SPDX-License-Identifier: Apache-2.0
#include "series/frame_planes.h"

#include <algorithm>

namespace bccsplat::series {
namespace {

constexpr uint64_t kBytesAtOnce = 4 << 20, kFewestHeld = 3; // one and those beside it

} // namespace

FramePlanes::FramePlanes(FrameReader& reader, uint64_t frame, size_t channel)
    : reader_(reader), frame_(frame), channel_(channel), whole_(reader.frames_fit()) {
  if (!whole_) return;
  held_ = reader.read(frame, channel);
  end_ = reader.description().dims[2];
}

void FramePlanes::gather(uint64_t z, double air, double* plane) {
  const SeriesDescription& s = reader_.description();
  if (z < begin_ || z >= end_) {
    held_ = {};
    const uint64_t bytes = frame_bytes(s, channel_) / s.dims[2];
    begin_ = z, end_ = std::min(s.dims[2], z + std::max(kFewestHeld, kBytesAtOnce / bytes));
    held_ = reader_.read_box(frame_, channel_, {{0, 0, begin_}, {s.dims[0], s.dims[1], end_ - begin_}});
  }
  gather_plane(held_, s.dims, z, air, plane);
}

bool FramePlanes::may_have(uint64_t begin, uint64_t end) const {
  return !whole_ || std::any_of(held_.boxes.begin(), held_.boxes.end(), [&](const Box& box) {
    return box.begin[2] < end && begin < box.begin[2] + box.dims[2];
  });
}

} // namespace bccsplat::series

// SPDX-License-Identifier: Apache-2.0
#include "store/earlier_frames.h"

namespace bccsplat {

void EarlierFrames::see(uint32_t number, std::span<const FrameBox> boxes) {
  count_ = knows(number) ? 2 : 1;
  end_ = number + 1;
  std::vector<HeldFrame>& planes = frames_[number % 2];
  planes.clear();
  for (int64_t z = SeenPlanes{planes_apart, dims_[2]}.first(); z < dims_[2]; z += planes_apart)
    planes.emplace_back(boxes, air_, memory_, held_grid({{0, 0, z}, {dims_[0], dims_[1], z + 1}}, 1));
}

std::span<const float> EarlierFrames::expect(int64_t z) {
  const size_t at = (z - SeenPlanes{planes_apart, dims_[2]}.first()) / planes_apart;
  const size_t samples = dims_[0] * dims_[1];
  expected_.resize(samples);
  for (uint32_t i = 0; i < count_; ++i) {
    room_[i].resize(samples);
    frames_[(end_ - 1 - i) % 2][at].plane(0, room_[i].data());
  }
  const std::vector<double>&last = room_[0], &before = room_[count_ - 1];
  for (size_t i = 0; i < samples; ++i) expected_[i] = static_cast<float>(2 * last[i] - before[i] - air_);
  return expected_;
}

} // namespace bccsplat

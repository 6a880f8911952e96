// SPDX-License-Identifier: Apache-2.0
// Planes of the two frames before one that is measured, which tell where it changes. Errors in time are where
// something moves, and one frame does not tell that.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/memory.h"
#include "fit/frame/frame.h"
#include "store/held_frame.h"

namespace bccsplat {

// Every so many planes of a frame, the first one half of that behind its face.
struct SeenPlanes {
  int64_t apart, planes;
  [[nodiscard]] int64_t first() const { return (planes < apart ? planes : apart) / 2; }
};

class EarlierFrames {
 public:
  // planes_apart: of those that are kept. Where something thin moves a plane of four shows it, one of eight
  // with rows left out is off by a third.
  static constexpr int64_t planes_apart = 4;

  EarlierFrames(const std::array<int64_t, 3>& dims, double air, MemoryBudget& memory)
      : dims_(dims), air_(air), memory_(memory) {}

  // Frames of rising numbers; with a gap between them the earlier ones are forgotten.
  void see(uint32_t number, std::span<const FrameBox> boxes);
  [[nodiscard]] bool knows(uint32_t number) const { return count_ > 0 && number == end_; }
  // Returns what the frames before a known one let expect of its plane z, relative to air: that it goes on as
  // they do, or of one frame alone that nothing changes.
  [[nodiscard]] std::span<const float> expect(int64_t z);

 private:
  std::array<int64_t, 3> dims_;
  double air_;
  MemoryBudget& memory_;
  uint32_t end_ = 0, count_ = 0;                 // of the frames seen: the last ones before end_
  std::array<std::vector<HeldFrame>, 2> frames_; // planes; by the parity of the frame's number
  std::array<std::vector<double>, 2> room_;
  std::vector<float> expected_;
};

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Series of the size that people have, made on the spot and written into a file in memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "tests/bench/moments/moments_content.h"

namespace bccsplat::bench {

struct MomentSeries {
  uint32_t edge = 256, frames = 16; // voxels along each axis of space
  bool sparse = false;              // only a ball that moves and fills an eighth of the box
  int levels = 0;                   // coarser ones
  bool measured = false;            // what it is off by is told, of some frames
  Content fill = Content::waves;
  bool exact = false; // f32 frames, nothing rounded

  [[nodiscard]] double voxels() const; // of all frames
  [[nodiscard]] std::vector<float> unrounded(uint32_t t) const;
  [[nodiscard]] std::vector<uint8_t> frame(uint32_t t) const;
};

struct WrittenSeries {
  std::vector<std::byte> file;
  double seconds = 0; // CPU time, on one thread, that the frames' making does not count in
  uint64_t peak = 0;  // bytes held, but for the frame that is given
};
[[nodiscard]] WrittenSeries write_series(const MomentSeries& series);

// What the same costs those who keep frames as they are: CPU seconds.
// Two frames in memory, blended.
[[nodiscard]] double blend_seconds(const MomentSeries& series);
// gzip -6 of one frame.
[[nodiscard]] double gzip_seconds(const MomentSeries& series);

} // namespace bccsplat::bench

// SPDX-License-Identifier: Apache-2.0
// The planes of a frame, whether or not all of it fits the memory.
#pragma once

#include "series/frame_reader.h"

namespace bccsplat::series {

// Holds the frame where it fits, else some planes of it; cheapest in rising order. The reader must not be
// used by others meanwhile.
class FramePlanes {
 public:
  FramePlanes(FrameReader& reader, uint64_t frame, size_t channel);

  // Copies the plane z as doubles, as gather_plane does.
  void gather(uint64_t z, double air, double* plane);
  // Returns whether planes begin .. end - 1 may have samples that are not air.
  [[nodiscard]] bool may_have(uint64_t begin, uint64_t end) const;

 private:
  FrameReader& reader_;
  uint64_t frame_;
  size_t channel_;
  bool whole_;
  Frame held_;
  uint64_t begin_ = 0, end_ = 0; // planes held
};

} // namespace bccsplat::series

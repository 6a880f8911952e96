// SPDX-License-Identifier: Apache-2.0
// Coarser levels where nobody says how many: pictures take the one they need unasked, so data that are large
// enough get them.
#pragma once

#include <array>
#include <cstdint>

#include "series/frame_reader.h"

namespace bccsplat::series {

struct LevelChoice {
  bool automatic = false; // nobody said how many
  bool labels = false;    // a channel holds labels, which have no mean: none, then
  bool scattered = false; // next to nothing of the frames is active: none, then
};

// Levels until a frame is smaller than about 96^3 samples; none where all of it is smaller than 192^3.
[[nodiscard]] uint32_t levels_for(const std::array<uint64_t, 4>& dims);

} // namespace bccsplat::series

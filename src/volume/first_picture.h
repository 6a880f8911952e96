// SPDX-License-Identifier: Apache-2.0
// What somebody sees first of a file who has chosen nothing.
#pragma once

#include "series/data_kind.h"
#include "shade/kind_look.h"
#include "volume/open_volume.h"

namespace bccsplat {

struct FirstPicture {
  Layout layout = Layout::volume;
  uint32_t frame = 0;
};

// Reads nothing. Frames that are about as good as the best count for it: of these it is the one nearest to
// the middle of the series, where things are under way.
[[nodiscard]] FirstPicture first_picture(const OpenVolume& volume, uint32_t channel, series::DataKind kind);

// Returns the frame whose values span most; ranges: of each frame. None: 0.
[[nodiscard]] uint32_t frame_that_shows_most(const std::vector<Range>& ranges);

} // namespace bccsplat

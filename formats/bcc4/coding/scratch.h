// SPDX-License-Identifier: Apache-2.0
// Memory that is used again for chunk after chunk.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "formats/bcc4/coding/deflate.h"
#include "formats/bcc4/coding/predict_walk.h"
#include "formats/bcc4/wavelet/wavelet_tile.h"

namespace bccsplat {

struct ChunkScratch {
  Inflater inflater;
  CellRing<int32_t> ring;
  TileRoom room;
  std::vector<std::byte> runs, values; // inflated
};

} // namespace bccsplat

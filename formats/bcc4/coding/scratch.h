// Memory that decoding chunks one after the other uses again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "formats/bcc4/coding/deflate.h"
#include "formats/bcc4/coding/predict_walk.h"

namespace bccsplat {

struct ChunkScratch {
  Inflater inflater;
  CellRing<int32_t> ring;
  std::vector<std::byte> runs, values; // inflated
};

} // namespace bccsplat

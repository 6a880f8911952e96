// SPDX-License-Identifier: Apache-2.0
// The predictor of a chunk.
#pragma once

#include <cstdint>
#include <vector>

#include "formats/bcc4/coding/predict.h"

namespace bccsplat {

struct Choice {
  Predictor predictor = Predictor::none;
  std::vector<int16_t> weights; // of Predictor::fitted
  std::vector<uint32_t> residuals;
};
// The one whose residuals promise the fewest bits. `level` is that of Bcc4WriterOptions.
[[nodiscard]] Choice choose_predictor(const ChunkSites& sites, const ChunkCodes& codes, int level);

} // namespace bccsplat

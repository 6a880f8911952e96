// SPDX-License-Identifier: Apache-2.0
// Prediction with given weights, row by row, in loops that are compiled once for each instruction set.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "formats/bcc4/coding/predict_walk.h"

namespace bccsplat {

// Weights, and where one residual per kept site goes.
struct Prediction {
  const ClassWeights* weights;
  uint32_t* residuals;
};
// One or two of them in one walk.
void predict_rows(const ChunkSites& sites, const ChunkCodes& codes, std::span<const Prediction> wanted);
// Does the reverse; the arguments are those of unpredict.
void unpredict_rows(const ChunkShape& shape, std::span<const BrickMask> kept, const ChunkCodes& codes,
                    const ClassWeights& weights, std::span<const std::byte> planes, std::byte* packed,
                    CellRing<int32_t>& ring, const WalkedLayers& layers);

} // namespace bccsplat

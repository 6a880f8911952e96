// SPDX-License-Identifier: Apache-2.0
// The cells that a walk goes on with, from codes that an earlier walk decoded.
#pragma once

#include <cstdint>
#include <span>

#include "formats/bcc4/coding/chunk.h"
#include "formats/bcc4/coding/predict_walk.h"

namespace bccsplat {

// Fills the cells of the two layers before layer `next`, codes of up to 16 bits, as a walk from the first
// layer leaves them.
void restore_cells(const ChunkShape& shape, std::span<const BrickMask> kept, const ChunkCodes& codes,
                   int next, const LayersBefore& before, CellRing<int32_t>& ring);

} // namespace bccsplat

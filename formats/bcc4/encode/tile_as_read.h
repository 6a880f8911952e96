// SPDX-License-Identifier: Apache-2.0
// What a reader gets of a tile that is being coded, beside what was wanted.
#pragma once

#include <vector>

#include "formats/bcc4/coding/linear_tile.h"
#include "formats/bcc4/encode/encode_tile.h"

namespace bccsplat {

// Makes the bricks that a reader gets of the kept sites, within the range that these had, adds the squares of
// what they are off by, and returns the range of their codes.
[[nodiscard]] CodeRange read_back(const TileSites& sites, const SampleCoder& coder,
                                  std::vector<TileLayers> layers, EncodedTile& tile);
// The same of samples that are linear in what is coded.
[[nodiscard]] CodeRange read_linear(const TileSites& sites, const SampleCoder& coder, const LinearTile& back,
                                    EncodedTile& tile);

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// What a chunk costs with predictors whose weights are constant, found in one walk over its sites.
#pragma once

#include <array>
#include <cstdint>

#include "formats/bcc4/coding/predict.h"

namespace bccsplat {

inline constexpr size_t constant_predictors = 5; // Predictor::none to Predictor::cross

// Returns for each of them the bits, times 256, of its residuals' byte planes at their own frequencies;
// UINT64_MAX: more than `limit`, which a part of the sites has shown. Codes have one or two bytes.
[[nodiscard]] std::array<uint64_t, constant_predictors>
constant_bits(const ChunkSites& sites, const ChunkCodes& codes, uint64_t limit);

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// The weights of predictor 5.
#pragma once

#include <cstdint>

#include "formats/bcc4/coding/predict.h"

namespace bccsplat {

// Weights by least squares on a sample of the sites. sample: how many are looked at, more or less; more than
// that did not make chunks smaller.
[[nodiscard]] FittedWeights fit_weights(const ChunkSites& sites, const ChunkCodes& codes,
                                        uint32_t sample = 6144);

} // namespace bccsplat

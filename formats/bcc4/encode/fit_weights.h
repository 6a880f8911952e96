// SPDX-License-Identifier: Apache-2.0
// The weights of predictor 5.
#pragma once

#include "formats/bcc4/coding/predict.h"

namespace bccsplat {

// Weights by least squares on a sample of the sites.
[[nodiscard]] FittedWeights fit_weights(const ChunkSites& sites, const ChunkCodes& codes);

} // namespace bccsplat

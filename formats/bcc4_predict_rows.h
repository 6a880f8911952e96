// Prediction with given weights, row by row; compiled once for each instruction set.
#pragma once

#include <cstdint>

#include "formats/bcc4_predict_walk.h"

namespace bccsplat {

// `residuals` and `decoded`: one per kept site.
void predict_rows(const ChunkSites& sites, const ChunkCodes& codes, const ClassWeights& weights,
                  uint32_t* residuals);
// Does not read sites.codes.
void unpredict_rows(const ChunkSites& sites, const ChunkCodes& codes, const ClassWeights& weights,
                    const uint32_t* residuals, uint32_t* decoded);

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
// Prediction of codes from neighbours on the lattice (bcc4.md, section 7).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/bcc4/coding/predict_walk.h"

namespace bccsplat {

enum class Predictor : uint8_t {
  none = 0,     // the code itself
  west = 1,     // the neighbour at x - 1
  lorenzo = 2,  // the corner of the cube whose other seven corners are known
  previous = 3, // the same site one layer of its coset earlier
  cross = 4,    // the mean of the 8 neighbours in the layer before
  fitted = 5,   // a weighted sum of all of these, weights in the chunk
};
inline constexpr uint8_t predictor_count = 6;

// Returns the folded differences to the predictions, one per kept site, or the codes for Predictor::none.
// `weights` are those of Predictor::fitted, else empty.
[[nodiscard]] std::vector<uint32_t> predict(const ChunkSites& sites, const ChunkCodes& codes,
                                            Predictor predictor, std::span<const int16_t> weights);
// Does the reverse. `planes` are the residuals as byte planes, all lowest bytes first; `packed` receives the
// codes, of codes.bytes() bytes each. unpredict_slack bytes before and behind the planes are read, and as
// many behind the codes are written. `ring` is room to work in, empty or from any earlier call. Only the
// codes of `layers` are made, each at its place among all of them; from a later layer than the first on, the
// ring has what restore_cells put there. Codes of four bytes are all made.
inline constexpr size_t unpredict_slack = 64;
void unpredict(const ChunkShape& shape, std::span<const BrickMask> kept, const ChunkCodes& codes,
               Predictor predictor, std::span<const int16_t> weights, std::span<const std::byte> planes,
               std::byte* packed, CellRing<int32_t>& ring, const WalkedLayers& layers = {});

// The number of weights that a chunk of this shape holds for Predictor::fitted.
[[nodiscard]] size_t fitted_weights(const ChunkShape& shape);
// Weights by least squares (fit_weights.h). Unchained ones leave out the site at x - 1 in layers
// that come after a layer of the other coset: the sites of a row then do not depend on each other and are
// decoded side by side, at the price of about one per cent of size, and of a tenth where values are coarse.
struct FittedWeights {
  std::vector<int16_t> chained, unchained;
};
// The weights of the other predictors, and of a class that has too few sites to fit any.
[[nodiscard]] Weights constant_weights(Predictor predictor, int c);
// What `predict` returns for both of them, in less time.
struct FittedResiduals {
  std::vector<uint32_t> chained, unchained;
};
[[nodiscard]] FittedResiduals predict(const ChunkSites& sites, const ChunkCodes& codes,
                                      const FittedWeights& weights);

} // namespace bccsplat

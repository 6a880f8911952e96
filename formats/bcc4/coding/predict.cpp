// SPDX-License-Identifier: Apache-2.0
// Predictors as weights of neighbours, checked, and handed to the loops over rows.
#include "formats/bcc4/coding/predict.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <cstring>

#include "base/error.h"
#include "formats/bcc4/coding/predict_rows.h"

namespace bccsplat {

Weights constant_weights(Predictor predictor, int c) {
  Weights w{};
  const bool cross = c & 1, previous = c & 2;
  const size_t previous_at = own_taps + (cross ? cross_taps : 0);
  const auto use_cross = [&] { std::fill_n(w.begin() + own_taps, cross_taps, int16_t{512}); };
  switch (predictor) {
  case Predictor::lorenzo:
    w = {4096, 4096, 4096, -4096, -4096, -4096, 4096};
    break;
  case Predictor::previous:
    if (previous)
      w[previous_at] = 4096;
    else if (cross)
      use_cross();
    else
      w[0] = 4096;
    break;
  case Predictor::cross:
    if (cross)
      use_cross();
    else if (previous)
      w[previous_at] = 4096;
    else
      w[0] = 4096;
    break;
  default:
    w[0] = 4096;
    break;
  }
  return w;
}

namespace {

[[nodiscard]] ClassWeights class_weights(const ChunkShape& shape, Predictor predictor,
                                         std::span<const int16_t> fitted) {
  ClassWeights all{};
  const unsigned present = classes_present(shape);
  for (int c = 0; c < classes; ++c) {
    auto& w = all[c];
    if (predictor != Predictor::fitted) {
      w = constant_weights(predictor, c);
    } else if (present >> c & 1) {
      const size_t n = class_taps(c);
      std::copy_n(fitted.begin(), n, w.begin());
      fitted = fitted.subspan(n);
      int sum = 0;
      for (const int16_t v : w) sum += std::abs(int{v});
      // This rule keeps 32-bit sums from overflowing.
      if (sum > INT16_MAX)
        fail(Code::corrupt, "chunk: prediction weights sum to ", sum, ", more than ", INT16_MAX);
    }
  }
  return all;
}

template<class Stored> void join_bytes(const std::byte* planes, size_t count, std::byte* packed) {
  for (size_t i = 0; i < count; ++i) {
    Stored v = 0;
    for (size_t b = 0; b < sizeof v; ++b)
      v = static_cast<Stored>(v | static_cast<Stored>(static_cast<Stored>(planes[b * count + i]) << (8 * b)));
    std::memcpy(packed + i * sizeof v, &v, sizeof v);
  }
}

void join_planes(std::span<const std::byte> planes, uint32_t bytes, std::byte* packed) {
  const size_t count = planes.size() / bytes;
  if (bytes == 1)
    std::copy(planes.begin(), planes.end(), packed);
  else if (bytes == 2)
    join_bytes<uint16_t>(planes.data(), count, packed);
  else
    join_bytes<uint32_t>(planes.data(), count, packed);
}

} // namespace

std::vector<uint32_t> predict(const ChunkSites& sites, const ChunkCodes& codes, Predictor predictor,
                              std::span<const int16_t> weights) {
  if (predictor == Predictor::none) return sites.codes;
  const ClassWeights w = class_weights(sites.shape, predictor, weights);
  std::vector<uint32_t> residuals(sites.codes.size());
  const Prediction wanted{&w, residuals.data()};
  predict_rows(sites, codes, {&wanted, 1});
  return residuals;
}

FittedResiduals predict(const ChunkSites& sites, const ChunkCodes& codes, const FittedWeights& weights) {
  const ClassWeights chained = class_weights(sites.shape, Predictor::fitted, weights.chained),
                     unchained = class_weights(sites.shape, Predictor::fitted, weights.unchained);
  FittedResiduals out;
  out.chained.resize(sites.codes.size()), out.unchained.resize(sites.codes.size());
  const std::array<Prediction, 2> wanted{
      {{&chained, out.chained.data()}, {&unchained, out.unchained.data()}}};
  predict_rows(sites, codes, wanted);
  return out;
}

void unpredict(const ChunkShape& shape, std::span<const BrickMask> kept, const ChunkCodes& codes,
               Predictor predictor, std::span<const int16_t> weights, std::span<const std::byte> planes,
               std::byte* packed, CellRing<int32_t>& ring, const WalkedLayers& layers) {
  if (predictor == Predictor::none)
    join_planes(planes, codes.bytes(), packed);
  else
    unpredict_rows(shape, kept, codes, class_weights(shape, predictor, weights), planes, packed, ring,
                   layers);
}

size_t fitted_weights(const ChunkShape& shape) {
  const unsigned present = classes_present(shape);
  size_t n = 0;
  for (int c = 0; c < classes; ++c)
    if (present >> c & 1) n += class_taps(c);
  return n;
}

} // namespace bccsplat

// SPDX-License-Identifier: Apache-2.0
#include "formats/bcc4/encode/choose_predictor.h"

#include <algorithm>
#include <array>
#include <utility>

#include "formats/bcc4/coding/entropy.h"
#include "formats/bcc4/encode/constant_bits.h"
#include "formats/bcc4/encode/fit_weights.h"

namespace bccsplat {
namespace {

// Weights with chains are chosen where they save more than 1/32. Without chains decoding takes 0.7 to 0.8 of
// the time; files grow by 1 to 2 %, and by 3 to 9 % where values are coarse (tests/bench/notes/storage.md).
constexpr uint64_t least_saved_by_chains = 32;

// The bits that the byte planes need at their own frequencies, times 256.
[[nodiscard]] uint64_t estimate_bits(std::span<const uint32_t> residuals, uint32_t bytes) {
  uint64_t cost = 0;
  for (uint32_t b = 0; b < bytes; ++b) cost += entropy_bits_256(count_bytes(residuals, 8 * b));
  return cost;
}

// What is left of sites by the predictors of constant weights; `residuals` of four bytes are kept from the
// trial, others are made of the one that is chosen.
struct Constant {
  Predictor predictor;
  uint64_t bits_256;
  std::vector<uint32_t> residuals;
};

[[nodiscard]] Constant best_wide_constant(const ChunkSites& sites, const ChunkCodes& codes) {
  Constant best{Predictor::none, estimate_bits(sites.codes, codes.bytes()), sites.codes};
  for (uint8_t id = 1; id < constant_predictors; ++id) {
    std::vector<uint32_t> r = predict(sites, codes, static_cast<Predictor>(id), {});
    const uint64_t bits = estimate_bits(r, codes.bytes());
    if (bits < best.bits_256) best = {static_cast<Predictor>(id), bits, std::move(r)};
  }
  return best;
}

[[nodiscard]] Constant best_constant(const ChunkSites& sites, const ChunkCodes& codes, uint64_t limit) {
  if (codes.bytes() == 4) return best_wide_constant(sites, codes);
  const std::array<uint64_t, constant_predictors> bits = constant_bits(sites, codes, limit);
  const auto lowest = std::min_element(bits.begin(), bits.end());
  return {static_cast<Predictor>(lowest - bits.begin()), *lowest, {}};
}

} // namespace

Choice choose_predictor(const ChunkSites& sites, const ChunkCodes& codes, int level) {
  FittedWeights fitted = fit_weights(sites, codes);
  FittedResiduals residuals = predict(sites, codes, fitted);
  const auto bits_of = [&](const std::vector<uint32_t>& r, const std::vector<int16_t>& weights) {
    return estimate_bits(r, codes.bytes()) + weights.size() * 16 * 256;
  };
  const uint64_t chained = bits_of(residuals.chained, fitted.chained),
                 unchained = bits_of(residuals.unchained, fitted.unchained);
  // Rows without chains decode side by side, so that chains must save something, but at level 9, where only
  // size counts.
  const bool smallest = level == 9;
  Constant constant = best_constant(sites, codes, smallest ? chained : unchained);
  uint64_t lowest = constant.bits_256;
  if (!smallest) lowest = std::min(lowest, unchained);
  if (chained + (smallest ? 0 : lowest / least_saved_by_chains) < lowest)
    return {Predictor::fitted, std::move(fitted.chained), std::move(residuals.chained)};
  if (!smallest && unchained < constant.bits_256)
    return {Predictor::fitted, std::move(fitted.unchained), std::move(residuals.unchained)};
  if (codes.bytes() < 4) constant.residuals = predict(sites, codes, constant.predictor, {});
  return {constant.predictor, {}, std::move(constant.residuals)};
}

} // namespace bccsplat

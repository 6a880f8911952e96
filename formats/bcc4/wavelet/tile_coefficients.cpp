// SPDX-License-Identifier: Apache-2.0
#include "formats/bcc4/wavelet/tile_coefficients.h"

#include <utility>

namespace bccsplat {

void CoefficientList::set(size_t at, float value, size_t samples) {
  constexpr size_t most_listed = 4; // a list of a quarter of all places has room for as much as all values
  if (values_.size() == samples) {
    values_[at] = value;
    return;
  }
  places_.push_back(static_cast<uint32_t>(at)), values_.push_back(value);
  if (values_.size() * most_listed < samples) return;
  std::vector<float> all(samples);
  for (size_t i = 0; i < places_.size(); ++i) all[places_[i]] = values_[i];
  values_ = std::move(all), places_ = {};
}

void CoefficientList::add_to(std::span<float> sum, float weight) const {
  if (places_.empty())
    for (size_t i = 0; i < values_.size(); ++i) sum[i] += weight * values_[i];
  else
    for (size_t i = 0; i < places_.size(); ++i) sum[places_[i]] += weight * values_[i];
}

void TileCoefficients::add_to(std::span<float> sum, std::span<const float> weights) const {
  for (int k = 0; k < basis_.frames; ++k) {
    if (layers_[k].empty()) continue;
    float weight = 0;
    for (int frame = 0; frame < basis_.frames; ++frame) weight += weights[frame] * basis_.weight(k, frame);
    if (weight != 0) layers_[k].add_to(sum, weight);
  }
}

uint64_t TileCoefficients::bytes() const {
  uint64_t bytes = sizeof *this + basis_.rows.size() * sizeof basis_.rows[0];
  for (const CoefficientList& layer : layers_) bytes += sizeof layer + layer.bytes();
  return bytes;
}

} // namespace bccsplat

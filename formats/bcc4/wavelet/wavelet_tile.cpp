// SPDX-License-Identifier: Apache-2.0
// From steps to numbers.
#include "formats/bcc4/wavelet/wavelet_tile.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "formats/bcc4/wavelet/step_walk.h"

namespace bccsplat {

int most_halvings(int size) {
  constexpr int least_kept = 2; // bits of the samples that are left
  return std::clamp(static_cast<int>(std::bit_width(static_cast<unsigned>(size))) - least_kept, 0,
                    most_halved);
}

TileLayers::TileLayers(const Halvings& shape, TimeBasis basis, std::vector<float> coefficients,
                       uint32_t filled)
    : samples_(shape.samples()), basis_(std::move(basis)), layers_(std::move(coefficients)) {
  for (int k = 0; k < basis_.frames; ++k) {
    if ((filled >> k & 1) == 0) continue;
    const auto from = layers_.begin() + static_cast<std::ptrdiff_t>(k * samples_),
               to = layers_.begin() + static_cast<std::ptrdiff_t>(filled_.size() * samples_);
    if (from != to) std::copy_n(from, samples_, to);
    synthesise(shape, std::span(&*to, samples_));
    filled_.push_back(k);
  }
  layers_.resize(filled_.size() * samples_ + beyond_sums);
  if (filled_.size() + 2 < static_cast<size_t>(basis_.frames)) layers_.shrink_to_fit();
}

std::vector<WeighedLayer> TileLayers::sum_of(int frame) const {
  std::vector<WeighedLayer> sum;
  for (size_t i = 0; i < filled_.size(); ++i)
    sum.push_back({layers_.data() + i * samples_, basis_.weight(filled_[i], frame)});
  return sum;
}

std::vector<float> TileLayers::frames() const {
  std::vector<float> out(samples_ * basis_.frames);
  for (int t = 0; t < basis_.frames; ++t) sum_layers(sum_of(t), 0, samples_, out.data() + t * samples_);
  return out;
}

TileLayers restore_tile(const TileBands& bands, const StepRule& rule) {
  const size_t layer = bands.shape.samples();
  std::vector<float> values;
  values.reserve(bands.steps.size() + beyond_sums);
  uint32_t filled = 0;
  for (const int32_t steps : bands.steps) {
    if (steps != 0) filled |= uint32_t{1} << values.size() / layer;
    values.push_back(value_of(steps, rule));
  }
  return {bands.shape, bands.basis, std::move(values), filled};
}

} // namespace bccsplat

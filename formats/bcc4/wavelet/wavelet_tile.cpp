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

TileLayers::TileLayers(const Halvings& shape, TimeBasis basis, const LayerCoefficients& coefficients)
    : samples_(shape.samples()), stride_(coefficients.stride_), basis_(std::move(basis)),
      held_(basis_.frames), layers_(coefficients.layers_) {
  for (int k = 0; k < basis_.frames; ++k) {
    if ((coefficients.filled_ >> k & 1) == 0) continue;
    filled_.emplace_back(k, k);
    synthesise(shape, std::span(coefficients.layers_.get() + k * stride_, samples_));
  }
  // Few layers may be kept for long, in place of codes.
  if (filled_.size() * 2 >= held_) return;
  held_ = filled_.size();
  const std::shared_ptr<float[]> few(new float[held_ * stride_]);
  for (size_t i = 0; i < held_; ++i)
    std::copy_n(layers_.get() + std::exchange(filled_[i].second, i) * stride_, stride_,
                few.get() + i * stride_);
  layers_ = few;
}

std::vector<WeighedLayer> TileLayers::sum_of(int frame) const {
  std::vector<WeighedLayer> sum;
  for (const auto& [layer, place] : filled_)
    sum.push_back({layers_.get() + place * stride_, basis_.weight(layer, frame)});
  return sum;
}

std::vector<float> TileLayers::frames() const {
  std::vector<float> out(samples_ * basis_.frames);
  for (int t = 0; t < basis_.frames; ++t) sum_layers(sum_of(t), 0, samples_, out.data() + t * samples_);
  return out;
}

TileLayers restore_tile(const TileBands& bands, const StepRule& rule, LayerRoom& room) {
  const size_t samples = bands.shape.samples();
  LayerCoefficients out(samples, bands.basis.frames, room);
  for (int k = 0; k < bands.basis.frames; ++k) {
    const auto steps = std::span(bands.steps).subspan(k * samples, samples);
    if (std::any_of(steps.begin(), steps.end(), [](int32_t s) { return s != 0; }))
      std::transform(steps.begin(), steps.end(), out.fill(k), [&](int32_t s) { return value_of(s, rule); });
  }
  return {bands.shape, bands.basis, out};
}

} // namespace bccsplat

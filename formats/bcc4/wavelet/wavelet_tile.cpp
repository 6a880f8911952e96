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

TileLayers::TileLayers(const TileCoefficients& coefficients, LayerRoom& room)
    : samples_(coefficients.shape().samples()), stride_(samples_ + beyond_sums),
      basis_(coefficients.basis()) {
  for (int k = 0; k < basis_.frames; ++k)
    if (!coefficients.layer(k).empty()) filled_.push_back(k);
  const size_t count = filled_.size() * stride_;
  // Few layers may be kept for long, in place of codes.
  const bool few = 2 * filled_.size() < static_cast<size_t>(basis_.frames);
  const std::shared_ptr<float[]> layers =
      few ? std::shared_ptr<float[]>(new float[count]) : room.take(basis_.frames * stride_);
  std::fill_n(layers.get(), count, 0.F);
  for (size_t i = 0; i < filled_.size(); ++i) {
    const std::span<float> layer(layers.get() + i * stride_, samples_);
    coefficients.layer(filled_[i]).add_to(layer, 1);
    synthesise(coefficients.shape(), layer);
  }
  layers_ = layers;
}

std::vector<WeighedLayer> TileLayers::sum_of(int frame) const {
  std::vector<WeighedLayer> sum;
  for (size_t i = 0; i < filled_.size(); ++i)
    sum.push_back({layers_.get() + i * stride_, basis_.weight(filled_[i], frame)});
  return sum;
}

std::vector<float> TileLayers::frames() const {
  std::vector<float> out(samples_ * basis_.frames);
  for (int t = 0; t < basis_.frames; ++t) sum_layers(sum_of(t), 0, samples_, out.data() + t * samples_);
  return out;
}

TileCoefficients coefficients_of(const TileBands& bands, const StepRule& rule) {
  constexpr size_t looked_at = 32; // steps at once: nearly all are 0
  const size_t samples = bands.shape.samples();
  TileCoefficients out(bands.shape, bands.basis);
  for (int layer = 0; layer < bands.basis.frames; ++layer) {
    const std::span steps = std::span(bands.steps).subspan(layer * samples, samples);
    for (size_t i = 0; i < samples; i += looked_at) {
      const size_t end = std::min(samples, i + looked_at);
      int32_t any = 0;
      for (size_t j = i; j < end; ++j) any |= steps[j];
      for (size_t j = i; any != 0 && j < end; ++j)
        if (steps[j] != 0) out.set(layer, j, value_of(steps[j], rule));
    }
  }
  return out;
}

} // namespace bccsplat

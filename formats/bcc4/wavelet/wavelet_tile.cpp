// SPDX-License-Identifier: Apache-2.0
// From steps to numbers.
#include "formats/bcc4/wavelet/wavelet_tile.h"

#include <algorithm>
#include <bit>

#include "formats/bcc4/wavelet/step_walk.h"

namespace bccsplat {

int most_halvings(int size) {
  constexpr int least_kept = 2; // bits of the samples that are left
  return std::clamp(static_cast<int>(std::bit_width(static_cast<unsigned>(size))) - least_kept, 0,
                    most_halved);
}

std::vector<float> restore_tile(const TileBands& bands, const StepRule& rule) {
  std::vector<float> values(bands.steps.size());
  for (size_t i = 0; i < values.size(); ++i) values[i] = value_of(bands.steps[i], rule);
  if (!values.empty()) to_numbers(bands, values);
  return values;
}

void to_numbers(const TileBands& bands, std::span<float> values) {
  const size_t layer = bands.shape.samples();
  std::vector<bool> filled(bands.basis.frames);
  for (int k = 0; k < bands.basis.frames; ++k) {
    const auto of_layer = values.subspan(k * layer, layer);
    filled[k] = std::any_of(of_layer.begin(), of_layer.end(), [](float v) { return v != 0; });
    if (filled[k]) synthesise(bands.shape, of_layer);
  }
  to_frames(bands.basis, values, filled);
}

} // namespace bccsplat

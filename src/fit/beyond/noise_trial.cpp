// SPDX-License-Identifier: Apache-2.0
#include "fit/beyond/noise_trial.h"

#include <algorithm>

#include "fit/beyond/ends.h"

namespace bccsplat {

NoiseTrial::NoiseTrial(int64_t n, double widening) {
  for (const double noise : end_noises) weights_.push_back(EndFrames(widening, noise).weights(1, n - 1));
}

void NoiseTrial::add(std::span<const float> row) {
  if (std::all_of(row.begin(), row.end(), [](float v) { return v == 0; })) return; // air is predicted by air
  for (size_t level = 0; level < end_noises.size(); ++level) {
    double off = -static_cast<double>(row[0]);
    for (size_t i = 1; i < row.size(); ++i) off += weights_[level][i - 1] * row[i];
    squares_[level] += off * off;
  }
}

uint8_t NoiseTrial::best(double within) const {
  size_t best = usual_noise_level;
  for (size_t level = 0; level < end_noises.size(); ++level)
    if (squares_[level] < squares_[best]) best = level;
  size_t boldest = squares_[best] == 0 ? best : 0;
  while (boldest < best && squares_[boldest] > within * squares_[best]) ++boldest;
  return static_cast<uint8_t>(boldest);
}

} // namespace bccsplat

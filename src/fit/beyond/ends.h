// SPDX-License-Identifier: Apache-2.0
// Predicts the frames beyond the ends of a series, and the samples beyond those of a row.
//
// The mirror image of a field has a kink at its end, and the interpolants of the first and last few samples
// ring with it. So samples beyond an end are predicted instead, each a fixed weighted sum of those next to
// that end: the best one, in the mean square, for waves whose frequencies fill balls (most of them far below
// Nyquist) with some noise, among those that leave a constant as it is (Wiener, Extrapolation, Interpolation
// and Smoothing of Stationary Time Series, 1949).
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "fit/axis/filter.h"

namespace bccsplat {

class EndFrames {
 public:
  // widening: as of the filter that uses the frames; what a coarser lattice holds is predicted further.
  // noise: its power over that of the field, times widening^2; weights stay the smaller the more there is.
  EndFrames(double widening, double noise);

  // Frames next to an end that a prediction looks at, when there are as many.
  [[nodiscard]] int64_t used() const { return used_; }
  [[nodiscard]] static int64_t used(double widening);
  // Weights of the frames 0, 1, .. for the one `distance` >= 1 before frame 0, of a series of at least
  // `frames`; the other end alike. They sum to 1.
  [[nodiscard]] const std::vector<double>& weights(int64_t distance, int64_t frames);

 private:
  // Returns the correlation of frames `lag` >= 0 apart.
  [[nodiscard]] double correlation(int64_t lag);

  double widening_, noise_;
  int64_t used_;
  std::vector<double> correlations_;                                 // by lag, as far as they were asked for
  std::map<std::pair<int64_t, int64_t>, std::vector<double>> known_; // by distance and frames looked at
};

// Has the positions of a table over 0 .. n-1 take no samples beyond the ends: those are replaced by what
// predicts them.
void continue_rows(FilterTable& table, int64_t n, EndFrames& ends);

} // namespace bccsplat

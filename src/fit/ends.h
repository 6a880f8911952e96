// Predicts the frames beyond the ends of a series.
//
// The mirror image of a moving field has a kink at the end of time, and the interpolants of the first and
// last few frames ring with it. So frames beyond an end are predicted instead, each a fixed weighted sum of
// the frames next to that end: the best one, in the mean square, for waves whose frequencies fill balls (most
// of them far below Nyquist) with some noise, among those that leave a constant as it is (Wiener,
// Extrapolation, Interpolation and Smoothing of Stationary Time Series, 1949).
#pragma once

#include <cstdint>
#include <map>
#include <vector>

namespace bccsplat {

class EndFrames {
 public:
  // widening: as of the filter that uses the frames; what a coarser lattice holds is predicted further.
  explicit EndFrames(double widening);

  // Frames next to an end that a prediction looks at, when there are as many.
  [[nodiscard]] int64_t used() const { return used_; }
  // Weights of the frames 0, 1, .. for the one `distance` >= 1 before frame 0, of a series of at least
  // `frames`; the other end alike. They sum to 1.
  [[nodiscard]] const std::vector<double>& weights(int64_t distance, int64_t frames);

 private:
  double widening_;
  int64_t used_;
  std::map<std::pair<int64_t, int64_t>, std::vector<double>> known_; // by distance and frames looked at
};

} // namespace bccsplat
